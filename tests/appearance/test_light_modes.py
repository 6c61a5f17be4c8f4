"""Names of modes: one coefficient, combinations, and bases that say the simple things first."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from harmonicface.appearance.light_modes import HIDDEN, LightMode, mode_name, simple_basis


def test_names() -> None:
    assert [mode_name(row) for row in np.eye(9)[[0, 1, 4, 8]]] == ["L(0,0)", "L(1,-1)", "L(2,-2)", "L(2,2)"]
    assert mode_name(np.array([-0.6, 0.0, 0.8, 0.0])) == "-0.60 L(0,0) + 0.80 L(1,0)"
    assert mode_name(np.full(16, 0.25)).endswith("0.25 L(2,-1) ...")
    assert str(LightMode(np.eye(4)[0], HIDDEN, 2)).startswith("L(0,0) (channel 2): hidden")


def test_a_basis_names_single_coefficients_first_and_spans_the_same_space() -> None:
    rng = np.random.default_rng(0)
    mixed, _ = np.linalg.qr(rng.normal(size=(4, 4)))
    space = np.zeros((5, 9))
    space[:4, [1, 3, 5, 7]] = mixed
    space[4, [0, 2]] = [0.6, -0.8]
    basis = simple_basis(space[[4, 0, 1, 2, 3]])
    assert [mode_name(row) for row in basis] == ["L(1,-1)", "L(1,1)", "L(2,-1)", "L(2,1)", "-0.60 L(0,0) + 0.80 L(1,0)"]
    assert_allclose(basis @ basis.T, np.eye(5), atol=1e-12)
    assert_allclose(basis.T @ basis, space.T @ space, atol=1e-12)
    assert simple_basis(np.zeros((0, 4))).shape == (0, 4)
