"""Components of rendered pictures: numpy's own, and those of the analytic twin."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.principal import analytic_pca
from harmonicface.appearance.principal_empirical import empirical_pca, lamp_grid
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.sources import DirectionalLights

FACE = hf.synthetic_person(0, size=16)
DOUBLE = hf.Surface(FACE.normals.astype(np.float64), FACE.albedo.astype(np.float64), FACE.mask)
PIXELS = int(FACE.mask.sum())


def alike(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Compare components, whose signs are free."""
    signs = np.sign((found * expected).sum(axis=1, keepdims=True))
    assert_allclose(found * signs, expected, atol=tolerance * np.abs(expected).max())


@pytest.mark.parametrize("method", ["gram", "svd"])
@pytest.mark.parametrize("centered", [True, False])
@pytest.mark.parametrize("pictures", [100, 400])  # fewer than pixels, and more
def test_lamps_on_a_grid(pictures: int, centered: bool, method: str) -> None:
    found = empirical_pca(DOUBLE, 4, centered=centered, pictures=pictures, method=method)
    lamps, shares = lamp_grid("sphere", pictures)
    assert len(lamps) >= pictures and (len(lamps) > PIXELS) == (pictures == 400)
    seen = np.maximum(lamps @ DOUBLE.pixel_normals.T, 0) * DOUBLE.pixel_albedo
    mean = shares @ seen
    matrix = np.sqrt(shares)[:, None] * (seen - mean if centered else seen)
    _, singular, rows = np.linalg.svd(matrix, full_matrices=False)
    assert_allclose(found.variances, singular[:4] ** 2, rtol=1e-9)
    assert_allclose(found.total, (singular**2).sum(), rtol=1e-12)
    alike(found.components, rows[:4], 1e-6)
    assert_allclose(found.mean, mean * centered, atol=1e-12)


@pytest.mark.parametrize("lights", ["sphere", "frontal", [1.0, 0.2, 0.3, 0.1]], ids=["sphere", "frontal", "density"])
def test_the_analytic_twin(lights: str | list[float]) -> None:
    rendered, analytic = empirical_pca(DOUBLE, lights=lights), analytic_pca(DOUBLE, lights=lights)
    assert_allclose(rendered.variances, analytic.variances, rtol=0.01)
    assert_allclose(rendered.total, analytic.total, rtol=2e-3)
    assert_allclose(rendered.mean, analytic.mean, atol=2e-3)
    alike(rendered.components, analytic.components, 0.05)
    alike(rendered.lights, analytic.lights, 0.03)
    assert_allclose(rendered.mean_light, analytic.mean_light, atol=1e-3)


def test_given_lights_are_rendered_one_by_one() -> None:
    lights = [hf.lights.natural(seed) for seed in range(4)] + [hf.lights.directional([1, 0, 1], [1, 0.5, 0.2])]
    rendered, analytic = empirical_pca(DOUBLE, 3, 12, lights), analytic_pca(DOUBLE, 3, 12, lights)
    assert_allclose(rendered.variances, analytic.variances, rtol=0.005)
    assert_allclose(rendered.mean_light, analytic.mean_light, atol=1e-12)
    one = empirical_pca(DOUBLE, 3, lights=lights[0], centered=False)
    assert one.components.shape[0] == 1
    seen = hf.render(DOUBLE, lights[0])[DOUBLE.mask]
    assert_allclose(one.variances, [seen @ seen], rtol=1e-12)


def test_natural_light_is_drawn() -> None:
    rendered = empirical_pca(FACE, 3, lights="natural", pictures=150, centered=False)
    analytic = analytic_pca(FACE, 3, lights="natural", centered=False)
    assert_allclose(rendered.explained, analytic.explained, atol=0.03)
    again = empirical_pca(FACE, 3, lights="natural", pictures=150, centered=False)
    assert_allclose(rendered.variances, again.variances, rtol=1e-12)


def test_weights_and_shadows() -> None:
    weights = np.linspace(0, 2, 256).reshape(16, 16)
    rendered, analytic = empirical_pca(FACE, weights=weights), analytic_pca(FACE, weights=weights)
    assert_allclose(rendered.variances, analytic.variances, rtol=0.01)
    assert_allclose((rendered.components * weights[FACE.mask]) @ rendered.components.T, np.eye(5), atol=1e-4)
    alike(rendered.components * weights[FACE.mask], analytic.components * weights[FACE.mask], 0.05)
    lamps = [DirectionalLights(lamp[None], np.ones(1)) for lamp in lamp_grid("frontal", 30)[0]]
    shadowed = empirical_pca(FACE, 2, lights="frontal", pictures=30, shadows=True, centered=False)
    seen = np.stack([hf.render(FACE, lamp, shadows=True)[FACE.mask] for lamp in lamps])
    shares = lamp_grid("frontal", 30)[1]
    expected = np.linalg.eigvalsh((seen * shares[:, None]).T @ seen)[::-1]
    assert_allclose(shadowed.variances, expected[:2], rtol=1e-4)


def test_a_share_and_dependent_pictures() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (3, 3, 1)), np.ones((3, 3)))
    for method in ("gram", "svd"):
        assert empirical_pca(wall, method=method).components.shape == (1, 9)
        assert len(empirical_pca(FACE, 0.9, method=method).variances) == len(analytic_pca(FACE, 0.9).variances)


def test_the_grid_integrates() -> None:
    for lights in ("sphere", "frontal"):
        lamps, shares = lamp_grid(lights, 200)
        assert 200 <= len(lamps) <= 300
        assert_allclose(shares.sum(), 1, rtol=1e-12)
        assert_allclose(shares @ lamps**2, 1 / 3, rtol=1e-12)
        assert_allclose(np.linalg.norm(lamps, axis=1), 1, rtol=1e-12)
        assert lights == "sphere" or (lamps[:, 2] > 0).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "nipals"}, "method: expected one of gram, svd, got 'nipals'"),
        ({"pictures": 0}, "pictures: expected an integer of at least 1, got int 0"),
        ({"n_components": -1}, "n_components: expected an integer of at least 1"),
        ({"n_components": 0.9999999999}, "n_components: expected a share of at most"),
        ({"lights": "moonlight"}, "light: expected one of .*, got 'moonlight'"),
        ({"lights": None}, "lights: expected one of .*, got NoneType"),
        ({"lights": np.eye(4)}, r"lights: expected lights that can be rendered, got an array of shape \(4, 4\)"),
        ({"lights": [0.0, 0.0, 0.0, 0.0]}, "lights: expected a density of at least 0, and above it somewhere"),
        ({"lights": [1.0, 9.0, 0.0, 0.0]}, "lights: expected a density of at least 0, and above it somewhere"),
        ({"lights": "grace"}, "pictures: expected some that differ where pixels count, got none"),
        ({"lights": ["grace"] * 3}, "pictures: expected some that differ where pixels count, got none"),
        ({"seed": -1, "lights": "natural"}, "seed: expected an integer of at least 0"),
        ({"shadows": None}, "shadows: expected True or False, got NoneType"),
        ({"weights": np.ones(3)}, "weights: expected shape"),
    ],
)
def test_bad_arguments_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        empirical_pca(FACE, **arguments)
