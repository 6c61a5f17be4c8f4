"""The orthographic view: where points fall, and which way angles turn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.view import View, rotation_matrix

BOX = np.array([[-2.0, -1.0, 0.0], [2.0, 1.0, 5.0]])


def test_the_bounding_box_is_shown_centred_with_square_pixels():
    view = View.fit(BOX, size=(30, 40))
    assert view.pixel_size == pytest.approx(0.1)
    assert view.frame == pytest.approx((-2, -1.5, 2, 1.5))
    np.testing.assert_allclose(view.project(BOX), [[0, 25, 0], [40, 5, 5]], atol=1e-12)


def test_a_frame_of_other_proportions_grows_about_its_centre():
    view = View.fit(BOX, size=10, frame=(0, 10, 1, 12))
    assert view.shape == (10, 10)
    assert view.frame == pytest.approx((-0.5, 10, 1.5, 12))


@pytest.mark.parametrize(
    ("rotation", "nose_goes_to", "top_goes_to"),
    [
        ((90, 0, 0), (1, 0, 0), (0, 1, 0)),  # yaw: toward the picture's right
        ((0, 90, 0), (0, -1, 0), (0, 0, 1)),  # pitch: down
        ((0, 0, 90), (0, 0, 1), (-1, 0, 0)),  # roll: counterclockwise
        ((90, 0, 90), (0, 1, 0), (-1, 0, 0)),  # yaw first, then roll
        ((90, 90, 0), (1, 0, 0), (0, 0, 1)),  # yaw first, then pitch
        ((0, 90, 90), (1, 0, 0), (0, 0, 1)),  # pitch first, then roll
    ],
)
def test_angles_turn_by_the_right_hand_rule_in_their_order(rotation, nose_goes_to, top_goes_to):
    turn = rotation_matrix(rotation)
    np.testing.assert_allclose(turn @ [0, 0, 1], nose_goes_to, atol=1e-15)
    np.testing.assert_allclose(turn @ [0, 1, 0], top_goes_to, atol=1e-15)


@given(st.tuples(*[st.floats(-360, 360)] * 3))
def test_rotations_keep_lengths_and_handedness(rotation):
    turn = rotation_matrix(rotation)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1)


@given(st.tuples(*[st.floats(-180, 180)] * 3), st.integers(1, 200), st.integers(1, 200))
def test_everything_is_in_the_picture_and_fills_it(rotation, height, width):
    points = np.random.default_rng(0).normal(size=(50, 3))
    view = View.fit(points, size=(height, width), rotation=rotation)
    pixels = view.project(points)
    assert pixels[:, :2].min() > -1e-9
    assert (pixels[:, :2].max(axis=0) < np.array([width, height]) + 1e-9).all()
    assert min(width - np.ptp(pixels[:, 0]), height - np.ptp(pixels[:, 1])) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"size": 0}, "size: expected pixels"),
        ({"size": (3, 4, 5)}, "size: expected pixels"),
        ({"size": 3.5}, "size: expected pixels"),
        ({"size": True}, "size: expected pixels"),
        ({"size": "big"}, "size: expected pixels"),
        ({"rotation": (1, 2)}, r"rotation: expected \(yaw, pitch, roll\)"),
        ({"rotation": (1, 2, np.nan)}, "rotation: expected finite"),
        ({"frame": (0, 0, 1)}, "frame: expected"),
        ({"frame": (1, 0, 0, 1)}, "frame: expected x0 < x1"),
        ({"frame": (0, 1, 1, 1)}, "frame: expected x0 < x1"),
        ({"frame": (0, 0, 1e-300, 1e-300)}, "frame: expected pixels of at least 1e-60 world units, got 1.5"),
    ],
)
def test_bad_views_are_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        View.fit(BOX, **arguments)


def test_points_that_cannot_be_framed_are_refused():
    with pytest.raises(HarmonicFaceError, match="expected some extent"):
        View.fit(np.zeros((4, 3)))
    with pytest.raises(HarmonicFaceError, match=r"points: expected pixels of at least 1e-60 .* got 6\.25e-302"):
        View.fit(BOX * 1e-300)
    with pytest.raises(HarmonicFaceError, match="expected at least one, got none"):
        View.fit(np.zeros((0, 3)))
