"""Pictures of a Surface: they say what is in it, and nothing outside the mask."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.appearance.basis import harmonic_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import write_image
from harmonicface.io.normal_maps import read_normal_map
from harmonicface.io.pictures import signed_colours
from harmonicface.io.transfer import srgb_to_linear
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.pictures import common_scale, contour_interval, harmonic_pictures, surface_pictures
from harmonicface.surfaces.surface import Surface


def hill(size=40, colour=False, dtype=np.float64):
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    depth = np.where(x**2 + y**2 < 0.9, np.exp(-2 * (x**2 + y**2)), np.nan).astype(dtype)
    albedo = np.stack([0.5 + 0.3 * x] * 3, axis=-1) * [1, 0.5, 0.2] if colour else 0.5 + 0.3 * x
    return surface_from_depth(depth, albedo.astype(dtype), 2 / (size - 1))


@pytest.mark.parametrize("colour", [False, True])
def test_pictures_are_display_values_and_black_outside(colour):
    surface = hill(colour=colour, dtype=np.float32)
    pictures = surface_pictures(surface)
    assert list(pictures) == ["normals", "albedo", "depth", "mask"]
    assert pictures["albedo"].shape == surface.albedo.shape
    for picture in pictures.values():
        assert picture.shape[:2] == surface.shape and picture.dtype == np.float32
        assert picture.min() >= 0 and picture.max() <= 1
        assert not picture[~surface.mask].any()
    np.testing.assert_allclose(2 * pictures["normals"][surface.mask] - 1, surface.pixel_normals, atol=1e-6)
    np.testing.assert_allclose(srgb_to_linear(pictures["albedo"]), surface.albedo, atol=1e-5)
    np.testing.assert_array_equal(pictures["mask"] == 1, surface.mask)


def test_the_picture_of_normals_is_a_normal_map(tmp_path):
    surface = hill()
    write_image(tmp_path / "normals.png", surface_pictures(surface)["normals"], "linear")
    read = read_normal_map(tmp_path / "normals.png")
    np.testing.assert_array_equal(read.any(axis=2), surface.mask)
    assert np.abs(read - surface.normals).max() < 0.01


def test_albedo_above_one_is_white():
    surface = hill()
    bright = surface_pictures(Surface(surface.normals, 4 * surface.albedo, surface.mask))["albedo"]
    assert bright.max() == pytest.approx(1)
    assert "depth" not in surface_pictures(Surface(surface.normals, surface.albedo))
    black = surface_pictures(Surface(surface.normals, 0 * surface.albedo, surface.mask))["albedo"]
    assert not black.any()


def test_the_relief_tells_near_from_far_and_which_side_faces_the_lamp():
    ramp = np.tile(np.linspace(0, 1, 50), (50, 1))
    flat = Surface(np.tile([0.0, 0, 1], (50, 50, 1)), np.ones((50, 50)), depth=ramp)
    relief = surface_pictures(flat)["depth"]
    assert relief[0, 0, 2] > relief[0, 0, 0] and relief[0, -1, 0] > 2 * relief[0, -1, 2]  # blue to yellow
    surface = hill()
    lit = surface_pictures(surface)["depth"].sum(axis=2)
    assert lit[10, 12] > 1.5 * lit[-11, -13]  # upper left against lower right, equally high


def test_contours_lie_where_depth_crosses_a_multiple_of_the_interval():
    depth = np.tile(np.linspace(0, 24, 97), (5, 1))
    surface = Surface(np.tile([0.0, 0, 1], (5, 97, 1)), np.ones((5, 97)), depth=depth)
    assert contour_interval(surface) == 2
    plain = surface_pictures(surface)["depth"].sum(axis=2)[0]
    dark = np.flatnonzero(plain[1:-1] < 0.8 * np.minimum(plain[:-2], plain[2:])) + 1
    crossed = np.flatnonzero(np.diff(np.floor(depth[0] / 2))) + 1
    np.testing.assert_array_equal(dark, crossed[crossed < 96])


@given(st.floats(1e-9, 1e9))
def test_contours_are_about_a_dozen_at_round_intervals(extent):
    surface = Surface(np.tile([0.0, 0, 1], (1, 2, 1)), np.ones((1, 2)), depth=[[0.0, extent]])
    interval = contour_interval(surface)
    assert 12 / 1.6 < extent / interval < 12 * 1.6
    digit = interval / 10 ** np.floor(np.log10(interval * (1 + 1e-9)))
    assert min(abs(digit - round_one) for round_one in (1, 2, 5)) < 1e-6


def test_without_relief_there_are_no_contours():
    level = Surface(np.tile([0.0, 0, 1], (3, 3, 1)), np.ones((3, 3)), depth=np.full((3, 3), 7.0))
    assert contour_interval(level) is None
    assert contour_interval(Surface(np.tile([0.0, 0, 1], (3, 3, 1)), np.ones((3, 3)))) is None
    relief = surface_pictures(level)["depth"]
    assert (relief == relief[0, 0]).all() and relief.any()


def test_harmonic_pictures_share_one_scale():
    surface = hill()
    images = harmonic_images(surface)
    pictures = harmonic_pictures(surface, images)
    scale = common_scale(images)
    assert len(pictures) == 9
    assert scale == max(np.quantile(np.abs(image), 0.99) for image in images)
    shown = np.zeros(surface.shape)
    shown[surface.mask] = images[4]
    np.testing.assert_array_equal(pictures[4], signed_colours(shown, surface.mask, scale))
    np.testing.assert_array_equal(harmonic_pictures(surface, images, 2.0)[4], signed_colours(shown, surface.mask, 2.0))
    white = harmonic_pictures(surface, 0 * images)
    assert min(picture[surface.mask].min() for picture in white) > 0.95
    assert common_scale(np.zeros((0, 5))) == 1


@pytest.mark.parametrize(
    ("images", "scale", "message"),
    [
        (np.zeros((9, 3)), None, r"images: expected shape \(k, 2\), a column for each masked pixel, got"),
        (np.zeros(2), None, "images: expected shape"),
        (np.full((1, 2), np.nan), None, "images: expected finite"),
        (np.zeros((1, 2)), 0.0, "scale: expected"),
    ],
)
def test_what_are_no_images_is_refused(images, scale, message):
    wall = Surface(np.tile([0.0, 0, 1], (1, 2, 1)), np.ones((1, 2)))
    with pytest.raises(HarmonicFaceError, match=message):
        harmonic_pictures(wall, images, scale)
