from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.sparse import coo_array, vstack
from scipy.sparse.linalg import lsqr, spsolve

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.depth.integration import depth_from_steps, integrate_normals


def grid(height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return x (right) and y (up) from the centre."""
    rows, columns = np.mgrid[:height, :width].astype(float)
    return columns - (width - 1) / 2, (height - 1) / 2 - rows


def normals_of(right: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the unit normals of a surface with these slopes."""
    vectors = np.stack([-right, -up, np.ones_like(right)], axis=2)
    return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)


def sphere(size: int, radius: float, cap: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return normals, mask and depth of a sphere out to a share of its radius."""
    x, y = grid(size, size)
    inside = np.hypot(x, y) < cap * radius
    z = np.sqrt(np.where(inside, radius**2 - x**2 - y**2, 1.0))
    return np.where(inside[..., None], np.stack([x, y, z], axis=2) / radius, 0.0), inside, z


def centred(values: np.ndarray, mask: np.ndarray) -> np.ndarray:
    return values[mask] - values[mask].mean()


@pytest.mark.parametrize(("right", "up"), [(0, 0), (0.5, -0.25), (-3, 2)])
def test_a_plane_is_exact(right: float, up: float) -> None:
    x, y = grid(9, 14)
    depth = integrate_normals(normals_of(np.full_like(x, right), np.full_like(x, up)))
    assert_allclose(depth, right * x + up * y, atol=1e-9)


def test_a_sphere_is_exact_up_to_the_steepest_angle() -> None:
    normals, inside, z = sphere(160, 75, 0.98)  # 78.5 degrees at its rim
    depth = integrate_normals(normals)
    assert np.isnan(depth[~inside]).all()
    assert_allclose(depth[inside], centred(z, inside), atol=1e-7)


def test_a_paraboloid_converges_with_the_square_of_the_pixel() -> None:
    errors = []
    for size in (20, 40, 80):
        x, y = (coordinate / size for coordinate in grid(size, size))
        depth = integrate_normals(normals_of(-3 * x, -2 * y), pixel_size=1 / size)
        true = -1.5 * x**2 - y**2
        errors.append(np.abs(depth - (true - true.mean())).max())
    assert errors[0] < 2e-3
    assert_allclose(np.array(errors[:-1]) / errors[1:], 4, rtol=0.1)


def test_depth_is_in_world_units() -> None:
    normals, inside, _ = sphere(40, 18, 0.9)
    assert_allclose(integrate_normals(normals, inside, 0.3), 0.3 * integrate_normals(normals, inside), atol=1e-12)


def test_the_same_as_an_independent_least_squares_on_an_irregular_mask() -> None:
    random = np.random.default_rng(0)
    normals = normals_of(*random.normal(0, 0.5, (2, 15, 18)))
    mask = random.uniform(size=(15, 18)) > 0.2
    weights = random.uniform(0.1, 2, mask.shape)
    found = integrate_normals(normals, mask, weights=weights)
    for part in np.unique(part_numbers(mask)[mask]):
        own = part_numbers(mask) == part
        assert_allclose(found[own], least_squares_depth(normals, own, weights)[own], atol=1e-7)


def part_numbers(mask: np.ndarray) -> np.ndarray:
    """Number what hangs together by flooding, (h, w), 0 outside."""
    numbers, count = np.zeros(mask.shape, int), 0
    for seed in zip(*np.nonzero(mask), strict=True):
        if not numbers[seed]:
            count, front = count + 1, [seed]
            while front:
                y, x = front.pop()
                if 0 <= y < mask.shape[0] and 0 <= x < mask.shape[1] and mask[y, x] and not numbers[y, x]:
                    numbers[y, x] = count
                    front += [(y + 1, x), (y - 1, x), (y, x + 1), (y, x - 1)]
    return numbers


def least_squares_depth(normals: np.ndarray, mask: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Write each pair of neighbours as an equation, pixel by pixel, and let scipy solve them."""
    index = np.full(mask.shape, -1)
    index[mask] = np.arange(mask.sum())
    rows, steps = [], []
    for (y, x), here in np.ndenumerate(index):
        for to, axis, sign in (((y, x + 1), 0, 1), ((y + 1, x), 1, -1)):
            if here < 0 or to[0] >= mask.shape[0] or to[1] >= mask.shape[1] or index[to] < 0:
                continue
            both = normals[y, x] + normals[to]
            root = np.sqrt(2 / (1 / weights[y, x] + 1 / weights[to]))
            rows.append(coo_array(([root, -root], ([0, 0], [index[to], here])), (1, mask.sum())))
            steps.append(-root * sign * both[axis] / both[2])
    depth = np.full(mask.shape, np.nan)
    found = lsqr(vstack(rows), steps, atol=1e-14, btol=1e-14)[0] if rows else np.zeros(1)
    depth[mask] = found - found.mean()
    return depth


def test_the_same_as_a_direct_solver_and_fast() -> None:
    normals, inside, _ = sphere(192, 94, 0.97)
    random = np.random.default_rng(1)
    normals = normals + 0.1 * random.normal(size=normals.shape) * inside[..., None]
    normals = np.where(inside[..., None], normals / np.maximum(np.linalg.norm(normals, axis=2), 1e-9)[..., None], 0)
    normals = np.where((normals[..., 2:] < 0.2) & inside[..., None], [0.0, 0.0, 1.0], normals)[:, 12:180]
    inside = inside[:, 12:180]
    start = time.perf_counter()
    depth = integrate_normals(normals, inside)
    seconds = time.perf_counter() - start
    start = time.perf_counter()
    direct = direct_depth(normals, inside)
    direct_seconds = time.perf_counter() - start
    assert_allclose(depth[inside], direct - direct.mean(), atol=1e-6)
    assert seconds < 2 * direct_seconds  # it takes a quarter of it


def direct_depth(normals: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Solve the normal equations by elimination, with the first pixel held."""
    index = np.full(mask.shape, -1)
    index[mask] = np.arange(mask.sum())
    blocks, right = [], []
    for axis in (1, 0):
        first = (slice(None), slice(-1)) if axis else (slice(-1), slice(None))
        second = (slice(None), slice(1, None)) if axis else (slice(1, None), slice(None))
        both = mask[first] & mask[second]
        a, b = index[first][both], index[second][both]
        total = (normals[first] + normals[second])[both]
        right.append(-total[:, 0] / total[:, 2] if axis else total[:, 1] / total[:, 2])
        ones, rows = np.ones(len(a)), np.arange(len(a))
        blocks.append(coo_array((np.r_[ones, -ones], (np.r_[rows, rows], np.r_[b, a])), (len(a), mask.sum())))
    matrix = vstack(blocks).tocsr()
    normal = (matrix.T @ matrix).tolil()
    normal[0, 0] += 1
    return np.asarray(spsolve(normal.tocsc(), matrix.T @ np.concatenate(right)))


def test_weights_over_many_decades_reach_the_direct_solver() -> None:
    normals, inside, z = sphere(40, 19, 0.9)
    weights = 10 ** np.random.default_rng(0).uniform(-6, 6, inside.shape)
    assert_allclose(integrate_normals(normals, inside, weights=weights)[inside], centred(z, inside), atol=1e-4)


def test_a_normal_that_is_not_trusted_has_no_say() -> None:
    x, y = grid(12, 12)
    normals = normals_of(0.5 * np.ones_like(x), 0 * y)
    normals[4, 5] = [0.0, 0.8, 0.6]
    weights = np.ones_like(x)
    weights[4, 5] = 1e-6
    assert_allclose(integrate_normals(normals, weights=weights), 0.5 * x, atol=1e-4)
    assert np.abs(integrate_normals(normals) - 0.5 * x).max() > 0.1


def test_grazing_normals_are_turned_back_about_their_azimuth() -> None:
    steep = np.tile([np.sin(np.radians(89)), 0.0, np.cos(np.radians(89))], (3, 4, 1))
    backward = np.tile([np.sin(np.radians(120)), 0.0, np.cos(np.radians(120))], (3, 4, 1))
    for normals in (steep, backward):
        assert_allclose(np.diff(integrate_normals(normals, steepest=70), axis=1), -np.tan(np.radians(70)))
    assert_allclose(np.diff(integrate_normals(steep, steepest=89.5), axis=1), -np.tan(np.radians(89)))


def test_parts_that_do_not_touch_have_mean_zero_each() -> None:
    x, _ = grid(5, 9)
    mask = np.ones((5, 9), bool)
    mask[:, 4] = False
    depth = integrate_normals(normals_of(x, 0 * x), mask)
    assert_allclose([depth[:, :4].mean(), depth[:, 5:].mean()], 0, atol=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (1, 6), (6, 1)])
def test_lines_and_points(shape: tuple[int, int]) -> None:
    x, y = grid(*shape)
    assert_allclose(integrate_normals(normals_of(np.ones(shape), np.ones(shape))), x + y, atol=1e-12)


def test_steps_of_weight_zero_cut() -> None:
    depth = depth_from_steps(
        np.array([[1.0, 9.0, 1.0]]), np.zeros((0, 4)), np.array([[1.0, 0, 1]]), np.zeros((0, 4)), np.ones((1, 4), bool)
    )
    assert_allclose(depth, [[-0.5, 0.5, -0.5, 0.5]], atol=1e-12)


@given(seed=st.integers(0, 1000), angle=st.floats(0, 40))
def test_curl_free_steps_come_back(seed: int, angle: float) -> None:
    depth = np.random.default_rng(seed).normal(0, np.tan(np.radians(angle)), (6, 7))
    found = depth_from_steps(
        np.diff(depth, axis=1), np.diff(depth, axis=0), np.ones((6, 6)), np.ones((5, 7)), np.ones((6, 7), bool)
    )
    assert_allclose(found, depth - depth.mean(), atol=1e-8)


UP = np.tile([0.0, 0.0, 1.0], (3, 4, 1))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"normals": UP[0]}, r"normals: expected an array of shape \(h, w, 3\), got an array of shape \(4, 3\)"),
        ({"normals": 2 * UP}, "normals: expected unit vectors, got one of length 2"),
        ({"normals": -UP}, "normals: expected some slope, got a normal that points straight away from the camera"),
        ({"normals": np.full((3, 4, 3), np.nan)}, "normals: expected finite numbers"),
        ({"mask": np.zeros((3, 4), bool)}, "mask: expected at least one pixel in the mask"),
        ({"mask": np.ones((4, 3), bool)}, r"mask: expected a boolean mask of shape \(3, 4\)"),
        ({"pixel_size": 0.0}, "pixel_size: expected a finite number above 0, got 0"),
        ({"weights": np.ones((4, 3))}, r"weights: expected shape \(3, 4\), got an array of shape \(4, 3\)"),
        ({"weights": np.zeros((3, 4))}, "weights: expected numbers above 0 in the mask, got 0"),
        ({"weights": np.full((3, 4), np.inf)}, "weights: expected finite numbers"),
        ({"steepest": 90}, "steepest: expected degrees below 90, got 90"),
        ({"steepest": -1}, "steepest: expected a finite number above 0, got -1"),
    ],
)
def test_bad_input(arguments: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        integrate_normals(**{"normals": UP, **arguments})


@pytest.mark.parametrize("unit", [1e-300, 1e300])
def test_the_unit_of_trust_does_not_matter(unit: float) -> None:
    random = np.random.default_rng(9)
    normals = normals_of(*random.normal(size=(2, 6, 7)))
    weights = random.uniform(0.1, 1, (6, 7))
    expected = integrate_normals(normals, weights=weights)
    assert_allclose(integrate_normals(normals, weights=unit * weights), expected, atol=1e-9)
