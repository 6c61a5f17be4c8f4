"""Texture told from light: what is told exactly, what faces lose, and the ambiguity, shown on a pair."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.appearance.texture_separation import AMBIGUITY, separate_texture


def ball(size: int = 48) -> hf.Surface:
    """Return pixels with normals in all directions."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(size, size, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return hf.Surface(normals, rng.choice([0.4, 0.6], (size, size)))


LIGHT = hf.HarmonicLight([3.0, 0.5, 0.8, -0.4, 0.1, 0.2, 0.3, -0.2, 0.1])


def test_texture_that_does_not_follow_the_normal_comes_back() -> None:
    surface = ball()
    split = separate_texture(hf.render(surface, LIGHT), surface, mean_albedo=float(surface.albedo.mean()))
    assert split.told.all()
    assert_allclose(split.texture.mean(), surface.albedo.mean())
    assert np.sqrt(np.mean((split.texture - surface.albedo) ** 2)) < 0.03 * 0.5
    assert_allclose(split.texture * split.shading, hf.render(surface, LIGHT), atol=1e-12)
    assert_allclose(split.estimate.light.irradiance(surface.normals), split.shading, atol=1e-12)
    assert split.ambiguity == AMBIGUITY


def test_an_even_surface_is_split_exactly() -> None:
    surface = ball()
    even = hf.Surface(surface.normals, np.full((48, 48), 0.3))
    split = separate_texture(hf.render(even, LIGHT), even, mean_albedo=0.3)
    assert_allclose(split.texture, 0.3, rtol=1e-9)
    assert_allclose(split.estimate.coefficients, LIGHT.values, rtol=1e-8, atol=1e-9)


def test_texture_that_follows_the_normal_is_taken_for_light() -> None:
    """The ambiguity as a pair: other texture under other light, the same photograph, and one answer for both."""
    surface = ball()
    other = hf.HarmonicLight([2.0, -0.3, 0.2, 0.5, 0.0, 0.1, 0.0, 0.0, 0.2])
    ratio = LIGHT.irradiance(surface.normals) / other.irradiance(surface.normals)
    assert ratio.min() > 0
    first = hf.render(hf.Surface(surface.normals, np.full((48, 48), 0.5)), LIGHT)
    second = hf.render(hf.Surface(surface.normals, 0.5 * ratio), other)
    assert_allclose(first, second, rtol=1e-12)
    assert np.ptp(ratio) > 0.5
    assert_allclose(separate_texture(second, surface).texture, 1.0, rtol=1e-9)


def test_the_scale_is_free() -> None:
    surface = ball()
    photo = np.asarray(hf.render(surface, LIGHT))
    one, two = (separate_texture(photo, surface, mean_albedo=scale) for scale in (0.5, 1.0))
    assert_allclose(two.texture, 2 * one.texture)
    assert_allclose(two.shading, one.shading / 2)
    assert_allclose(two.estimate.coefficients, one.estimate.coefficients / 2)


def test_faces() -> None:
    """On faces under natural light the texture is told to half of the error that the photograph itself has."""
    ratios = []
    for seed in range(6):
        face = hf.synthetic_person(seed, 48)
        photo = np.asarray(hf.render(face, hf.lights.natural(seed)))
        truth = face.albedo[face.mask]
        split = separate_texture(photo, face, mean_albedo=float(truth.mean()))
        ours = np.sqrt(np.mean((split.texture[face.mask] - truth)[split.told[face.mask]] ** 2))
        raw = np.sqrt(np.mean((photo[face.mask] * truth.mean() / photo[face.mask].mean() - truth) ** 2))
        ratios.append(ours / raw)
    assert np.median(ratios) < 0.5


def test_colour_and_masks() -> None:
    surface = ball(32)
    white = np.repeat(surface.albedo[..., None], 3, axis=2) * [1.0, 0.8, 0.5]
    coloured = hf.Surface(surface.normals, white)
    mask = np.ones((32, 32), bool)
    mask[:4] = False
    split = separate_texture(hf.render(coloured, LIGHT), surface, mask=mask)
    assert split.texture.shape == split.shading.shape == (32, 32, 3)
    assert_array_equal(split.told, mask)
    assert_array_equal(split.texture[:4], 0)
    assert_allclose(split.texture[mask].mean(axis=0), 1)


def test_what_is_too_dark_is_not_told() -> None:
    surface = ball(32)
    split = separate_texture(hf.render(surface, hf.lights.directional([0, 0, 1])), surface)
    assert 0.4 < split.told.mean() < 0.95
    assert_array_equal(split.texture[~split.told], 0)
    assert np.isfinite(split.texture).all()


def test_bad_input() -> None:
    surface = ball(8)
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected shape"):
        separate_texture(np.ones((8, 9)), surface)
    for photo in (np.zeros((8, 8)), -np.ones((8, 8)), np.ones((8, 8, 3)) * [1, 0, 1]):
        with pytest.raises(hf.HarmonicFaceError, match="photo: expected intensities of at least 0 and some light"):
            separate_texture(photo, surface)
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected finite numbers"):
        separate_texture(np.full((8, 8), np.nan), surface)
    with pytest.raises(hf.HarmonicFaceError, match="mean_albedo: expected a finite number above 0"):
        separate_texture(np.ones((8, 8)), surface, mean_albedo=0.0)
    with pytest.raises(hf.HarmonicFaceError, match="spread: expected a finite number above 0"):
        separate_texture(np.ones((8, 8)), surface, spread=-1.0)
    half = hf.Surface(surface.normals, surface.albedo, np.tri(8, dtype=bool))
    with pytest.raises(hf.HarmonicFaceError, match="mask: expected pixels of the surface, got none"):
        separate_texture(np.ones((8, 8)), half, mask=~np.tri(8, dtype=bool))
