"""Each ordeal does nothing at its still level, and more at farther ones."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.ordeals import ENROLMENT, ORDEALS, SIZE, Ordeal, reduced_photo

PHOTO = hf.photograph(hf.render(hf.synthetic_person(0, (192, 168)), hf.lights.directional([1, 1, 2])), 0)


@pytest.mark.parametrize("ordeal", ORDEALS, ids=lambda ordeal: ordeal.name)
def test_farther_levels_change_more(ordeal: Ordeal) -> None:
    assert ordeal.still in ordeal.levels
    assert list(ordeal.levels) == sorted(ordeal.levels)
    found = {level: ordeal.apply(PHOTO, level, (1, 2)) for level in ordeal.levels}
    np.testing.assert_array_equal(found[ordeal.still], reduced_photo(PHOTO))
    assert {photo.shape for photo in found.values()} == {SIZE}
    assert all(photo.dtype == np.float32 and photo.min() >= 0 and photo.max() <= 1 for photo in found.values())
    change = {level: float(np.abs(photo - found[ordeal.still]).mean()) for level, photo in found.items()}
    above = [change[level] for level in ordeal.levels if level >= ordeal.still]
    below = [change[level] for level in ordeal.levels[::-1] if level <= ordeal.still]
    assert above == sorted(above) and below == sorted(below)
    assert max(above[-1], below[-1]) > 0.003
    np.testing.assert_array_equal(found[ordeal.levels[0]], ordeal.apply(PHOTO, ordeal.levels[0], (1, 2)))


def test_a_shift_is_as_long_as_it_says() -> None:
    shift = next(ordeal for ordeal in ORDEALS if ordeal.name == "shift")
    dot = np.zeros((192, 168), np.float32)
    dot[96:98, 84:86] = 1
    for seed in range(4):
        down, right = np.argwhere(np.ones(SIZE)).T
        weights = shift.apply(dot, 5, (seed,)).ravel()
        centre = np.array([down @ weights, right @ weights]) / weights.sum()
        assert np.hypot(*(centre - [48, 42])) == pytest.approx(5, abs=0.05)


def test_the_number_of_enrolled_photographs_leaves_queries_alone() -> None:
    np.testing.assert_array_equal(ENROLMENT.apply(PHOTO, 1, (0,)), reduced_photo(PHOTO))


def test_levels_are_called_something() -> None:
    spelled = {ordeal.name: [ordeal.spell(level) for level in ordeal.levels] for ordeal in ORDEALS}
    assert spelled["glasses"] == ["none", "clear", "dark"]
    assert spelled["JPEG"][-2:] == ["95", "none"]
    assert spelled["noise"][:2] == ["0", "0.5"]
    assert all(len(set(words)) == len(words) for words in spelled.values())


def test_something_held_before_a_face_hides_as_much_as_it_says() -> None:
    block = next(ordeal for ordeal in ORDEALS if ordeal.name == "block before the face")
    white = np.ones((192, 168), np.float32)
    for percent in block.levels[1:]:
        changed = block.apply(white, percent, (3,)) < 0.999
        assert changed.mean() == pytest.approx(percent / 100, abs=0.03)
