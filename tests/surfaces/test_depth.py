"""Normals of depth maps: planes exactly, spheres to second order, and nothing from outside the mask."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.depth import surface_from_depth


def test_a_plane_is_exact_everywhere_also_at_a_ragged_border():
    rows, columns = np.mgrid[:12, :15].astype(float)
    pixel_size = 0.25
    depth = (0.5 * columns + 2.0 * -rows) * pixel_size + 3  # rises to the right and upward
    depth[np.random.default_rng(0).random(depth.shape) < 0.2] = np.nan
    surface = surface_from_depth(depth, pixel_size=pixel_size)
    expected = np.array([-0.5, -2.0, 1.0]) / np.sqrt(0.25 + 4 + 1)
    np.testing.assert_allclose(surface.pixel_normals, np.tile(expected, (surface.mask.sum(), 1)), atol=1e-12)
    assert surface.pixel_size == pixel_size
    np.testing.assert_array_equal(surface.depth[surface.mask], depth[surface.mask])


def test_only_pixels_without_a_neighbour_are_left_outside():
    depth = np.zeros((5, 7))
    mask = np.array([[c == "#" for c in row] for row in ["##.#...", "##.#.#.", ".......", "###....", ".#....."]])
    surface = surface_from_depth(depth, mask=mask)
    kept = np.array([[c == "#" for c in row] for row in ["##.....", "##.....", ".......", ".#.....", "......."]])
    np.testing.assert_array_equal(surface.mask, kept)


@pytest.mark.parametrize(("size", "bound"), [(64, 0.2), (128, 0.05)])
def test_a_sphere_is_right_to_second_order(size, bound):
    y, x = 1.2 * (0.5 - (np.mgrid[:size, :size] + 0.5) / size) * [[[1]], [[-1]]]
    z = np.sqrt(1 - x**2 - y**2)
    surface = surface_from_depth(z, pixel_size=1.2 / size)
    exact = np.stack([x, y, z], axis=2)
    inside = (slice(1, -1), slice(1, -1))
    cosine = np.einsum("ijk,ijk->ij", surface.normals, exact)[inside]
    assert np.degrees(np.arccos(np.minimum(cosine, 1))).max() < bound


def test_types_albedo_and_mask_are_kept():
    depth = np.zeros((3, 3), dtype=np.float32)
    surface = surface_from_depth(depth, albedo=0.25)
    assert surface.normals.dtype == surface.albedo.dtype == surface.depth.dtype == np.float32
    assert (surface.albedo == 0.25).all()
    colour = surface_from_depth(depth, albedo=np.full((3, 3, 3), 0.3))
    assert colour.albedo.shape == (3, 3, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(3),), r"depth: expected shape \(h, w\)"),
        ((np.full((3, 3), np.inf),), "got infinity"),
        ((np.full((3, 3), np.nan),), "at least one pixel"),
        ((np.array([[0, np.nan], [0, 0.0]]), 0.5, 1.0, np.ones((2, 2), bool)), "depth: expected finite"),
        ((np.zeros((3, 3)), 0.5, 1.0, np.ones((2, 2), bool)), "mask: expected"),
        ((np.zeros((3, 3)), 0.5, -1.0), "pixel_size: expected"),
        ((np.zeros((3, 3)), np.ones(3)), "albedo: expected shape"),
        ((np.zeros((3, 1)),), "expected pixels with neighbours"),
    ],
)
def test_bad_depth_is_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        surface_from_depth(*arguments)


@pytest.mark.parametrize("rotation", [0, 30])
def test_a_step_is_not_smeared(rotation):
    """Two planes of different slope, one before the other: each keeps its normal up to the edge."""
    columns = np.tile(np.arange(20.0), (12, 1))
    near, far = 0.5 * columns + 30, -0.2 * columns
    edge = columns > 9 if rotation == 0 else columns + np.arange(12)[:, None] > 14
    surface = surface_from_depth(np.where(edge, near, far), steepest=80)
    for side, slope in ((edge, 0.5), (~edge, -0.2)):
        here = side & surface.mask
        expected = np.array([-slope, 0, 1]) / np.hypot(slope, 1)
        np.testing.assert_allclose(surface.normals[here], np.tile(expected, (here.sum(), 1)), atol=1e-12)
    assert surface.mask.sum() >= surface.mask.size - 2  # a corner that a slanted edge cuts off has no neighbour
    smeared = surface_from_depth(np.where(edge, near, far))
    assert np.abs(smeared.normals - surface.normals).max() > 0.5


def test_a_spike_is_left_outside_where_steps_are_cut_and_kept_where_not():
    depth = np.zeros((5, 5))
    depth[2, 2] = 100.0
    assert surface_from_depth(depth).mask.all()
    kept = surface_from_depth(depth, steepest=80)
    assert not kept.mask[2, 2] and kept.mask.sum() == 24
    np.testing.assert_array_equal(kept.pixel_normals, np.tile([0, 0, 1.0], (24, 1)))


@pytest.mark.parametrize("steepest", [0, 91, np.nan, -5])
def test_angles_out_of_range_are_refused(steepest):
    with pytest.raises(HarmonicFaceError, match="steepest: expected"):
        surface_from_depth(np.zeros((3, 3)), steepest=steepest)
