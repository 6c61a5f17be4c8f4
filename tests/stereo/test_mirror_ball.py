from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.mirror_ball import circle_of, mirror_ball_lights

FINER = 8
PIXEL = np.degrees(2 / 50)  # what a pixel of a ball of 50 turns the direction by, in the middle


def mirror_ball(
    lamp: NDArray[np.float64],
    circle: tuple[float, float, float],
    shape: tuple[int, int],
    degrees: float,
    room: float = 0.0,
) -> NDArray[np.float64]:
    """Render a mirror ball in a dark room with a round lamp, by reflecting the ray of each part of each pixel."""
    x, y, radius = circle
    rows, columns = (np.mgrid[: shape[0] * FINER, : shape[1] * FINER] + 0.5) / FINER
    across, up = (columns - x) / radius, (y - rows) / radius
    inside = across**2 + up**2 < 1
    normal = np.stack([across, up, np.sqrt(np.maximum(1 - across**2 - up**2, 0))], axis=-1)
    view = np.array([0.0, 0.0, 1.0])
    reflected = 2 * (normal @ view)[..., None] * normal - view
    shine = (reflected @ lamp > np.cos(np.radians(degrees))).astype(float)
    picture = np.where(inside, shine + room * (1 + reflected[..., 1]) / 2, 0.3 * room)
    return picture.reshape(shape[0], FINER, shape[1], FINER).mean(axis=(1, 3))


def lamps(count: int) -> NDArray[np.float64]:
    random = np.random.default_rng(0)
    directions = random.normal(size=(count, 3))
    directions[:, 2] = np.abs(directions[:, 2]) - 0.2  # some beside and a little behind the ball
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def degrees_between(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.degrees(np.arccos(np.clip((first * second).sum(axis=-1), -1, 1)))


# A highlight of less than two pixels across tells its place to a fifth of a pixel, larger ones better.
@pytest.mark.parametrize(("broad", "least"), [(1.5, PIXEL / 5), (6.0, PIXEL / 20)])
def test_lamps_are_found_where_they_are(broad: float, least: float) -> None:
    circle, shape = (61.3, 58.8, 50.4), (118, 124)
    truth = lamps(12)
    photos = np.stack([mirror_ball(lamp, circle, shape, broad, room=0.05) for lamp in truth])
    assert degrees_between(mirror_ball_lights(photos, circle), truth).max() < least


def test_a_saturated_highlight_is_fine() -> None:
    circle, shape = (60.0, 60.0, 50.0), (120, 120)
    truth = np.array([0.48, 0.6, 0.64])
    photo = np.clip(50 * mirror_ball(truth, circle, shape, 4.0), 0, 1)
    assert degrees_between(mirror_ball_lights(photo[None], circle)[0], truth) < PIXEL / 5


def test_a_mask_is_as_good_as_its_circle() -> None:
    circle, shape = (61.0, 59.0, 50.0), (120, 124)
    rows, columns = np.mgrid[: shape[0], : shape[1]] + 0.5
    mask = np.hypot(columns - circle[0], rows - circle[1]) < circle[2]
    np.testing.assert_allclose(circle_of(mask, shape), circle, atol=0.1)
    truth = lamps(3)
    photos = np.stack([mirror_ball(lamp, circle, shape, 3.0) for lamp in truth])
    assert degrees_between(mirror_ball_lights(photos, mask=mask), truth).max() < PIXEL / 5


def test_x_is_right_and_y_is_up() -> None:
    photo = np.zeros((101, 101))
    photo[30, 50] = 1  # above the middle
    assert mirror_ball_lights(photo[None], (50.5, 50.5, 50))[0] == pytest.approx([0, 0.7332, 0.68], abs=1e-4)


def test_what_shines_beside_the_ball_is_nothing() -> None:
    photo = np.zeros((101, 140))
    photo[50, 65], photo[10, 130] = 1, 9
    assert mirror_ball_lights(photo[None], (50.5, 50.5, 50))[0] == pytest.approx([0.5724, 0, 0.82], abs=1e-4)


def test_refuses_what_is_no_ball() -> None:
    photos, circle = np.zeros((1, 60, 60)), (30.0, 30.0, 25.0)
    photos[0, 30, 30] = 1
    square = np.zeros((60, 60), bool)
    square[5:50, 20:30] = True
    for arguments, message in (
        ({"photographs": photos[0]}, r"expected shape \(n, h, w\)"),
        ({"photographs": photos}, "expected a circle or a mask, got neither"),
        ({"photographs": photos, "circle": circle, "mask": square}, "got both"),
        ({"photographs": photos, "mask": square}, "expected the disc of a ball"),
        ({"photographs": photos, "circle": (1, 2)}, r"expected \(x, y, radius\)"),
        ({"photographs": photos, "circle": (30, 30, 5)}, "radius of at least 8"),
        ({"photographs": photos, "circle": (30, 30, 40)}, "expected it within the 60 x 60 pixels"),
    ):
        with pytest.raises(HarmonicFaceError, match=message):
            mirror_ball_lights(**arguments)  # type: ignore[arg-type]


def test_refuses_highlights_that_tell_no_direction() -> None:
    circle, photo = (30.0, 30.0, 25.0), np.zeros((1, 60, 60))
    with pytest.raises(HarmonicFaceError, match="expected a lamp's highlight in photograph 0"):
        mirror_ball_lights(photo, circle)
    two = photo.copy()
    two[0, 20:22, 20:22] = two[0, 40:42, 40:42] = 1
    with pytest.raises(HarmonicFaceError, match="expected one highlight in photograph 0, got 2"):
        mirror_ball_lights(two, circle)
    broad = photo.copy()
    broad[0, 20:40, 20:40] = 1
    with pytest.raises(HarmonicFaceError, match="expected a small highlight in photograph 0, got one on 21%"):
        mirror_ball_lights(broad, circle)
