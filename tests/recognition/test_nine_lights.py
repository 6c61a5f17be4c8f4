"""Nine lamps: as published, and as chosen from Surfaces."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.nine_lights import choose_lights, lamp_pictures, nine_lights, nine_points


def unexplained(person: hf.Surface, lamps: np.ndarray, seen: np.ndarray) -> float:
    """Share of the energy of pictures under many lamps that those under a few do not span."""
    rows = np.linalg.svd(lamp_pictures(person, lamps), full_matrices=False)[2]
    pictures = lamp_pictures(person, seen)
    return float(1 - np.linalg.norm(pictures @ rows.T) ** 2 / np.linalg.norm(pictures) ** 2)


def test_the_published_lamps_are_unit_vectors_in_front() -> None:
    lamps = nine_lights()
    assert lamps.shape == (9, 3) and (lamps[:, 2] > 0).all()
    np.testing.assert_allclose(np.linalg.norm(lamps, axis=1), 1)


def test_pictures_are_rendered() -> None:
    person = hf.synthetic_person(0, size=24)
    expected = [hf.render(person, hf.lights.directional(lamp))[person.mask] for lamp in nine_lights()]
    np.testing.assert_allclose(nine_points(person), expected, atol=1e-5)


def test_chosen_lamps_span_more_than_random_ones() -> None:
    random = np.random.default_rng(0)
    person, other = hf.synthetic_person(0, size=24), hf.synthetic_person(1, size=24)
    seen = random.normal(size=(60, 3))
    seen[:, 2] = np.abs(seen[:, 2])
    seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    lamps = choose_lights([person, other])
    assert len(np.unique(lamps, axis=0)) == 9
    by_chance = [unexplained(person, seen[random.permutation(60)[:9]], seen) for _ in range(20)]
    assert unexplained(person, lamps, seen) < np.median(by_chance)
    assert unexplained(person, nine_lights(), seen) < np.median(by_chance)


def test_the_first_lamp_is_the_most_harmonic_and_the_next_adds_most() -> None:
    person = hf.synthetic_person(0, size=24)
    candidates = nine_lights()
    pictures = lamp_pictures(person, candidates).astype(float)
    pictures /= np.linalg.norm(pictures, axis=1, keepdims=True)
    harmonics = np.linalg.svd(hf.harmonic_images(person).astype(float), full_matrices=False)[2]
    away = np.linalg.norm(pictures - pictures @ harmonics.T @ harmonics, axis=1)
    first = int(away.argmin())
    beside = np.linalg.norm(pictures - np.outer(pictures @ pictures[first], pictures[first]), axis=1)
    second = int((beside / away).argmax())
    np.testing.assert_allclose(choose_lights(person, 2, candidates), candidates[[first, second]])


def test_bad_choices_are_refused() -> None:
    person = hf.synthetic_person(0, size=16)
    with pytest.raises(HarmonicFaceError, match="surfaces: expected at least one"):
        choose_lights([])
    with pytest.raises(HarmonicFaceError, match="count: expected an integer of at least 1"):
        choose_lights(person, 0)
    with pytest.raises(HarmonicFaceError, match="candidates: expected at least 9, got 3"):
        choose_lights(person, 9, np.eye(3))
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (4, 4, 1)), np.ones((4, 4)))
    with pytest.raises(HarmonicFaceError, match="expected 2 with different pictures, got 1"):
        choose_lights(wall, 2)
