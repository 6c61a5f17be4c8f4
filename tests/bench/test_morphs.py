"""Morphs are as many distinct people as there are pairs."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.morphs import morphs
from harmonicface.errors import HarmonicFaceError

PEOPLE = [hf.synthetic_person(number, 16) for number in range(5)]


def test_every_pair_comes_once() -> None:
    pictures = {person.albedo.tobytes() for person in morphs(PEOPLE, 10)}
    assert len(pictures) == 10


def test_a_morph_is_halfway() -> None:
    first = next(morphs(PEOPLE, 1))
    both = PEOPLE[0].mask & PEOPLE[1].mask
    np.testing.assert_array_equal(first.mask, both)
    np.testing.assert_allclose(first.albedo[both], ((PEOPLE[0].albedo + PEOPLE[1].albedo) / 2)[both])
    towards = [np.einsum("ij,ij->i", first.normals[both], one.normals[both]) for one in PEOPLE[:2]]
    np.testing.assert_allclose(*towards, atol=1e-5)


@pytest.mark.parametrize("count", [0, 11])
def test_more_than_pairs_are_refused(count: int) -> None:
    with pytest.raises(HarmonicFaceError, match="count: expected"):
        list(morphs(PEOPLE, count))
