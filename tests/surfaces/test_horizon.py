"""Horizons against closed forms and against a slow twin that walks every line of sight."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from harmonicface import HarmonicFaceError
from harmonicface.surfaces._terrain import octaves
from harmonicface.surfaces.horizon import horizon_slopes, horizons, tangent_plane

AZIMUTHS = 2 * np.pi * np.arange(16) / 16


def slow_horizons(depth: np.ndarray, pixel_size: float, azimuths: np.ndarray) -> np.ndarray:
    """The same, a pixel, an azimuth and a step at a time."""
    mask = ~np.isnan(depth)
    return np.array(
        [[_slow_horizon(depth / pixel_size, *pixel, azimuth) for pixel in np.argwhere(mask)] for azimuth in azimuths]
    )


def _slow_horizon(heights: np.ndarray, row: int, column: int, azimuth: float) -> float:
    down, right = -math.sin(azimuth), math.cos(azimuth)
    mirrored = heights[:, ::-1], row, heights.shape[1] - 1 - column, down, -right
    return math.atan(
        max(
            _past_rows(heights, row, column, down, right),
            _past_rows(heights.T, column, row, right, down),
            _past_diagonals(heights, row, column, down, right, ties=False),
            _past_diagonals(*mirrored, ties=True),
        )
    )


def _past_diagonals(heights: np.ndarray, row: int, column: int, down: float, right: float, ties: bool) -> float:
    """Past the first four diagonals from the upper left to the lower right of squares."""
    best = -math.inf
    for number in range(1, 5 if abs(down - right) > 1e-9 else 1):
        distance = number / abs(down - right)
        r, c = row + distance * down, column + distance * right
        top, left = math.floor(r + 1e-9), math.floor(c + 1e-9)
        part = r - top
        if part < 1e-9 or not (0 <= top < heights.shape[0] - 1 and 0 <= left < heights.shape[1] - 1):
            continue
        a, b, c, d = heights[top : top + 2, left : left + 2].ravel()
        one_is_missing = math.isnan(b) != math.isnan(c)
        if one_is_missing or abs(d - a) < abs(b - c) or (ties and abs(d - a) == abs(b - c)):
            z = a + part * (d - a)
            best = best if math.isnan(z) else max(best, (z - heights[row, column]) / distance)
    return best


def _past_rows(heights: np.ndarray, row: int, column: int, down: float, right: float) -> float:
    best = -math.inf
    for step in range(1, heights.shape[0] if abs(down) > 1e-9 else 0):
        r = row + step * round(math.copysign(1, down))
        c = column + step * right / abs(down)
        c = round(c) if abs(c - round(c)) < 1e-9 else c  # through the pixel's centre
        low, high = math.floor(c), math.ceil(c)
        if not (0 <= r < heights.shape[0] and low >= 0 and high < heights.shape[1]):
            continue
        z = heights[r, low] + (c - low) * (heights[r, high] - heights[r, low])
        if not math.isnan(z):
            best = max(best, (z - heights[row, column]) / math.hypot(step, c - column))
    return best


@given(
    arrays.arrays(np.float64, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=st.floats(-9, 9)),
    st.integers(0, 2**49 - 1),
    st.sampled_from([0.25, 1.0, 40.0]),
)
def test_like_the_slow_twin_on_any_depth_with_any_holes(depth, holes, pixel_size):
    depth[np.array([holes >> bit & 1 for bit in range(depth.size)], dtype=bool).reshape(depth.shape)] = np.nan
    if np.isnan(depth).all():
        depth[0, 0] = 0
    expected = slow_horizons(depth, pixel_size, AZIMUTHS)
    np.testing.assert_allclose(horizons(depth, None, pixel_size, AZIMUTHS), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("shape", [(50, 7), (7, 50), (24, 25)])
def test_like_the_slow_twin_where_every_row_is_looked_at(shape):
    rng = np.random.default_rng(0)
    depth = 3 * rng.normal(size=shape)
    depth[rng.random(shape) < 0.1] = np.nan
    some = rng.uniform(-7, 7, 5)
    np.testing.assert_allclose(horizons(depth, None, 1.0, some), slow_horizons(depth, 1.0, some), rtol=0, atol=1e-9)


@given(
    arrays.arrays(np.float64, st.tuples(st.integers(2, 9), st.integers(2, 9)), elements=st.integers(-4, 4)),
    st.integers(0, 99),
)
def test_tangent_planes_are_a_floor_and_nothing_else(depth, seed):
    # whole numbers make many slopes equal, and normals of either sign leave floors above and below the horizons
    normals = np.random.default_rng(seed).normal(size=(depth.size, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mask = np.ones(depth.shape, dtype=bool)
    some = AZIMUTHS[::3]
    free, floored = horizon_slopes(depth, mask, 1.0, some), horizon_slopes(depth, mask, 1.0, some, normals)
    for azimuth, slopes, above in zip(some, free, floored, strict=True):
        np.testing.assert_allclose(above, np.maximum(slopes, tangent_plane(normals, azimuth)), rtol=1e-12, atol=1e-12)


def test_a_wall_next_to_a_plane():
    depth = np.zeros((41, 60))
    depth[:, 50:] = 7.0
    across = horizons(depth, None, 1.0, [0.0, np.pi / 6, np.pi]).reshape(3, 41, 60)
    distance = 50 - np.arange(50)
    np.testing.assert_allclose(across[0, 20, :50], np.arctan(7 / distance), rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        across[1, 40, :50], np.arctan(7 * np.cos(np.pi / 6) / distance), rtol=0, atol=1e-12
    )  # upward to the right the wall is farther away
    np.testing.assert_array_equal(across[2, :, 1:50], 0)
    np.testing.assert_array_equal(across[2, :, 0], -np.pi / 2)
    np.testing.assert_array_equal(across[2, :, 51:], 0)
    np.testing.assert_allclose(across[2, :, 50], -np.arctan(7 / 50), atol=1e-12)  # past the plane's far end
    np.testing.assert_array_equal(across[0, :, -1], -np.pi / 2)


def test_a_groove_sees_its_other_side_up_to_the_edge():
    x = np.arange(-20, 21.0)
    depth = np.tile(0.5 * np.abs(x), (3, 1))
    right, left = horizons(depth, None, 1.0, [0.0, np.pi]).reshape(2, 3, 41)
    on_the_left = x < 0
    expected = np.arctan(0.5 * (20 - np.abs(x)) / (20 + np.abs(x)))
    np.testing.assert_allclose(right[1, on_the_left], expected[on_the_left], rtol=0, atol=1e-12)
    np.testing.assert_allclose(left[1, 1:20], np.arctan(0.5), rtol=0, atol=1e-12)


@pytest.mark.parametrize("azimuth", [0.0, 0.4, np.pi / 4, 1.3])
def test_a_ball_on_a_plane_stands_as_high_as_its_tangent(azimuth):
    radius, distance = 15.0, 40.0
    y, x = 60 - np.mgrid[:121, :121][0], np.mgrid[:121, :121][1] - 60.0
    depth = np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0))
    start = np.round([60 + distance * np.sin(azimuth), 60 - distance * np.cos(azimuth)]).astype(int)
    towards = 60 - start
    found = horizons(depth, None, 1.0, [np.arctan2(-towards[0], towards[1])]).reshape(121, 121)[tuple(start)]
    np.testing.assert_allclose(found, np.arcsin(radius / np.hypot(*towards)), rtol=0.01)


def test_the_inside_of_a_bowl_is_closed_by_its_rim():
    y, x = np.mgrid[-30:31, -30:31]
    depth = 50 - np.sqrt(50.0**2 - x**2 - y**2)
    depth[x**2 + y**2 > 30**2] = np.nan
    inside = ~np.isnan(depth)
    at_the_bottom = horizons(depth, inside, 1.0, [0.0, np.pi / 2])[:, np.flatnonzero(inside.ravel()) == 30 * 61 + 30]
    np.testing.assert_allclose(at_the_bottom, np.arctan((50 - 40) / 30), rtol=0, atol=1e-12)


def test_a_quarter_turn_turns_the_horizons():
    depth = np.random.default_rng(1).normal(size=(23, 31))
    upright = horizons(depth, None, 1.0, AZIMUTHS).reshape(-1, 23, 31)
    turned = horizons(np.rot90(depth), None, 1.0, AZIMUTHS + np.pi / 2).reshape(-1, 31, 23)
    np.testing.assert_allclose(np.rot90(upright, axes=(1, 2)), turned, rtol=0, atol=1e-9)


def test_holes_block_nothing_and_what_is_outside_the_mask_is_not_looked_at():
    depth = np.array([[0.0, 9.0, 0.0, 1.0]])
    mask = np.array([[True, False, True, True]])
    expected = np.arctan([[1 / 3, 1.0, -np.inf]])
    for outside in (9.0, np.nan, np.inf):
        depth[0, 1] = outside
        np.testing.assert_allclose(horizons(depth, mask, 1.0, [0.0]), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("factor", [1e-30, 1e-3, 1e3, 1e30])
def test_units_do_not_matter(factor):
    depth = np.random.default_rng(2).normal(size=(20, 20))
    small = horizons(factor * depth, None, factor, AZIMUTHS)
    np.testing.assert_allclose(small, horizons(depth, None, 1.0, AZIMUTHS), rtol=0, atol=1e-12)


def test_far_from_the_origin_only_the_depth_s_own_digits_are_lost():
    depth = np.random.default_rng(3).normal(size=(20, 20))
    expected = horizons(depth, None, 1.0, AZIMUTHS)
    np.testing.assert_allclose(horizons(depth + 1e6, None, 1.0, AZIMUTHS), expected, rtol=0, atol=1e-9)
    single = horizons(depth.astype(np.float32), None, 1.0, AZIMUTHS)
    np.testing.assert_allclose(single, expected, rtol=0, atol=1e-6)


def test_a_needle_is_seen_from_near_by():
    depth = np.zeros((1, 130))
    depth[0, 0] = 10.0
    found = horizons(depth, None, 1.0, [np.pi])[0]
    np.testing.assert_allclose(found[1:65], np.arctan(10 / np.arange(1, 65)), rtol=0, atol=1e-12)


def test_a_steep_hill_far_away_is_seen_to_a_degree():
    x = np.arange(300.0)
    depth = np.tile(40 * np.exp(-(((x - 280) / 12) ** 2)), (2, 1))
    found = horizons(depth, None, 1.0, [0.0]).reshape(2, 300)[0, :250]
    exact = slow_horizons(depth[:1], 1.0, np.array([0.0]))[0, :250]
    assert (found <= exact + 1e-12).all()
    assert np.degrees(exact - found).max() < 1


def test_lines_of_sight_are_looked_at_row_by_row_and_then_at_a_32nd():
    steps = np.concatenate([np.array(octave) for octave in octaves(1000)])
    np.testing.assert_array_equal(steps[:64], np.arange(1, 65))
    assert (np.diff(steps) <= np.maximum(1, steps[:-1] / 32)).all()
    assert 1000 - steps[-1] <= 1000 / 32
    assert [list(octave) for octave in octaves(0)] == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(3), None, 1.0, [0.0]), r"depth: expected shape \(h, w\)"),
        ((np.zeros((0, 3)), None, 1.0, [0.0]), r"depth: expected shape \(h, w\)"),
        ((np.full((2, 2), np.nan), None, 1.0, [0.0]), "mask: expected at least one pixel"),
        ((np.zeros((2, 2)), np.ones((2, 3), bool), 1.0, [0.0]), "mask: expected a boolean mask"),
        ((np.array([[np.nan, 0.0]]), np.ones((1, 2), bool), 1.0, [0.0]), "depth: expected finite"),
        ((np.array([[0.0, 1e160]]), None, 1.0, [0.0]), r"depth: expected less than 1e\+150 pixels"),
        ((np.array([[0.0, 1e300]]), None, 1e-300, [0.0]), r"depth: expected less than 1e\+150 pixels"),
        ((np.zeros((2, 2)), None, 0.0, [0.0]), "pixel_size: expected"),
        ((np.zeros((2, 2)), None, 1.0, [np.nan]), "azimuths: expected finite"),
        ((np.zeros((2, 2)), None, 1.0, [[0.0]]), r"azimuths: expected shape \(a,\)"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        horizons(*arguments)
