"""The fast ranking against distances computed one person at a time."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from harmonicface.gallery.enrolled.enrolment import Enrolment
from harmonicface.gallery.enrolled.people_in_memory import PeopleInMemory
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.ranking import ROUNDING, displaced_shortlist, rank, shortlist
from harmonicface.recognition.subspace import Subspace

PIXELS = 30
EVERYWHERE = np.ones(PIXELS, np.bool_)
FRAME = Frame(EVERYWHERE.reshape(5, 6))


def enrolled(subspaces: Iterable[Subspace], frame: Frame = FRAME) -> PeopleInMemory:
    found = PeopleInMemory()
    found.add([(str(number), Enrolment(one, frame, "surface")) for number, one in enumerate(subspaces)])
    return found


def people(seed: int, count: int) -> tuple[PeopleInMemory, list[np.ndarray]]:
    rng = np.random.default_rng(seed)
    pictures = [rng.normal(size=(3, PIXELS)) for _ in range(count)]
    return enrolled(map(Subspace.of, pictures)), pictures


def brute(pictures: list[np.ndarray], photo: np.ndarray, good: np.ndarray) -> list[tuple[float, int]]:
    ranked = []
    for index, person in enumerate(pictures):
        seen, pixels = person[:, good], photo[good]
        rest = pixels - np.linalg.lstsq(seen.T, pixels, rcond=None)[0] @ seen
        ranked.append((float(np.linalg.norm(rest) / np.linalg.norm(pixels)), index))
    return sorted(ranked)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 15), st.booleans())
def test_the_first_are_the_first(seed: int, count: int, top: int, masked: bool) -> None:
    rows, pictures = people(seed, count)
    rng = np.random.default_rng(seed + 1)
    good = rng.permutation(PIXELS) < 20 if masked else EVERYWHERE
    photo = rng.normal(size=PIXELS)
    found = rank(rows, photo[good] / np.linalg.norm(photo[good]), good, top)
    expected = brute(pictures, photo, good)[:top]
    assert list(found.people) == [index for _, index in expected]
    assert_allclose(found.distances, [distance for distance, _ in expected], rtol=0, atol=1e-5)


def test_people_nearer_to_each_other_than_rounding_are_ordered_exactly() -> None:
    rng = np.random.default_rng(0)
    photo = rng.normal(size=PIXELS)
    photo /= np.linalg.norm(photo)
    aside = rng.normal(size=PIXELS)
    aside -= (aside @ photo) * photo
    tilts = 1e-3 * (1 + np.arange(6) / 6)[::-1]  # squared, they differ by less than the rounding of the fast product
    assert np.ptp(tilts**2) < ROUNDING
    tilted = enrolled(Subspace.of((photo + tilt * aside / np.linalg.norm(aside))[None]) for tilt in tilts)
    found = rank(tilted, photo, EVERYWHERE, 2)
    assert found.people == (5, 4)
    assert_allclose(found.distances, np.sin(np.arctan(tilts[[5, 4]])), rtol=1e-3)


@pytest.mark.parametrize("top", [1, 2, 3, 4])
def test_ties_keep_the_order_of_enrolment(top: int) -> None:
    same = Subspace.of(np.random.default_rng(1).normal(size=(3, PIXELS)))
    photo = np.ones(PIXELS) / np.sqrt(PIXELS)
    assert rank(enrolled([same] * 4), photo, EVERYWHERE, top).people == tuple(range(top))
    assert shortlist(enrolled([same] * 4), photo, EVERYWHERE, top).people == tuple(range(top))


@pytest.mark.parametrize("masked", [False, True])
def test_a_shortlist_holds_the_first(masked: bool) -> None:
    rows, pictures = people(3, 12)
    rng = np.random.default_rng(4)
    good = rng.permutation(PIXELS) < 20 if masked else EVERYWHERE
    photo = rng.normal(size=PIXELS)
    expected = sorted(index for _, index in brute(pictures, photo, good)[:5])
    found = shortlist(rows, photo[good] / np.linalg.norm(photo[good]), good, 5)
    assert list(found.people) == expected
    assert found.measured < 12
    assert list(shortlist(rows, photo[good], good, 99).people) == list(range(12))


@pytest.mark.parametrize("distance", [0.0, 0.7, 0.9, 1.0])
def test_everybody_within_a_distance(distance: float) -> None:
    rows, pictures = people(6, 12)
    photo = np.random.default_rng(7).normal(size=PIXELS)
    found = rank(rows, photo / np.linalg.norm(photo), EVERYWHERE, None, distance)
    assert list(found.people) == [who for far, who in brute(pictures, photo, EVERYWHERE) if far <= distance]


@pytest.mark.parametrize(("right", "down"), [(0, 0), (2, 0), (-1, 2), (-2, -2)])
def test_who_is_displaced_is_on_the_list_of_the_displaced(right: int, down: int) -> None:
    rng = np.random.default_rng(0)
    frame = Frame(rng.uniform(size=(24, 20)) > 0.1)
    pictures = rng.normal(size=(40, 24, 20))
    rows = enrolled([Subspace.of(picture[frame.mask][None]) for picture in pictures], frame)
    photo = np.roll(pictures[17], (down, right), axis=(0, 1))[frame.mask]
    good = rng.uniform(size=frame.pixels) > 0.1
    found = displaced_shortlist(rows, frame, photo, good, 3)
    assert len(found) == 3
    assert 17 in found
    assert displaced_shortlist(rows, frame, photo, good, 40).tolist() == list(range(40))
