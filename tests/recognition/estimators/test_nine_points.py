"""Nine points of light: real photographs, chosen by their lights, and simulated ones."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.nine_points import NinePointsReal, nearest_to_nine
from harmonicface.recognition.estimators.photograph_subspace import PhotographSubspace
from harmonicface.recognition.nine_lights import nine_lights


def everybody(lamps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    people = [hf.synthetic_person(seed, size=24) for seed in range(2)]
    taken = [hf.render(person, hf.lights.directional(lamp)).ravel() for person in people for lamp in lamps]
    return np.stack(taken), np.repeat(["ada", "bob"], len(lamps))


def test_photographs_are_chosen_by_their_lights() -> None:
    others = np.random.default_rng(0).normal([0, 0, 1], 1, (20, 3))
    near = nine_lights() + 0.01
    lamps = np.concatenate([others[:10], near, others[10:]])
    photographs, names = everybody(lamps)
    chosen = NinePointsReal().fit(photographs, names, lights=np.tile(lamps, (2, 1)))
    own = np.tile(np.arange(len(lamps)), 2)
    nine = (own >= 10) & (own < 19)
    expected = PhotographSubspace(9).fit(photographs[nine], names[nine])
    queries = photographs[~nine]
    np.testing.assert_allclose(chosen.predict_distances(queries), expected.predict_distances(queries), atol=2e-3)
    assert (chosen.predict(queries) == names[~nine]).all()


def test_each_lamp_gets_another_photograph() -> None:
    lights = np.concatenate([nine_lights()[:1], np.random.default_rng(1).normal(size=(12, 3))])
    lights /= np.linalg.norm(lights, axis=1, keepdims=True)
    assert len(set(nearest_to_nine(lights).tolist())) == 9


def test_bad_lights_are_refused() -> None:
    photographs, names = everybody(nine_lights())
    with pytest.raises(HarmonicFaceError, match=r"lights: expected shape \(18, 3\)"):
        NinePointsReal().fit(photographs, names, lights=nine_lights())
    with pytest.raises(HarmonicFaceError, match="expected at least nine of ada, got 8"):
        NinePointsReal().fit(photographs[1:], names[1:], lights=np.tile(nine_lights(), (2, 1))[1:])
