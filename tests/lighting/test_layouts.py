"""Layouts: where pixels are, how large they are, and that looking up a direction finds its pixel."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.lighting.cube import cross_of_faces, faces_of_cross
from harmonicface.lighting.layout import Layout
from harmonicface.lighting.layouts import LAYOUTS, layout_named

every_layout = pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
SIZES = (1, 2, 3, 8, 33)


@every_layout
@pytest.mark.parametrize("size", SIZES)
def test_solid_angles_fill_the_sphere(layout: Layout, size: int) -> None:
    angles = layout.solid_angles(layout.shape(size))
    assert angles.shape == layout.shape(size)
    assert (angles >= 0).all()
    assert_allclose(angles.sum(), 4 * np.pi, rtol=1e-14)


@every_layout
def test_solid_angles_are_the_areas_that_directions_sweep(layout: Layout) -> None:
    # independent of the closed forms: the area element |d_across x d_down| on a fine grid of points in each pixel
    shape, each, step = layout.shape(6), 24, 1e-5
    total = np.zeros(shape)
    for down in (np.arange(each) + 0.5) / each:
        for across in (np.arange(each) + 0.5) / each:
            right = layout.directions(shape, across + step, down) - layout.directions(shape, across - step, down)
            below = layout.directions(shape, across, down + step) - layout.directions(shape, across, down - step)
            total += np.linalg.norm(np.cross(right, below), axis=-1) / (2 * step * each) ** 2
    inside = np.ones(shape, bool)
    if layout.name in ("angular", "mirrorball"):  # pixels that the rim cuts are not smooth
        corner = (np.abs(np.arange(6) - 2.5) + 0.5) / 3
        inside = np.hypot(corner[:, None], corner[None, :]) < 1
    assert inside.sum() >= 16
    assert_allclose(layout.solid_angles(shape)[inside], total[inside], rtol=2e-3)


@every_layout
def test_area_elements_are_in_proportion_to_solid_angles(layout: Layout) -> None:
    shape = layout.shape(64)
    angles, elements = layout.solid_angles(shape), layout.area_element(shape)
    inside = angles > 0.2 * angles.max()
    if layout.name == "mirrorball":
        inside = angles > 0.999 * angles.max()  # none that the rim cuts
    ratio = angles[inside] / elements[inside]
    assert_allclose(ratio / ratio.mean(), 1, rtol=0, atol=1e-3)


def test_a_mirror_ball_gives_each_pixel_the_same() -> None:
    angles = layout_named("mirrorball").solid_angles((64, 64))
    assert_allclose(angles[20:44, 20:44], 4 * (2 / 64) ** 2, rtol=1e-12)
    assert_array_equal(angles[:9, :9], 0)


def test_a_cube_s_corner_by_hand() -> None:
    # two by two: by symmetry each pixel is a 24th of the sphere
    assert_allclose(layout_named("cube").solid_angles((6, 2, 2)), np.pi / 6, rtol=1e-14)


@every_layout
@pytest.mark.parametrize("size", [2, 5, 16])
def test_directions_are_unit_and_looking_them_up_finds_their_pixels(layout: Layout, size: int) -> None:
    shape = layout.shape(size)
    directions = layout.directions(shape)
    assert_allclose(np.linalg.norm(directions, axis=-1), 1, rtol=1e-14)
    picture = np.random.default_rng(size).uniform(1, 2, (*shape, 3))
    seen = layout.solid_angles(shape) > 0
    if layout.name in ("angular", "mirrorball"):  # a pixel with its centre beyond the rim has no direction of its own
        centre = (np.arange(size) + 0.5) / size * 2 - 1
        seen = np.hypot(centre[:, None], centre[None, :]) <= 1
    assert_allclose(layout.sample(picture, directions)[seen], picture[seen], rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "pixel", "direction"),
    [
        ("angular", (32, 32), [0, 0, -1]),
        ("angular", (32, 48), [1, 0, 0]),
        ("angular", (16, 32), [0, 1, 0]),
        ("angular", (32, 63), [0, 0, 1]),
        ("mirrorball", (32, 32), [0, 0, 1]),
        ("mirrorball", (32, round(32 + 32 * np.sqrt(0.5))), [1, 0, 0]),
        ("mirrorball", (round(32 - 32 * np.sqrt(0.5)), 32), [0, 1, 0]),
        ("cube", (0, 32, 32), [1, 0, 0]),
        ("cube", (1, 32, 32), [-1, 0, 0]),
        ("cube", (2, 32, 32), [0, 1, 0]),
        ("cube", (3, 32, 32), [0, -1, 0]),
        ("cube", (4, 32, 32), [0, 0, 1]),
        ("cube", (5, 32, 32), [0, 0, -1]),
        ("cube", (4, 32, 63), np.sqrt([0.5, 0, 0.5])),
        ("cube", (4, 0, 32), np.sqrt([0, 0.5, 0.5])),
        ("cube", (0, 0, 32), np.sqrt([0.5, 0.5, 0])),
        ("latlong", (32, 64), [0, 0, -1]),
    ],
)
def test_axes(name: str, pixel: tuple[int, ...], direction: list[float]) -> None:
    layout = layout_named(name)
    assert layout.directions(layout.shape(64))[pixel] @ direction > 0.99


@every_layout
def test_a_smooth_function_is_smooth_across_every_seam(layout: Layout) -> None:
    weights = np.array([[0.3, 0.1, -0.2], [0.1, -0.4, 0.3], [0.5, 0.2, 0.1]])
    shape = layout.shape(48)
    picture = 2 + layout.directions(shape) @ weights
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20000, 3))
    directions[:6000] *= rng.choice([1, 1, 1e-3], (6000, 3))  # many near axes, edges and poles
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    error = np.abs(layout.sample(picture, directions) - (2 + directions @ weights))
    # the steepest slope, 0.7 a radian, times the angle across the largest pixel: at the rim of a light probe its
    # diagonal, of a mirror ball 2 acos(1 - 2 / 48); elsewhere the error is that of a parabola, far smaller
    across = {"angular": np.sqrt(2) * np.pi * 2 / 48, "mirrorball": 2 * np.arccos(1 - 2 / 48)}.get(layout.name, 0.01)
    assert error.max() < 0.7 * across
    assert np.median(error) < 2e-3


@pytest.mark.parametrize(("name", "size"), [("latlong", 4), ("cube", 3), ("cube", 4)])
def test_folding_pairs_antipodes(name: str, size: int) -> None:
    layout = layout_named(name)
    folded = layout.fold(layout.directions(layout.shape(size)))
    assert folded is not None
    assert_allclose(folded[0], -folded[1], atol=1e-15)
    assert folded[0].size * 2 == layout.directions(layout.shape(size)).size


def test_what_cannot_be_folded() -> None:
    assert layout_named("angular").fold(np.ones((4, 4, 3))) is None
    assert layout_named("latlong").fold(np.ones((3, 6))) is None


def test_a_cross_is_cut_and_put_together() -> None:
    faces = np.random.default_rng(0).uniform(size=(6, 4, 4, 3))
    cross = cross_of_faces(faces)
    assert cross.shape == (12, 16, 3)
    assert_array_equal(faces_of_cross(cross), faces)
    high = np.zeros((16, 12, 3))
    high[:12] = cross[:, :12]
    high[12:, 4:8] = cross[4:8, 12:][::-1, ::-1]
    assert_array_equal(faces_of_cross(high), faces)


def test_a_cross_is_seamless() -> None:
    # neighbouring pixels of the cross are neighbours on the sphere, in both kinds of cross
    directions = layout_named("cube").directions((6, 16, 16))
    cross = cross_of_faces(directions)
    for picture in (cross[16:32], cross[:, 16:32]):
        beside = np.concatenate(
            [np.sum(picture[1:] * picture[:-1], -1).ravel(), np.sum(picture[:, 1:] * picture[:, :-1], -1).ravel()]
        )
        assert beside.min() > np.cos(2 / 16)


@pytest.mark.parametrize("shape", [(6, 8), (9, 11), (2, 2), (8, 8)])
def test_what_is_no_cross(shape: tuple[int, int]) -> None:
    if shape == (6, 8):
        assert faces_of_cross(np.ones(shape)).shape == (6, 2, 2)
        return
    with pytest.raises(hf.HarmonicFaceError, match="expected a cross of 4 x 3 or 3 x 4 squares, got"):
        faces_of_cross(np.ones(shape))


@pytest.mark.parametrize("name", ["globe", "", 3, None, ["cube"]])
def test_unknown_layouts(name: str) -> None:
    with pytest.raises(
        hf.HarmonicFaceError, match="layout: expected one of 'latlong', 'angular', 'cube', 'mirrorball'"
    ):
        layout_named(name)


@pytest.mark.parametrize(
    ("layout", "shape", "message"),
    [
        ("latlong", (4,), r"radiance: expected an image of shape \(h, w\) or \(h, w, 3\)"),
        ("latlong", (4, 8, 2), "radiance: expected an image of shape"),
        ("angular", (4, 8), r"radiance: expected a square \(angular\), got 8 x 4"),
        ("mirrorball", (8, 4, 3), r"radiance: expected a square \(mirrorball\), got 4 x 8"),
        ("mirrorball", (0, 0), "radiance: expected an image of shape"),
        ("cube", (8, 8), "radiance: expected six square faces"),
        ("cube", (5, 8, 8), "radiance: expected six square faces"),
        ("cube", (6, 8, 9, 3), "radiance: expected six square faces"),
        ("cube", (6, 8, 8, 4), "radiance: expected six square faces"),
        ("cube", (6, 0, 0, 3), "radiance: expected six square faces"),
    ],
)
def test_radiance_of_another_layout(layout: str, shape: tuple[int, ...], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.EnvironmentMap(np.ones(shape), layout)
