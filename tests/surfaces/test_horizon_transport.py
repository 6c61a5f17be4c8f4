"""Transport of depth maps against closed forms, a slow twin and rays through the triangles between the pixels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from harmonicface import HarmonicFaceError, Surface, surface_from_depth, synthetic_person
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.quadrature import project
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.surfaces.depth_mesh import mesh_from_depth, pixel_positions
from harmonicface.surfaces.horizon import horizons
from harmonicface.surfaces.horizon_transport import horizon_transport

ORDER = 4
UP = np.array([0.0, 0.0, 1.0])


def unshadowed(surface: Surface, order: int = ORDER) -> np.ndarray:
    normals = surface.pixel_normals.astype(np.float64)
    return lambertian_weights(order)[:, None] * real_harmonics(normals, order)


def relative(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


def rough(seed: int, shape: tuple[int, int] = (16, 16), height: float = 2.0) -> Surface:
    return surface_from_depth(height * np.random.default_rng(seed).normal(size=shape))


def twin(surface: Surface, order: int, azimuths: int) -> np.ndarray:
    """Transport by a sum over directions: a ring of azimuths, and Gauss-Legendre nodes between horizon and zenith."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    angles = 2 * np.pi * np.arange(azimuths) / azimuths
    heights = horizons(surface.depth, surface.mask, surface.pixel_size, angles)
    total = np.zeros(((order + 1) ** 2, heights.shape[1]))
    for azimuth, row in zip(angles, heights, strict=True):
        for pixel, (low, normal) in enumerate(zip(row, surface.pixel_normals, strict=True)):
            e = low + (np.pi / 2 - low) * (nodes + 1) / 2
            towards = np.stack([np.cos(e) * np.cos(azimuth), np.cos(e) * np.sin(azimuth), np.sin(e)], axis=1)
            part = np.maximum(towards @ normal, 0) * np.cos(e) * weights * (np.pi / 2 - low) / 2
            total[:, pixel] += real_harmonics(towards, order) @ part
    return total * 2 * np.pi / azimuths


@pytest.mark.parametrize("normal", [UP, [0.6, 0.0, 0.8], [-0.48, 0.6, 0.64], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_wall_of_equal_normals_is_exact(normal, dtype):
    normals = np.tile(np.array(normal, dtype), (9, 11, 1))
    rows, columns = np.mgrid[:9, :11]
    depth = np.zeros((9, 11))
    if normal[2] > 0:
        depth = (-normal[0] * columns + normal[1] * rows) / normal[2]
    else:
        depth[:] = np.arange(99).reshape(9, 11) * (normal[2] == 0)  # whatever the depth, horizons stay below 90 degrees
        normals, depth = normals[4:5, 5:6], depth[4:5, 5:6]
    surface = Surface(normals, np.ones(depth.shape), depth=depth)
    found = horizon_transport(surface, 8)
    assert found.dtype == dtype
    np.testing.assert_allclose(found, unshadowed(surface, 8), rtol=0, atol=3e-7 if dtype == np.float32 else 1e-14)


def test_a_ball_is_nowhere_in_its_own_way():
    y, x = np.mgrid[31.5:-32:-1, -31.5:32] / 30
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    mask = z > 0.1
    surface = Surface(np.where(mask[..., None], np.stack([x, y, z], axis=2), 0), np.ones(z.shape), mask, 30 * z)
    np.testing.assert_allclose(horizon_transport(surface, ORDER), unshadowed(surface), rtol=0, atol=1e-14)


def test_a_plane_beside_an_endless_step():
    # T_00 / Y_00 is the sum of cos^2 h / 2 over azimuths, tan h = a cos phi on one side: pi / 2 (1 + 1 / sqrt(1 + a^2))
    depth = np.zeros((401, 50))
    depth[:, 25:] = 15.0
    surface = Surface(np.tile(UP, (401, 50, 1)), np.ones(depth.shape), depth=depth)
    found = horizon_transport(surface, 0, azimuths=128).reshape(401, 50)[200, :25]
    a = 15 / (25 - np.arange(25))
    expected = np.pi / 2 * (1 + 1 / np.sqrt(1 + a**2)) / np.sqrt(4 * np.pi)
    np.testing.assert_allclose(found, expected, rtol=0.004)
    np.testing.assert_allclose(found[:15], expected[:15], rtol=5e-4)


def test_the_bottom_of_a_groove_sees_an_open_angle():
    # slopes of 45 degrees on both sides, endless: tan h = |cos phi|, T_00 / Y_00 is the integral of cos^2 h / 2
    depth = np.tile(np.abs(np.arange(-40.0, 41)), (161, 1))
    surface = Surface(np.tile(UP, (161, 81, 1)), np.ones(depth.shape), depth=depth)
    found = horizon_transport(surface, 0, azimuths=128).reshape(161, 81)[80, 40]
    np.testing.assert_allclose(found, np.pi / np.sqrt(2) / np.sqrt(4 * np.pi), rtol=2e-4)


@pytest.mark.parametrize("order", [0, 8])
def test_like_a_sum_over_directions_with_the_same_azimuths(order):
    surface = rough(1, (5, 6))
    # the sum cuts the clamped cosine where the nodes happen to be; the unshadowed part has its own error in azimuth
    found = horizon_transport(surface, order, azimuths=96)
    assert relative(found, twin(surface, order, 96)) < 5e-4


def test_like_rays_through_the_triangles_between_the_pixels():
    pytest.importorskip("embreex")
    surface = synthetic_person(3, size=64)
    some = np.flatnonzero(np.random.default_rng(0).random(int(surface.mask.sum())) < 0.15)
    found = horizon_transport(surface, ORDER)[:, some]
    lesser = traced(surface, some, mesh_from_depth(surface, steepest=90).faces)
    assert relative(found, lesser) < 0.004
    assert relative(unshadowed(surface)[:, some], lesser) > 0.1
    one, other = (traced(surface, some, squares(surface, rising)) for rising in (True, False))
    assert relative(found, lesser) < relative(one, other) / 2  # what depends on how squares are divided


def squares(surface: Surface, rising: bool) -> np.ndarray:
    """The triangles between pixels, all squares divided along the same diagonal."""
    number = np.full(surface.shape, -1)
    number[surface.mask] = np.arange(surface.mask.sum())
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.stack([(a, c, b), (b, c, d)] if rising else [(a, c, d), (a, d, b)]).transpose(0, 2, 3, 1).reshape(-1, 3)
    return faces[(faces >= 0).all(axis=1)]


def traced(surface: Surface, pixels: np.ndarray, faces: np.ndarray, rays: int = 4000) -> np.ndarray:
    """Transport by rays from the corners of triangles between pixels."""
    trimesh = pytest.importorskip("trimesh")
    places = pixel_positions(surface)
    triangles = trimesh.Trimesh(places, faces, process=False)
    z = 1 - (2 * np.arange(rays) + 1) / rays
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(rays)
    towards = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)
    cosine = np.maximum(surface.pixel_normals[pixels] @ towards.T, 0)
    pixel, direction = np.nonzero(cosine)
    origins = places[pixels][pixel] + [0, 0, 1e-3 * surface.pixel_size]
    cosine[pixel, direction] *= triangles.ray.intersects_any(origins, towards[direction])
    return unshadowed(surface)[:, pixels] - 4 * np.pi / rays * real_harmonics(towards, ORDER) @ cosine.T


def test_azimuths_converge():
    surface = synthetic_person(4, size=48)
    exact = horizon_transport(surface, ORDER, azimuths=256)
    errors = [relative(horizon_transport(surface, ORDER, azimuths=number), exact) for number in (8, 16, 32, 64)]
    assert errors == sorted(errors, reverse=True)
    assert errors[2] < 0.003


@given(arrays.arrays(np.float64, (6, 7), elements=st.floats(-30, 30)), st.integers(0, 2**42 - 1))
def test_shadows_only_take_light_away(depth, holes):
    hollow = np.array([holes >> bit & 1 for bit in range(42)], dtype=bool).reshape(6, 7)
    hollow[2:4, 2:4] = False
    surface = surface_from_depth(np.where(hollow, np.nan, depth))
    found, without = horizon_transport(surface, ORDER), unshadowed(surface)
    assert np.isfinite(found).all()
    for light in LIGHTS:
        irradiance = light @ found
        assert (irradiance <= light @ without + 1e-12).all()
        assert (irradiance >= -0.02 * np.sqrt(4 * np.pi) * light[0]).all()  # 32 azimuths leave as much below nothing


# squares of functions of order 2: nowhere negative, and of order 4 exactly
LIGHTS = [
    project(lambda towards, c=c: (c @ real_harmonics(towards, 2)) ** 2, ORDER)
    for c in np.random.default_rng(0).normal(size=(5, 9))
]


def test_more_in_the_way_lets_less_through():
    rng = np.random.default_rng(5)
    depth = rng.normal(size=(12, 12))
    higher = depth.copy()
    higher[6, 6] += 8  # a needle
    normals = np.tile(UP, (12, 12, 1))
    before, after = (horizon_transport(Surface(normals, np.ones((12, 12)), depth=d), 0)[0] for d in (depth, higher))
    own = 6 * 12 + 6
    others = np.arange(144) != own
    assert (after[others] <= before[others] + 1e-12).all()
    assert after[others].sum() < before[others].sum() - 0.1
    assert after[own] >= before[own]


def test_directions_are_the_right_way_round():
    # a wall in the right of the picture, at larger x, keeps light from there, one on top of the picture from larger y
    for edge, row in ((np.s_[:, -1], 3), (np.s_[0, :], 1)):
        depth = np.zeros((9, 9))
        depth[edge] = 20.0
        found = horizon_transport(Surface(np.tile(UP, (9, 9, 1)), np.ones((9, 9)), depth=depth), 1)
        linear = found[1:].reshape(3, 9, 9)[:, 4, 4]
        assert linear[row - 1] < -0.1  # Y_1-1 = y, Y_10 = z, Y_11 = x
        assert abs(linear[{1: 2, 3: 0}[row]]) < 1e-12


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_units_do_not_matter(factor):
    surface = rough(6)
    scaled = Surface(surface.normals, surface.albedo, surface.mask, factor * surface.depth, factor * surface.pixel_size)
    np.testing.assert_allclose(horizon_transport(scaled, 4), horizon_transport(surface, 4), rtol=0, atol=1e-12)


def test_single_precision_differs_by_its_digits():
    person = synthetic_person(5, size=32)
    double = Surface(
        person.normals.astype(np.float64),
        person.albedo,
        person.mask,
        person.depth.astype(np.float64),
        person.pixel_size,
    )
    single, exact = horizon_transport(person, 8), horizon_transport(double, 8)
    assert single.dtype == np.float32 and exact.dtype == np.float64
    np.testing.assert_allclose(single, exact, rtol=0, atol=1e-6)


@pytest.mark.parametrize("pixels", range(1, 10))
def test_masks_of_a_few_pixels(pixels):
    whole = rough(7, (40, 40), height=5)
    mask = np.zeros((40, 40), dtype=bool)
    mask[10:13, 17:20].flat[:pixels] = True
    few = Surface(whole.normals, whole.albedo, mask, whole.depth, whole.pixel_size)
    found = horizon_transport(few, ORDER)
    assert found.shape == (25, pixels)
    if pixels == 1:
        np.testing.assert_allclose(found, unshadowed(few), rtol=0, atol=1e-15)
    cut = (slice(10, 13), slice(17, 20))
    alone = Surface(whole.normals[cut], whole.albedo[cut], mask[cut], whole.depth[cut], whole.pixel_size)
    np.testing.assert_allclose(found, horizon_transport(alone, ORDER), rtol=0, atol=1e-14)


def test_a_spike_one_pixel_wide():
    depth = np.zeros((21, 21))
    depth[10, 10] = 1e9
    found = horizon_transport(Surface(np.tile(UP, (21, 21, 1)), np.ones((21, 21)), depth=depth), ORDER)
    images, open_sky = found.reshape(25, 21, 21), lambertian_weights(ORDER) * real_harmonics(UP, ORDER)
    np.testing.assert_allclose(images[:, 10, 10], open_sky, rtol=0, atol=1e-12)  # above it all
    hidden = 1 - images[0] / open_sky[0]
    assert 0.15 < hidden[10, 11] < 0.4  # its foot is two pixels wide
    assert hidden.min() > -1e-12 and hidden[0].mean() < 0.05


def test_a_step_and_holes():
    depth = np.zeros((41, 21))
    depth[:, 15:] = -1e6
    depth[3:6, 3:6] = np.nan
    surface = Surface(np.tile(UP, (41, 21, 1)), np.ones((41, 21)), ~np.isnan(depth), depth)
    images = np.full((25, 41, 21), np.nan)
    images[:, surface.mask] = horizon_transport(surface, ORDER)
    open_sky = lambertian_weights(ORDER) * real_harmonics(UP, ORDER)
    above = surface.mask[:, :15]
    np.testing.assert_allclose(images[:, :, :15][:, above], np.tile(open_sky[:, None], above.sum()), rtol=0, atol=1e-12)
    half = images[0, 20, 15] / open_sky[0] - 1 / 2  # of the sky is left, and two of 32 azimuths go along the step
    assert -1e-9 < half < 1 / 32 + 1e-9


def test_what_is_outside_the_mask_keeps_no_light_away():
    surface = rough(8)
    mask = surface.mask.copy()
    mask[:, 8] = False
    depth = np.where(mask, surface.depth, 1e5)
    cut = Surface(surface.normals, surface.albedo, mask, depth)
    left = Surface(surface.normals[:, :8], surface.albedo[:, :8], mask[:, :8], depth[:, :8])
    right_free = horizon_transport(left, 0)[0].reshape(16, 8)
    both = horizon_transport(cut, 0)[0].reshape(16, 15)[:, :8]
    assert (both <= right_free + 1e-12).all()
    assert both.mean() > 0.8 * right_free.mean()


def test_no_pixels_are_lost_in_large_pictures():
    surface = rough(9, (70, 300), height=3)  # more than one band and one block
    part = (slice(0, 70), slice(0, 70))
    small = Surface(surface.normals[part], surface.albedo[part], surface.mask[part], surface.depth[part])
    whole = horizon_transport(surface, 2).reshape(9, 70, 300)
    assert (whole[0, :, :70] <= horizon_transport(small, 2)[0].reshape(70, 70) + 1e-12).all()


def test_without_depth():
    with pytest.raises(HarmonicFaceError, match="surface: expected one with depth, got none"):
        horizon_transport(Surface(np.tile(UP, (2, 2, 1)), np.ones((2, 2))), 2)


@pytest.mark.parametrize(
    ("order", "azimuths", "message"),
    [(-1, 32, "order: expected"), (2, 2, "azimuths: expected an integer of at least 3")],
)
def test_bad_arguments(order, azimuths, message):
    with pytest.raises(HarmonicFaceError, match=message):
        horizon_transport(rough(0), order, azimuths)
