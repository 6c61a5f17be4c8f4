"""Windows: cameras follow what is done to their pictures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.surfaces.perspective import PerspectiveView
from harmonicface.surfaces.view import View, rotation_matrix
from harmonicface.surfaces.windows import Window, middle, through, turned

POINTS = np.random.default_rng(0).normal(size=(20, 3))
VIEWS = [
    View.fit(POINTS, (12, 20), rotation=(10.0, 20.0, 30.0)),
    PerspectiveView.fit(POINTS, (12, 20), intrinsics=(30.0, 25.0, 9.0, 7.0), distance=8.0, rotation=(10.0, 20.0, 30.0)),
]
EITHER = pytest.mark.parametrize("view", VIEWS, ids=["orthographic", "pinhole"])


@EITHER
@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(0.1, 10), st.integers(1, 30), st.integers(1, 30))
def test_points_fall_where_the_window_has_them(view, top, left, step, height, width):
    seen = through(view, Window(top, left, step, (height, width)))
    before, after = view.project(POINTS), seen.project(POINTS)
    np.testing.assert_allclose(after[:, 0], (before[:, 0] - left) / step, atol=1e-7)
    np.testing.assert_allclose(after[:, 1], (before[:, 1] - top) / step, atol=1e-7)
    np.testing.assert_array_equal(after[:, 2], before[:, 2])
    assert seen.shape == (height, width)
    assert seen.pixel_size == pytest.approx(step * view.pixel_size)


@EITHER
def test_the_whole_window_is_the_camera(view):
    seen = through(view, Window.over(view.shape, view.shape))
    np.testing.assert_array_equal(seen.project(POINTS), view.project(POINTS))


@given(st.integers(1, 50), st.integers(1, 50), st.integers(1, 50), st.integers(1, 50))
def test_a_window_over_a_picture_shows_all_of_it_in_the_middle(height, width, rows, columns):
    window = Window.over((height, width), (rows, columns))
    assert window.top <= 1e-9 and window.left <= 1e-9
    assert window.top + rows * window.step == pytest.approx(height - window.top)
    assert window.left + columns * window.step == pytest.approx(width - window.left)
    assert min(-window.top, -window.left) == pytest.approx(0, abs=1e-9)  # no larger than it must be


@EITHER
def test_the_middle_of_the_picture(view):
    for depth in (-3.0, -9.0):
        world = np.linalg.inv(view.rotation) @ (middle(view, depth) + getattr(view, "position", 0))
        np.testing.assert_allclose(view.project(world[None])[0], [10, 6, depth], atol=1e-12)


@EITHER
@given(st.floats(-180, 180), st.floats(-90, 90), st.floats(-180, 180))
def test_a_turned_camera_sees_the_turned_world(view, yaw, pitch, roll):
    matrix = rotation_matrix((yaw, pitch, roll))
    pivot = middle(view, -8.0)
    seen = turned(view, matrix, pivot).place(POINTS)
    exact = (view.place(POINTS) - pivot) @ matrix.T + pivot
    if isinstance(view, View):
        exact += matrix @ pivot - pivot  # it turns about the origin, and the frame moves along
        before, after = view.frame, turned(view, matrix, pivot).frame
        np.testing.assert_allclose(np.subtract(after, before), np.tile((matrix @ pivot - pivot)[:2], 2), atol=1e-12)
    np.testing.assert_allclose(seen, exact, atol=1e-12)
