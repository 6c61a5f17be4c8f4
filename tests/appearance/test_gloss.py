"""Gloss against sums over the sphere written as loops, closed forms, and what a mirror shows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.gloss import gloss, view_directions
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.io.meshes import Mesh
from harmonicface.lighting.light import Light
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.reflectance.fresnel import fresnel
from harmonicface.reflectance.materials import Material, Microfacet, Phong
from harmonicface.surfaces.mesh import surface_from_mesh

RNG = np.random.default_rng(0)
COATS = [Phong(20, 0.3), Phong(6.5, 1.0), Microfacet(0.2), Microfacet(0.15, 1.5, 0.5)]
SPECTRUM = hf.HarmonicLight(RNG.normal(size=(16, 3)))
MAP = hf.EnvironmentMap(RNG.uniform(size=(16, 32, 3)))
LAMPS = DirectionalLights(RNG.normal(size=(5, 3)), RNG.uniform(size=5))


def ball(size: int = 16) -> hf.Surface:
    """A sphere as the camera sees it: every normal that can be seen."""
    place = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(place, -place)
    mask = x**2 + y**2 < 0.98
    z = np.sqrt(np.where(mask, 1 - x**2 - y**2, 0))
    return hf.Surface(np.stack([x, y, z], axis=-1), np.full((size, size), 0.5), mask, depth=z, pixel_size=2 / size)


BALL = ball()
MIRRORED = np.array([2 * n[2] * n - np.array([0, 0, 1.0]) for n in BALL.pixel_normals])
FACING = BALL.pixel_normals[:, 2]


def sphere() -> tuple[np.ndarray, np.ndarray]:
    """Directions and solid angles of a product rule that is exact for polynomials of degree 159."""
    height, weight = np.polynomial.legendre.leggauss(80)
    turn = np.arange(160) / 160 * 2 * np.pi
    across = np.sqrt(1 - height**2)[:, None]
    towards = np.stack([across * np.cos(turn), across * np.sin(turn), height[:, None] + 0 * turn], axis=-1)
    return towards.reshape(-1, 3), np.repeat(weight * 2 * np.pi / 160, 160)


def lobe_of(coat: Material, cosines: np.ndarray) -> np.ndarray:
    """The formulas of the two lobes, written down once more."""
    above = np.maximum(cosines, 0)
    if isinstance(coat, Phong):
        return (coat.shininess + 1) / (2 * math.pi) * above**coat.shininess
    assert isinstance(coat, Microfacet)
    angle = np.arccos(np.clip(cosines, -1, 1))
    return np.exp(-((angle / 2 / coat.roughness) ** 2)) / (4 * math.pi * coat.roughness**2) * (cosines > 0)


def strength_of(coat: Material) -> np.ndarray:
    if isinstance(coat, Phong):
        return np.full(len(FACING), coat.strength)
    assert isinstance(coat, Microfacet)
    return coat.strength * fresnel(FACING, coat.refractive_index)


@pytest.mark.parametrize("coat", COATS, ids=repr)
@pytest.mark.parametrize("order", [None, 2], ids=["exact", "harmonic"])
def test_against_the_integral_over_the_sphere(coat: Material, order: int | None) -> None:
    towards, angles = sphere()
    radiance = real_harmonics(towards, 3).T @ SPECTRUM.values
    expected = [
        math.pi * strength * (lobe_of(coat, towards @ mirror) * angles) @ radiance
        for mirror, strength in zip(MIRRORED, strength_of(coat), strict=True)
    ]
    assert_allclose(gloss(BALL, SPECTRUM, coat, order), expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize("coat", COATS, ids=repr)
def test_lamps_one_by_one(coat: Material) -> None:
    expected = np.zeros(len(MIRRORED))
    towards = LAMPS.directions
    for pixel, (mirror, strength) in enumerate(zip(MIRRORED, strength_of(coat), strict=True)):
        for lamp, bright in zip(towards, LAMPS.strengths, strict=True):
            expected[pixel] += math.pi * strength * bright * lobe_of(coat, np.array(mirror @ lamp))
    assert_allclose(gloss(BALL, LAMPS, coat), expected, rtol=1e-9, atol=1e-12)


def test_a_map_pixel_by_pixel() -> None:
    coat = Microfacet(0.2)
    towards, strengths = MAP.directions.reshape(-1, 3), MAP.strengths.reshape(-1, 3)
    expected = math.pi * strength_of(coat)[:, None] * (lobe_of(coat, MIRRORED @ towards.T) @ strengths)
    assert_allclose(gloss(BALL, MAP, coat), expected, rtol=1e-9)


@pytest.mark.parametrize(
    "light", [MAP, LAMPS, SPECTRUM, hf.lights.sky(0.7), LAMPS + MAP], ids=lambda each: str(type(each))
)
def test_a_shininess_of_one_shows_the_irradiance_of_the_mirrored_normal(light: Light) -> None:
    expected = 0.25 * light.irradiance(MIRRORED)
    assert_allclose(gloss(BALL, light, Phong(1, 0.25)), expected, rtol=0, atol=0.01 * expected.max())
    if not isinstance(light, hf.lights.sky().__class__):  # discs go by harmonics
        assert_allclose(gloss(BALL, light, Phong(1, 0.25)), expected, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("order", [None, 1], ids=["exact", "harmonic"])
def test_the_same_light_from_everywhere_comes_back_in_the_coats_strength(order: int | None) -> None:
    furnace = hf.lights.ambient(0.7)
    assert_allclose(gloss(BALL, furnace, Phong(30, 0.2), order), 0.7 * 0.2, rtol=1e-12)
    kept = Microfacet(0.3).filter(0)[0]  # 0.941: the lobe beyond a right angle is cut
    assert_allclose(gloss(BALL, furnace, Microfacet(0.3), order), 0.7 * kept * fresnel(FACING, 1.4), rtol=1e-12)
    white = hf.EnvironmentMap(np.full((128, 256), 0.7 / math.pi))
    assert_allclose(gloss(BALL, white, Phong(30, 0.2), order), 0.7 * 0.2, rtol=2e-3)


@pytest.mark.parametrize("coat", [Phong(15, 1), Microfacet(0.2)], ids=repr)
def test_harmonics_tend_to_the_exact_gloss(coat: Material) -> None:
    natural = hf.lights.natural(3)
    exact = gloss(BALL, natural, coat)
    error = gloss(BALL, natural, coat, order=2) - exact
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.sqrt(np.mean(exact**2))


def smooth_map(rows: int) -> hf.EnvironmentMap:
    x, y, z = np.moveaxis(hf.EnvironmentMap(np.ones((rows, 2 * rows))).directions, -1, 0)
    return hf.EnvironmentMap(2 + x + y * z)


def test_in_the_limit_it_is_a_mirror() -> None:
    smooth = smooth_map(32)
    mirror = math.pi * smooth.radiance_toward(MIRRORED)
    assert_allclose(gloss(BALL, smooth, Phong(1e8, 1)), mirror, rtol=1e-12)
    assert_allclose(gloss(BALL, smooth, Microfacet(1e-5, 1.4)), mirror * fresnel(FACING, 1.4), rtol=1e-8)
    for shininess, error in ((1e2, 0.05), (1e3, 0.02)):  # wider than a pixel of the map
        assert_allclose(gloss(BALL, smooth, Phong(shininess, 1)), mirror, rtol=error)


def test_nothing_jumps_where_a_lobe_falls_between_the_pixels_of_a_map() -> None:
    smooth = smooth_map(64)
    border = 1 / (0.75**2 * 4 * math.pi / 64 / 128)  # 1 / shininess is the square of 0.75 pixels
    wider, narrower = (gloss(BALL, smooth, Phong(factor * border, 1)) for factor in (0.99, 1.01))
    assert_allclose(wider, narrower, rtol=0.02)


def test_a_dull_surface_with_a_coat_of_no_strength_is_matte() -> None:
    for order in (None, 2):
        for shadows in (False, True):
            picture = hf.render(BALL, LAMPS, order=order, shadows=shadows, material=Phong(20, 0))
            assert_allclose(picture, hf.render(BALL, LAMPS, order=order, shadows=shadows), rtol=0)


def test_pictures_are_matte_plus_gloss() -> None:
    coat = Phong(20, 0.3)
    coloured = hf.Surface(BALL.normals, np.repeat(BALL.albedo[..., None], 3, axis=2) * [1, 0.8, 0.6], BALL.mask)
    for surface in (BALL, coloured):
        for light in (LAMPS, SPECTRUM, LAMPS + MAP):
            expected = hf.render(surface, light)
            added = hf.render(surface, light, material=coat) - expected
            shine = gloss(surface, light, coat)
            if added.ndim == 3 and shine.ndim == 1:  # a coat has no colour
                shine = np.repeat(shine[:, None], 3, axis=1)
            assert_allclose(added[surface.mask], shine, atol=1e-12)
            assert not added[~surface.mask].any()


def test_single_precision_stays_single() -> None:
    single = hf.Surface(BALL.normals.astype(np.float32), BALL.albedo.astype(np.float32), BALL.mask)
    for order in (None, 2):
        for light in (LAMPS, MAP, SPECTRUM):
            found = gloss(single, light, Phong(20, 0.3), order)
            assert found.dtype == np.float32
            assert_allclose(found, gloss(BALL, light, Phong(20, 0.3), order), rtol=1e-3, atol=1e-4)


def test_the_view_of_a_surface_without_scene_is_z() -> None:
    assert (view_directions(BALL) == [0, 0, 1]).all()


def test_a_pinhole_sees_what_it_mirrors_from_where_it_stands() -> None:
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    wall = Mesh(
        corners,
        np.array([[0, 1, 2], [0, 2, 3]]),
        np.tile([0, 0, 1.0], (4, 1)),
        None,
        (),
        np.full(2, -1),
        np.ones((4, 3)),
    )
    near = surface_from_mesh(wall, 9, intrinsics=(9.0, 9.0, 4.5, 4.5), distance=2.0)
    view = view_directions(near)
    places = np.argwhere(near.mask)
    for (row, column), toward in zip(places, view, strict=True):
        x, y = (column - 4) * 2 / 9, (4 - row) * 2 / 9  # on the wall, two units before the pinhole
        assert_allclose(toward, np.array([-x, -y, 2]) / np.sqrt(x * x + y * y + 4), atol=1e-12)
    lamp = hf.lights.directional([0.3, 0, 1])
    bright = np.zeros(near.shape)
    bright[near.mask] = gloss(near, lamp, Phong(500, 1))
    row, column = np.unravel_index(bright.argmax(), bright.shape)
    assert row == 4
    assert column == 4 + round(0.3 * 9)  # where R = (0.3, 0, 1): right of the middle, x = 0.6


@pytest.mark.parametrize("coat", [None, 20, "wet", Phong])
def test_what_is_no_material(coat: object) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="material: expected Phong or Microfacet, got"):
        gloss(BALL, LAMPS, coat)  # type: ignore[arg-type]


def test_lobes_too_narrow_for_harmonics() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="expected a lobe wide enough for harmonics"):
        gloss(BALL, LAMPS, Phong(1e6, 1), order=2)


@pytest.mark.parametrize("coat", [Phong(30, 1), Microfacet(0.15)], ids=repr)
def test_fine_pixels_of_a_map_are_put_together(coat: Material) -> None:
    fine = hf.EnvironmentMap(RNG.uniform(size=(200, 400)) ** 20)
    expected = math.pi * strength_of(coat) * (lobe_of(coat, MIRRORED @ fine.lamps()[0].T) @ fine.lamps()[1])
    found = gloss(BALL, fine, coat)
    assert np.linalg.norm(found - expected) < 1.5e-3 * np.linalg.norm(expected)
