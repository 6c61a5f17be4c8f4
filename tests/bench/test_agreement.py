"""The difference of a picture from noisy ones, known in advance."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.bench.agreement import agreement
from harmonicface.errors import HarmonicFaceError


def test_agreement_tells_difference_from_noise():
    rng = np.random.default_rng(0)
    truth = rng.uniform(0.5, 1.0, (200, 200, 3))
    ours = truth + 0.02 * rng.choice([-1, 1], truth.shape)
    noisy = [truth + rng.normal(0, 0.05, truth.shape) for _ in range(4)]
    found = agreement(ours, noisy, np.ones((200, 200), dtype=bool))
    scale = np.sqrt((truth**2).mean())
    assert found.error == pytest.approx(0.02 / scale, rel=0.03)
    assert found.noise == pytest.approx(0.025 / scale, rel=0.03)
    assert found.raw == pytest.approx(np.hypot(0.02, 0.025) / scale, rel=0.03)
    assert agreement(truth, noisy, np.ones((200, 200), dtype=bool)).error < 0.003


def test_pictures_that_tell_nothing():
    everywhere = np.ones((2, 2), dtype=bool)
    with pytest.raises(HarmonicFaceError, match="expected at least two, which tell their noise, got 1"):
        agreement(np.ones((2, 2)), [np.ones((2, 2))], everywhere)
    with pytest.raises(HarmonicFaceError, match="expected more than noise"):
        agreement(np.ones((2, 2)), [np.zeros((2, 2))] * 2, everywhere)
