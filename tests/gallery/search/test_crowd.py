"""Bounds from the stacked sketches are above what a person explains, however many are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.bound import features
from harmonicface.gallery.search.crowd import crowd
from harmonicface.gallery.search.shared_basis import Question, SharedBasis
from harmonicface.gallery.search.sketch import sketch

PIXELS = 40


@pytest.mark.parametrize("block", [1, 1 << 20])
def test_bounds_of_one_and_of_several_photographs(draw: Callable[..., Any], block: int) -> None:
    rng = np.random.default_rng(0)
    rows = draw(rng, [2, 5, 2, 5, 5, 5, 5], PIXELS, 0.3)
    basis = SharedBasis(np.linalg.qr(rng.normal(size=(PIXELS, 12)))[0].T)
    units = rng.normal(size=(3, PIXELS))
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    question, alone = Question(basis, units), Question(basis, units[1:2])
    companies = crowd([sketch(one, basis, (4, 12)) for one in rows], (4, 12))
    assert [company.people.tolist() for company in companies] == [[0, 2], [1, 3, 4, 5, 6]]
    for company in companies:
        explained = np.array([[np.sum((rows[who] @ unit) ** 2) for unit in units] for who in company.people])
        everybody, few = np.arange(len(company.people)), np.array([0, len(company.people) - 1])
        first = company.forms.T @ features(question.coordinates(4), question.left(4))
        assert (first >= explained).all()
        with patch("harmonicface.gallery.search.crowd.BLOCK", block):
            for stage, stop in enumerate((4, 12)):
                seen = question.coordinates(stop), question.left(stop)
                bounds = company.bounds(stage, everybody, *seen)
                assert (bounds >= explained).all()
                assert_allclose(company.bounds(stage, few, *seen), bounds[few], atol=1e-6)
                one = company.bounds(stage, everybody, alone.coordinates(stop), alone.left(stop))
                assert_allclose(one, bounds[:, 1:2], atol=1e-6)
                if stage == 0:  # the form has seen as many rows, and is the same bound
                    assert_allclose(bounds, first, atol=1e-4)
    assert companies[0].nbytes > sum(some.nbytes for some in companies[0].numbers if isinstance(some, np.ndarray))


def test_sketches_of_other_stages_are_not_stacked() -> None:
    with pytest.raises(HarmonicFaceError, match=r"sketches: expected stages of \(3,\) columns, got \(1, 3\)"):
        crowd([sketch(np.eye(4)[:2], SharedBasis(np.eye(4)), (1, 3))], (3,))
