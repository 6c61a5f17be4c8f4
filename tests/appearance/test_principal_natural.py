"""The table of natural light against environments drawn anew."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import harmonicface as hf
from harmonicface.appearance.principal_natural import expanded, natural_statistics, sampled, write_table
from harmonicface.harmonics.rotation import rotate


def test_the_table_is_of_natural_light() -> None:
    mean, covariance = natural_statistics()
    drawn = np.stack([hf.lights.natural(seed).coefficients(2) for seed in range(600)])
    deviation = np.sqrt(np.diag(covariance)[:9])
    assert (np.abs(drawn.mean(axis=0) - mean[:9]) < 5 * deviation / np.sqrt(600) + 1e-5).all()
    assert_allclose(drawn.std(axis=0)[1:], deviation[1:], rtol=0.15)
    correlation = np.corrcoef(drawn[:, 1:].T)
    expected = covariance[1:9, 1:9] / np.outer(deviation[1:], deviation[1:])
    assert_allclose(correlation, expected, atol=0.2)


def test_degree_0_is_the_same_for_all() -> None:
    mean, covariance = natural_statistics()
    assert_allclose(mean[0], 4 / np.sqrt(4 * np.pi), rtol=1e-6)  # of a mean irradiance of 1
    assert np.abs(covariance[0]).max() < 1e-12


def test_no_turn_about_the_vertical_matters() -> None:
    mean, covariance = natural_statistics()
    turned = Rotation.from_euler("y", 0.7)
    assert_allclose(rotate(mean, turned), mean, atol=1e-12)
    assert_allclose(rotate(rotate(covariance, turned).T, turned), covariance, atol=1e-12)
    assert np.linalg.eigvalsh(covariance)[0] > -1e-6


def test_what_is_drawn_is_summed_over_all_turns() -> None:
    mean, blocks = sampled(4, seed=1)
    whole, covariance = expanded(mean, blocks)
    rng = np.random.default_rng(1)
    lights = np.stack([hf.lights.natural(rng).coefficients(12) for _ in range(4)])
    around = [Rotation.from_euler("y", angle) for angle in 2 * np.pi * np.arange(30) / 30]
    turned = np.concatenate([rotate(lights.T, turn).T for turn in around])
    mirrored = np.concatenate([turned, turned * mirror(turned.shape[1])])  # left and right alike
    assert_allclose(whole, mirrored.mean(axis=0), atol=1e-12)
    assert_allclose(covariance, np.cov(mirrored.T, bias=True), atol=1e-12)


def mirror(size: int) -> np.ndarray:
    """Return the sign that each coefficient takes when x becomes -x."""
    point = np.array([[0.36, 0.48, 0.8]])
    order = int(np.sqrt(size)) - 1
    return np.sign((hf.real_harmonics(point * [-1, 1, 1], order) * hf.real_harmonics(point, order))[:, 0])


def test_the_text_of_a_table_holds_what_was_drawn() -> None:
    text = write_table(3, seed=5)
    mean, blocks = sampled(3, seed=5)
    assert f'"draws": 3, "seed": 5, "mean": [{mean[0]:.6g}' in text
    assert f"{blocks[12][0, 0]:.6g}"[:6] in text
