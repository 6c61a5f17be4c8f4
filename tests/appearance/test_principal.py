"""Analytic principal components against closed forms, a plain numpy oracle, and what they are made for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.linalg import subspace_angles

import harmonicface as hf
from harmonicface.appearance.principal import analytic_pca
from harmonicface.errors import HarmonicFaceError

Array = NDArray[np.float64]

FACE = hf.synthetic_person(0, size=24)
HEAD_FRAME = (-2.1, -0.2, 2.1, 4.05)  # chin to crown of the scan


def ball(size: int = 25) -> hf.Surface:
    """Return a white ball seen from the front."""
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    mask = x**2 + y**2 < 1
    normals = np.stack([x, y, z], axis=-1) * mask[..., None]
    return hf.Surface(normals, np.where(mask, 1.0, 0.0), mask)


def half_spread(count: int) -> tuple[Array, Array]:
    """Return directions with z > 0 by the midpoint rule in angles, another grid than the package's, and weights."""
    polar = (np.arange(count) + 0.5) * np.pi / 2 / count
    around = (np.arange(4 * count) + 0.25) * np.pi / 2 / count
    z, across = np.cos(polar)[:, None], np.sin(polar)[:, None]
    towards = np.stack(np.broadcast_arrays(across * np.cos(around), across * np.sin(around), z), axis=-1)
    weights = np.broadcast_to(across, towards.shape[:2]).ravel()
    return towards.reshape(-1, 3), weights / weights.sum()


def rendered_variances(surface: hf.Surface, where: str, centered: bool, weights: Array | float = 1.0) -> Array:
    """Return eigenvalues of the pictures under lamps on a grid, by numpy alone."""
    lamps, shares = half_spread(14)
    if where == "sphere":
        lamps, shares = np.concatenate([lamps, -lamps]), np.concatenate([shares, shares]) / 2
    pictures = np.maximum(lamps @ surface.pixel_normals.T.astype(np.float64), 0) * surface.grey_albedo
    if centered:
        pictures = pictures - shares @ pictures
    pictures *= np.sqrt(shares)[:, None] * np.sqrt(weights)
    short = pictures @ pictures.T if len(pictures) < pictures.shape[1] else pictures.T @ pictures
    return np.linalg.eigvalsh(short)[::-1]


@pytest.mark.parametrize("centered", [True, False])
@pytest.mark.parametrize("where", ["sphere", "frontal"])
@pytest.mark.parametrize("surface", [ball(), FACE], ids=["ball", "face"])
def test_variances_are_those_of_rendered_pictures(surface: hf.Surface, where: str, centered: bool) -> None:
    found = analytic_pca(surface, lights=where, centered=centered)
    expected = rendered_variances(surface, where, centered)
    assert_allclose(found.variances, expected[:5], rtol=0.01)
    assert_allclose(found.total, expected.sum(), rtol=2e-3)
    rough = analytic_pca(surface, order=2, lights=where, centered=centered)
    if where == "sphere":  # where degrees are independent: fewer of them, less variance
        assert (rough.variances <= found.variances * (1 + 1e-6)).all()
    assert_allclose(rough.variances, expected[:5], rtol=0.08)
    assert_allclose(rough.total, found.total, rtol=1e-12)


@pytest.mark.data
@pytest.mark.parametrize("where", ["sphere", "frontal"])
@pytest.mark.parametrize("head", ["scan", "model"])
def test_variances_of_real_heads(head: str, where: str, data_dir: Path) -> None:
    heads = data_dir / "heads"
    if head == "scan":
        seen = hf.load_surface(heads / "LeePerrySmith" / "LeePerrySmith.glb", 32, frame=HEAD_FRAME)
        surface = hf.Surface(seen.normals, seen.mask.astype(np.float32), seen.mask)
    else:
        surface = hf.ict_person(heads / "ICT-FaceKit" / "FaceXModel", 0, 32)
    found = analytic_pca(surface, lights=where)
    assert_allclose(found.variances, rendered_variances(surface, where, True)[:5], rtol=0.01)


@pytest.mark.data
def test_a_scanned_head_is_like_the_published_one(data_dir: Path) -> None:
    seen = hf.load_surface(data_dir / "heads" / "LeePerrySmith" / "LeePerrySmith.glb", 128, frame=HEAD_FRAME)
    found = analytic_pca(hf.Surface(seen.normals, seen.mask.astype(np.float32), seen.mask))
    # Ramamoorthi 2002, of another scanned face
    assert_allclose(found.explained, [0.42, 0.33, 0.16, 0.035, 0.021], atol=0.03)
    assert_allclose([found.explained[:3].sum(), found.explained.sum()], [0.91, 0.97], atol=0.01)


def test_a_whole_sphere_of_normals_has_the_filter_for_its_variances() -> None:
    directions = hf.EnvironmentMap(np.ones((40, 80)))
    share = directions.solid_angles / (4 * np.pi)
    whole = hf.Surface(directions.directions, np.ones((40, 80)))
    found = analytic_pca(whole, 8, weights=share)
    linear, quadratic = np.array([2 * np.pi / 3, np.pi / 4]) ** 2 / (4 * np.pi) ** 2
    assert_allclose(found.variances, [linear] * 3 + [quadratic] * 5, rtol=2e-3)
    assert_allclose(found.total, 1 / 6 - 1 / 16, rtol=1e-6)  # <max(c, 0)^2> - <max(c, 0)>^2


def test_a_wall_has_one_component() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (4, 5, 1)), np.full((4, 5), 0.5))
    found = analytic_pca(wall)
    assert found.components.shape == (1, 20)
    assert_allclose(np.abs(found.components), 1 / np.sqrt(20), rtol=1e-12)
    assert_allclose(found.total, 20 * 0.25 * (1 / 6 - 1 / 16), rtol=1e-6)
    assert 0.99 < found.explained[0] < 1


def test_components_are_orthonormal_and_pictures_of_their_lights() -> None:
    found = analytic_pca(FACE, 7)
    assert_allclose(found.components @ found.components.T, np.eye(7), atol=1e-5)
    lit = found.lights @ hf.harmonic_images(FACE, 4).astype(np.float64)
    assert_allclose(found.components, lit, atol=1e-5)
    assert found.components.dtype == np.float32 and found.lights.shape == (7, 25)
    assert_allclose(found.mean, hf.harmonic_images(FACE, 0)[0] / np.sqrt(4 * np.pi), rtol=1e-4)


def test_weights_count_pixels() -> None:
    weights = np.linspace(0, 3, 24 * 24).reshape(24, 24)
    each = weights[FACE.mask]
    found = analytic_pca(FACE, weights=weights)
    assert_allclose(found.variances, rendered_variances(FACE, "sphere", True, each)[:5], rtol=0.01)
    assert_allclose((found.components * each) @ found.components.T, np.eye(5), atol=1e-5)
    twice = analytic_pca(FACE, weights=np.full(FACE.shape, 2.0))
    assert_allclose(twice.variances, 2 * analytic_pca(FACE).variances, rtol=1e-6)


def test_a_pixel_without_weight_might_as_well_be_outside() -> None:
    inside = FACE.mask.copy()
    inside[:12] = False
    half = analytic_pca(hf.Surface(FACE.normals, FACE.albedo, inside))
    found = analytic_pca(FACE, weights=inside.astype(float))
    assert_allclose(found.variances, half.variances, rtol=1e-6)
    assert_allclose(np.abs((found.pictures() * half.pictures()).sum(axis=(1, 2))), 1, rtol=1e-5)


def test_shadows_take_light_away() -> None:
    lit, shadowed = analytic_pca(FACE, 5, centered=False), analytic_pca(FACE, 5, centered=False, shadows=True)
    assert shadowed.total < lit.total
    images = hf.harmonic_images(FACE, 4, shadows=True).astype(np.float64)
    expected = np.linalg.eigvalsh(images @ images.T / (4 * np.pi))[::-1]
    assert_allclose(shadowed.variances, expected[:5], rtol=1e-5)
    assert_allclose(shadowed.total, expected.sum(), rtol=1e-6)  # of the degrees up to 4
    assert_allclose(analytic_pca(FACE, 5, centered=False, bounces=1).total, shadowed.total, rtol=0.2)


def test_colour_counts_as_luminance() -> None:
    tinted = FACE.albedo[..., None] * np.array([1.0, 0.5, 0.2], np.float32)
    found = analytic_pca(hf.Surface(FACE.normals, tinted, FACE.mask))
    factor = (np.array([1.0, 0.5, 0.2]) @ [0.2126, 0.7152, 0.0722]) ** 2
    assert_allclose(found.variances, factor * analytic_pca(FACE).variances, rtol=1e-4)


def test_a_share_takes_as_few_as_explain_it() -> None:
    every = analytic_pca(FACE, 25)
    for share in (0.3, 0.9, 0.97):
        found = analytic_pca(FACE, share)
        assert found.explained.sum() >= share > found.explained[:-1].sum()
        assert_allclose(found.variances, every.variances[: len(found.variances)], rtol=1e-12)
    with pytest.raises(HarmonicFaceError, match=r"share of at most 0\.99\d\d, which all components of this order expl"):
        analytic_pca(FACE, 0.999999)


@given(st.integers(-150, 150))
def test_brightness_changes_nothing_but_the_unit(exponent: int) -> None:
    scale = 10.0**exponent
    double = hf.Surface(FACE.normals.astype(np.float64), FACE.albedo.astype(np.float64), FACE.mask)
    plain = analytic_pca(double)
    found = analytic_pca(replace_albedo(double, double.albedo * scale))
    assert_allclose(found.explained, plain.explained, rtol=1e-9)
    assert_allclose(found.variances / scale / scale, plain.variances, rtol=1e-9)
    assert_allclose(np.abs((found.components * plain.components).sum(axis=1)), 1, rtol=1e-9)


def replace_albedo(surface: hf.Surface, albedo: Array) -> hf.Surface:
    """Return a Surface with another albedo."""
    return hf.Surface(surface.normals, albedo, surface.mask)


def test_float32_is_as_good_as_float64() -> None:
    double = hf.Surface(FACE.normals.astype(np.float64), FACE.albedo.astype(np.float64), FACE.mask)
    single, exact = analytic_pca(FACE, 9), analytic_pca(double, 9)
    assert exact.components.dtype == np.float64
    assert_allclose(single.variances, exact.variances, rtol=1e-4)


def test_more_components_of_the_uncentered_span_more() -> None:
    few, many = (analytic_pca(FACE, count, centered=False).components for count in (3, 6))
    assert subspace_angles(few.T, many.T).max() < 1e-3
    # nine components and the nine harmonic images span nearly the same pictures of the second order
    nine = analytic_pca(FACE, 9, order=2, centered=False).components
    assert subspace_angles(nine.T.astype(np.float64), hf.harmonic_images(FACE).T.astype(np.float64)).max() < 1e-2


def test_natural_light_asks_for_fewer_than_lamps() -> None:
    counts = {
        lights: len(analytic_pca(FACE, 0.99, lights=lights, centered=False).variances)
        for lights in ("sphere", "frontal", "natural")
    }
    assert counts["natural"] <= counts["frontal"] <= counts["sphere"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"surface": "face"}, "surface: expected a Surface, got str 'face'"),
        ({"n_components": 0}, "n_components: expected an integer of at least 1, got int 0"),
        ({"n_components": 1.0}, "n_components: expected a count of at least 1 or a share above 0 and below 1, got 1.0"),
        ({"n_components": "five"}, "n_components: expected an integer of at least 1, got str 'five'"),
        ({"order": 13}, "order: expected 0 to 12, got 13"),
        ({"order": -1}, "order: expected an integer of at least 0, got int -1"),
        ({"centered": "yes"}, "centered: expected True or False, got str 'yes'"),
        ({"order": 0}, "lights: expected lights that differ up to order 0, got lights that are all the same"),
        ({"lights": "grace"}, "lights: expected lights that differ"),
        ({"lights": ["grace", "grace", "grace"]}, "lights: expected lights that differ"),
        ({"weights": np.ones((3, 3))}, r"weights: expected shape \(24, 24\), got an array of shape \(3, 3\)"),
        ({"weights": np.zeros((24, 24))}, "weights: expected at least 0, and more in a pixel of the mask, got 0 to 0"),
        ({"weights": np.full((24, 24), -1.0)}, "weights: expected at least 0, and more in a pixel of the mask, got -1"),
        ({"weights": np.full((24, 24), np.nan)}, "weights: expected finite numbers"),
        ({"shadows": 1}, "shadows: expected True or False, got int 1"),
        ({"bounces": -1}, "bounces: expected an integer of at least 0"),
    ],
)
def test_bad_arguments_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        analytic_pca(**{"surface": FACE, **arguments})


def test_black_surfaces_and_dark_pixels_are_refused() -> None:
    black = replace_albedo(FACE, np.zeros_like(FACE.albedo))
    with pytest.raises(HarmonicFaceError, match="albedo: expected some above 0 and within the range of numbers, got 0"):
        analytic_pca(black)
    half = FACE.albedo.copy()
    half[:12] = 0
    upper = np.zeros(FACE.shape)
    upper[:12] = 1
    with pytest.raises(HarmonicFaceError, match="pictures: expected some that differ where pixels count, got none"):
        analytic_pca(replace_albedo(FACE, half), weights=upper)


@pytest.mark.parametrize("scale", [1e-170, 1e170])
def test_variances_beyond_the_range_of_numbers_are_refused(scale: float) -> None:
    double = hf.Surface(FACE.normals.astype(np.float64), FACE.albedo.astype(np.float64) * scale, FACE.mask)
    with pytest.raises(HarmonicFaceError, match="variances: expected albedo and light within the range of numbers"):
        analytic_pca(double)


def test_the_scene_is_not_needed_without_shadows() -> None:
    assert_allclose(analytic_pca(replace_albedo(FACE, FACE.albedo)).variances, analytic_pca(FACE).variances, rtol=1e-12)
    with pytest.raises(HarmonicFaceError, match="surface: expected depth, which casts the shadows"):
        analytic_pca(replace_albedo(FACE, FACE.albedo), shadows=True)
