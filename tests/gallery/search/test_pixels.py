"""The bound from all pixels is above what a person explains, and close to it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.gallery.search.pixels import Pixels
from harmonicface.recognition.subspace import Subspace


@pytest.mark.parametrize("error", [0.0, 1e-3])
def test_closeness_is_never_below_the_projection(error: float) -> None:
    rng = np.random.default_rng(0)
    exact = np.linalg.qr(rng.normal(size=(80, 6)))[0].T
    rows = ((np.eye(6) + error * rng.normal(size=(6, 6))) @ exact).astype(np.float32)
    orthonormal = np.linalg.qr(rows.astype(np.float64).T)[0].T
    defect = float(np.linalg.norm(rows.astype(np.float64) @ rows.T.astype(np.float64) - np.eye(6)))
    units = np.concatenate([rng.normal(size=(80, 9)), exact.T], axis=1)
    units /= np.linalg.norm(units, axis=0)
    found = Pixels(lambda who: rows, np.array([defect]), 80).closeness(0, np.ascontiguousarray(units.T, np.float32))
    projected = np.square(orthonormal @ units).sum(axis=0)
    assert (found >= projected).all()
    assert_allclose(found, projected, atol=1e-4 + 4 * defect)


def test_distance_is_that_of_the_subspace() -> None:
    rows = np.linalg.qr(np.random.default_rng(0).normal(size=(20, 3)))[0].T.astype(np.float32)
    unit = np.full(20, 20**-0.5)
    assert Pixels(lambda who: rows, np.zeros(1), 20).distance(0, unit) == Subspace(rows, np.empty((3, 0))).distance(
        unit
    )
