from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.depth.integration import integrate_normals
from harmonicface.stereo.depth.perspective_integration import integrate_perspective, steps_between
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.perspective import rays

CAMERA = (300.0, 280.0, 41.0, 29.5)
SHAPE = (64, 80)
Doubles = NDArray[np.float64]


def ball_before_a_pinhole() -> tuple[Doubles, Doubles, NDArray[np.bool_]]:
    """Normals, z below 0 and mask of a ball, by intersecting each pixel's ray with it."""
    ray = -rays(CAMERA, SHAPE)
    centre, radius = np.array([0.1, 0.05, -10.0]), 1.0
    a, b, c = (ray**2).sum(axis=2), ray @ centre, centre @ centre - radius**2
    inside = b**2 - a * c > 0
    away = np.where(inside, (b - np.sqrt(np.maximum(b**2 - a * c, 0))) / a, 1.0)
    points = ray * away[..., None]
    normals = (points - centre) / radius
    facing = -(normals * points).sum(axis=2) / np.linalg.norm(points, axis=2)
    inside &= facing > np.cos(np.radians(75))
    return np.where(inside[..., None], normals, 0.0), np.where(inside, points[..., 2], np.nan), inside


def geometric_mean(depth: Doubles) -> float:
    return float(np.exp(np.log(-depth[np.isfinite(depth)]).mean()))


def test_a_ball_is_exact() -> None:
    normals, depth, inside = ball_before_a_pinhole()
    found = integrate_perspective(normals, CAMERA, distance=geometric_mean(depth))
    assert_allclose(found[inside], depth[inside], rtol=1e-9)
    assert np.isnan(found[~inside]).all()


def test_a_slanted_wall_is_exact() -> None:
    normal = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    ray = -rays(CAMERA, SHAPE)
    depth = -4 * normal[2] / -(ray @ normal)
    found = integrate_perspective(np.tile(normal, (*SHAPE, 1)), CAMERA, distance=geometric_mean(depth))
    assert_allclose(found, depth, rtol=1e-9)


def test_normals_come_back_from_the_depth() -> None:
    normals, _, inside = ball_before_a_pinhole()
    again = surface_from_depth(integrate_perspective(normals, CAMERA, inside), intrinsics=CAMERA)
    inner = again.mask & inside
    inner[1:-1, 1:-1] &= inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:]
    angle = np.degrees(np.arccos(np.clip((again.normals * normals).sum(axis=2)[inner], -1, 1)))
    assert np.median(angle) < 0.2 and inner.sum() > 500


def test_distance_scales_everything() -> None:
    normals, _, inside = ball_before_a_pinhole()
    near, far = (integrate_perspective(normals, CAMERA, distance=each)[inside] for each in (1.0, 7.0))
    assert_allclose(far, 7 * near, rtol=1e-12)


def test_a_far_camera_sees_parallel_rays() -> None:
    rows, columns = np.mgrid[:40, :50].astype(float)
    depth = 3 * np.sin(columns / 8) + 2 * np.cos(rows / 6)
    normals = np.stack([-3 / 8 * np.cos(columns / 8), -2 / 6 * np.sin(rows / 6), np.ones((40, 50))], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    focal = 1e6
    found = integrate_perspective(normals, (focal, focal, 25, 20), distance=focal)  # a pixel is one unit there
    parallel = integrate_normals(normals)
    assert_allclose(found + focal, parallel, atol=1e-3 * np.ptp(depth))


def test_weights_decide_between_normals_that_contradict() -> None:
    normals = np.tile([0.0, 0.0, 1.0], (20, 30, 1))
    normals[8:12, 10:14] = [0.8, 0, 0.6]
    weights = np.ones((20, 30))
    weights[8:12, 10:14] = 1e-4
    camera = (200.0, 200.0, 15.0, 10.0)
    trusted, doubted = (integrate_perspective(normals, camera, weights=each) for each in (None, weights))
    others = weights == 1
    assert np.ptp(doubted[others]) < 0.02 * np.ptp(trusted[others])


def test_steep_normals_are_turned_back_about_their_sight() -> None:
    normals = np.tile([1.0, 0.0, 0.0], (3, 4, 1))
    steps = steps_between(normals, None, None, steepest=45)
    assert_allclose(steps.right, -1)
    pinhole = steps_between(normals, None, None, intrinsics=(1e5, 1e5, 2, 1.5), steepest=45)
    assert_allclose(pinhole.right, 1e-5, rtol=1e-4)  # of the distance, which grows


def test_steps_of_parallel_rays_are_those_of_the_other_integration() -> None:
    normals, _, inside = ball_before_a_pinhole()
    facing = inside & (normals[..., 2] > 0.2)
    steps = steps_between(np.where(facing[..., None], normals, 0), None, None)
    found = integrate_normals(normals, facing)
    right = np.diff(found, axis=1)
    pairs = facing[:, 1:] & facing[:, :-1]
    assert_allclose(steps.right[pairs], right[pairs], atol=0.05)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"normals": np.ones((3, 4))}, r"expected an array of shape \(h, w, 3\)"),
        ({"normals": np.full((3, 4, 3), 0.5)}, "expected unit vectors"),
        ({"mask": np.zeros((3, 4), bool)}, "expected at least one pixel in the mask"),
        ({"weights": np.ones((2, 2))}, r"weights: expected shape \(3, 4\)"),
        ({"weights": np.zeros((3, 4))}, "weights: expected numbers above 0"),
        ({"intrinsics": (0, 1, 1, 1)}, "expected focal lengths above 0"),
        ({"distance": 0.0}, "distance: expected a finite number above 0"),
        ({"steepest": 90}, "steepest: expected degrees below 90"),
        ({"normals": -np.tile([0.0, 0.0, 1.0], (3, 4, 1))}, "points straight away from the camera"),
    ],
)
def test_refuses(changed: dict[str, object], message: str) -> None:
    usual: dict[str, object] = {"normals": np.tile([0.0, 0.0, 1.0], (3, 4, 1)), "intrinsics": (9e9, 9e9, 2, 1.5)}
    with pytest.raises(HarmonicFaceError, match=message):
        integrate_perspective(**{**usual, **changed})  # type: ignore[arg-type]


@pytest.mark.parametrize("unit", [1e-300, 1e300])
def test_the_unit_of_trust_does_not_matter(unit: float) -> None:
    normals, _, mask = ball_before_a_pinhole()
    weights = np.random.default_rng(9).uniform(0.1, 1, mask.shape)
    expected = integrate_perspective(normals, CAMERA, mask, weights)
    assert_allclose(integrate_perspective(normals, CAMERA, mask, unit * weights), expected, atol=1e-9)
