"""Crop, resize and decimate: what they keep, what they average, what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from harmonicface.appearance.basis import harmonic_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.operations import crop, decimate, resize
from harmonicface.surfaces.samples import sample
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transport import Transport
from harmonicface.surfaces.windows import Window, through


def make(shape=(12, 9), colour=False, depth=True, dtype=np.float64, seed=0, bounces=(0,), transport_colour=False):
    rng = np.random.default_rng(seed)
    normals = rng.normal((0, 0, 3), size=(*shape, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    mask = rng.random(shape) < 0.8
    mask[0, 0] = mask[-1, -1] = mask[shape[0] // 2, shape[1] // 2] = True
    albedo = rng.random((*shape, 3) if colour else shape)
    albedo[1, 1] = 0
    pixels = (int(mask.sum()), 3) if transport_colour else (int(mask.sum()),)
    return Surface(
        normals.astype(dtype),
        albedo.astype(dtype),
        mask,
        rng.normal(size=shape).astype(dtype) if depth else None,
        0.25,
        transports=[Transport(rng.normal(size=(9, *pixels)), number) for number in bounces],
    )


def same(one, other, exact=True):
    """Assert that two Surfaces hold the same numbers."""
    compare = np.testing.assert_array_equal if exact else lambda a, b: np.testing.assert_allclose(a, b, atol=1e-6)
    np.testing.assert_array_equal(one.mask, other.mask)
    for name in ("normals", "albedo", "depth"):
        a, b = getattr(one, name), getattr(other, name)
        assert (a is None) == (b is None)
        if a is not None:
            assert a.dtype == b.dtype
            compare(a, b)
    assert one.pixel_size == pytest.approx(other.pixel_size, rel=1e-12)
    assert one.transports.keys() == other.transports.keys()
    for bounces, known in one.transports.items():
        compare(known.values, other.transports[bounces].values)


def ball_mesh(rows=40, columns=80):
    """A ball of radius 1 in front of a wall, with albedo that grows upward."""
    v, u = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, rows), np.linspace(0, 2 * np.pi, columns), indexing="ij")
    ball = np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], axis=-1).reshape(-1, 3)
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.stack([np.stack([a, b, d], -1), np.stack([a, d, c], -1)]).reshape(-1, 3)
    wall = np.array([[-2.0, -2, -1], [2, -2, -1], [2, 2, -1], [-2, 2, -1]])
    vertices = np.concatenate([ball, wall])
    faces = np.concatenate([faces, np.array([[0, 1, 2], [0, 2, 3]]) + len(ball)])
    normals = np.concatenate([ball, np.tile([0.0, 0, 1], (4, 1))])
    albedo = np.repeat(0.5 + 0.1 * vertices[:, 1:2], 3, axis=1)
    return Mesh(vertices, faces, normals, None, (), np.full(len(faces), -1), albedo)


@settings(max_examples=30)
@given(st.booleans(), st.booleans(), st.sampled_from([np.float32, np.float64]), st.integers(0, 999))
def test_a_crop_of_everything_is_the_surface(colour, depth, dtype, seed):
    surface = make((5, 4), colour, depth, dtype, seed, bounces=(0, 2), transport_colour=colour)
    for rows, columns in (((0, 5), (0, 4)), (slice(None), slice(None)), (slice(-5, None), slice(None, 4, 1))):
        same(crop(surface, rows, columns), surface)


@given(st.data())
def test_a_crop_is_a_part_of_every_picture(data):
    surface = make()
    top, left = data.draw(st.integers(0, 6)), data.draw(st.integers(0, 4))
    bottom, right = data.draw(st.integers(7, 12)), data.draw(st.integers(5, 9))
    part = crop(surface, (top, bottom), (left, right))
    inside = surface.mask[top:bottom, left:right]
    np.testing.assert_array_equal(part.mask, inside)
    np.testing.assert_array_equal(part.normals, surface.normals[top:bottom, left:right])
    np.testing.assert_array_equal(part.depth, surface.depth[top:bottom, left:right])
    picture = np.zeros(surface.shape)
    picture[surface.mask] = surface.transports[0].values[4]
    np.testing.assert_array_equal(part.transports[0].values[4], picture[top:bottom, left:right][inside])
    images = np.zeros((9, *surface.shape))
    images[:, surface.mask] = harmonic_images(surface)
    np.testing.assert_array_equal(harmonic_images(part), images[:, top:bottom, left:right][:, inside])
    again = crop(crop(surface, (top, 12), (left, 9)), (0, bottom - top), (0, right - left))
    same(again, part)


@pytest.mark.parametrize(
    ("rows", "columns", "message"),
    [
        (
            (0, 13),
            (0, 9),
            r"rows: expected \(first, beyond\) or a slice of step 1 within 12 pixels, got tuple \(0, 13\)",
        ),
        ((3, 3), (0, 9), "rows: expected"),
        ((5, 3), (0, 9), "rows: expected"),
        ((-13, 3), (0, 9), "rows: expected"),
        ((0, 5), slice(0, 9, 2), "columns: expected .* within 9 pixels, got slice"),
        ((0, 5), (0, 1, 2), "columns: expected"),
        ((0, 5), 3, "columns: expected"),
        ((0, 5), (0.0, 3), "columns: expected"),
        ((0, 5), (None, 3), "columns: expected"),
        ((False, True), (0, 3), "rows: expected"),
    ],
)
def test_what_is_no_part_is_refused(rows, columns, message):
    with pytest.raises(HarmonicFaceError, match=message):
        crop(make(), rows, columns)


def test_a_part_without_surface_is_refused():
    mask = np.zeros((4, 4), bool)
    mask[1, 1] = True
    dot = Surface(np.tile([0.0, 0, 1], (4, 4, 1)), np.ones((4, 4)), mask)
    for cut in (lambda: crop(dot, (2, 4), (0, 4)), lambda: decimate(dot, 2)):
        with pytest.raises(HarmonicFaceError, match=r"expected a part of the mask .* got none of 1 pixels"):
            cut()


def test_every_nth_pixel():
    surface = make()
    same(decimate(surface, 1), surface)
    third = decimate(surface, 3)
    np.testing.assert_array_equal(third.mask, surface.mask[::3, ::3])
    np.testing.assert_array_equal(third.albedo, surface.albedo[::3, ::3])
    np.testing.assert_array_equal(third.depth, surface.depth[::3, ::3])
    assert third.pixel_size == 0.75
    picture = np.zeros(surface.shape)
    picture[surface.mask] = surface.transports[0].values[8]
    np.testing.assert_array_equal(third.transports[0].values[8], picture[::3, ::3][third.mask])
    assert decimate(surface, 100).shape == (1, 1)
    same(decimate(decimate(surface, 2), 3), decimate(surface, 6))
    for every in (0, -1, 1.5, True):
        with pytest.raises(HarmonicFaceError, match="every: expected an integer of at least 1"):
            decimate(surface, every)


CAMERAS = [
    {"frame": (-1.2, -1.1, 1.3, 1.4), "rotation": (20.0, -10.0, 5.0)},
    {"intrinsics": (70.0, 70.0, 24.0, 24.0), "distance": 6.0, "rotation": (20.0, -10.0, 5.0)},
]


@pytest.mark.parametrize("camera", CAMERAS, ids=["orthographic", "pinhole"])
def test_the_camera_follows_a_crop(camera):
    whole = surface_from_mesh(ball_mesh(), 48, supersample=1, **camera)
    part = crop(whole, (10, 40), (5, 41))
    points = part.scene.mesh.vertices
    moved = whole.scene.view.project(points) - [5, 10, 0]
    np.testing.assert_allclose(part.scene.view.project(points), moved, atol=1e-9)
    assert part.scene.view.shape == part.shape
    everything = crop(whole, (0, 48), (0, 48)).scene.view
    np.testing.assert_array_equal(everything.project(points), whole.scene.view.project(points))


@pytest.mark.parametrize("camera", CAMERAS, ids=["orthographic", "pinhole"])
def test_the_camera_follows_a_decimation(camera):
    whole = surface_from_mesh(ball_mesh(), 48, supersample=1, **camera)
    fifth = decimate(whole, 5)
    points = fifth.scene.mesh.vertices
    centres = whole.scene.view.project(points)[:, :2]  # the first pixel's centre stays the first pixel's centre
    np.testing.assert_allclose(fifth.scene.view.project(points)[:, :2] - 0.5, (centres - 0.5) / 5, atol=1e-9)
    samples = sample(whole.scene.mesh, fifth.scene.view)
    np.testing.assert_array_equal(samples.mask, fifth.mask)
    np.testing.assert_allclose(samples.normals, fifth.normals, atol=1e-6)


@pytest.mark.parametrize("camera", CAMERAS, ids=["orthographic", "pinhole"])
def test_a_mesh_is_seen_again_at_another_size(camera):
    small = resize(surface_from_mesh(ball_mesh(), 48, **camera), 24)
    other = {**camera, "intrinsics": (35.0, 35.0, 12.0, 12.0)} if "intrinsics" in camera else camera
    same(small, surface_from_mesh(ball_mesh(), 24, **other), exact=False)
    assert small.scene is not None and small.transports == {}


@settings(max_examples=30)
@given(st.booleans(), st.booleans(), st.sampled_from([np.float32, np.float64]), st.integers(0, 999))
def test_the_same_size_is_the_same_surface(colour, depth, dtype, seed):
    surface = make((5, 4), colour, depth, dtype, seed, bounces=(0, 1), transport_colour=colour)
    same(resize(surface, (5, 4)), surface, exact=False)


def test_larger_pixels_hold_the_means_of_what_lies_in_the_mask():
    surface = make((8, 6), colour=True)
    half = resize(surface, (4, 3))
    assert half.pixel_size == 0.5
    for row, column in np.ndindex(4, 3):
        block = slice(2 * row, 2 * row + 2), slice(2 * column, 2 * column + 2)
        inside = surface.mask[block]
        assert half.mask[row, column] == (inside.sum() >= 2)
        if half.mask[row, column]:
            np.testing.assert_allclose(half.albedo[row, column], surface.albedo[block][inside].mean(axis=0))
            np.testing.assert_allclose(half.depth[row, column], surface.depth[block][inside].mean())
            mean = surface.normals[block][inside].mean(axis=0)
            np.testing.assert_allclose(half.normals[row, column], mean / np.linalg.norm(mean))


def test_pixels_that_are_no_whole_multiple_share_what_lies_between_them():
    ramp = np.tile(np.arange(6.0), (6, 1))
    surface = Surface(np.tile([0.0, 0, 1], (6, 6, 1)), ramp, depth=ramp, pixel_size=1.0)
    four = resize(surface, 4)
    assert four.pixel_size == 1.5
    exact = 1.5 * (np.arange(4) + 0.5) - 0.5 + [1 / 12, -1 / 12, 1 / 12, -1 / 12]  # constant within each old pixel
    np.testing.assert_allclose(four.albedo, np.tile(exact, (4, 1)), atol=1e-12)


@given(st.integers(1, 12), st.integers(1, 9), st.integers(0, 99))
def test_means_conserve_the_total(height, width, seed):
    rng = np.random.default_rng(seed)
    albedo = rng.random((12, 9))
    surface = Surface(np.tile([0.0, 0, 1], (12, 9, 1)), albedo)
    step = max(12 / height, 9 / width)
    assume(step * (2 - height % 2) / 2 < 12 and step * (2 - width % 2) / 2 < 9)  # some pixel is covered half
    small = resize(surface, (height, width))
    assert small.pixel_size == step
    if 12 / height == 9 / width:  # nothing beyond the picture is shown
        np.testing.assert_allclose(small.albedo.sum() * step**2, albedo.sum())
    inside = small.albedo[small.mask]
    assert albedo.min() - 1e-12 <= inside.min() <= inside.max() <= albedo.max() + 1e-12


def test_other_proportions_show_more():
    surface = Surface(np.tile([0.0, 0, 1], (4, 8, 1)), np.ones((4, 8)), depth=np.zeros((4, 8)))
    square = resize(surface, 4)
    assert square.pixel_size == 2.0
    np.testing.assert_array_equal(square.mask, np.array([False, True, True, False])[:, None].repeat(4, axis=1))
    large = resize(surface, (16, 16))
    assert large.pixel_size == 0.5
    np.testing.assert_array_equal(large.mask.any(axis=1), (np.arange(16) >= 4) & (np.arange(16) < 12))


def test_smaller_pixels_lie_on_lines_between_pixel_centres():
    ramp = np.tile(np.arange(5.0), (5, 1))
    surface = Surface(np.tile([0.0, 0, 1], (5, 5, 1)), ramp, depth=2 * ramp)
    large = resize(surface, 10)
    across = np.clip((np.arange(10) + 0.5) / 2 - 0.5, 0, 4)
    np.testing.assert_allclose(large.albedo, np.tile(across, (10, 1)), atol=1e-12)
    np.testing.assert_allclose(large.depth, 2 * large.albedo, atol=1e-12)
    assert large.pixel_size == 0.5


def smooth_surface(size=120):
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    depth = 0.3 * np.cos(2 * x + 0.4) * np.cos(1.5 * y) + 0.05 * np.sin(5 * x) * np.cos(4 * y)
    return surface_from_depth(depth, 0.5 + 0.2 * np.sin(3 * x), 2 / (size - 1))


def test_normals_and_depth_agree_after_shrinking():
    small = resize(smooth_surface(), 30)
    again = surface_from_depth(small.depth, pixel_size=small.pixel_size)
    cosine = np.einsum("hwi,hwi->hw", small.normals, again.normals)[1:-1, 1:-1]
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 0.6


def means(images, surface, every):
    """Return the means of images over blocks, (k, h, w)."""
    pictures = np.zeros((len(images), *surface.shape))
    pictures[:, surface.mask] = images
    height, width = (side // every for side in surface.shape)
    return pictures.reshape(len(images), height, every, width, every).mean(axis=(2, 4))


def test_harmonic_images_with_shadows_are_the_means_of_what_they_were():
    rng = np.random.default_rng(1)
    flat = np.tile([0.0, 0, 1], (12, 8, 1))
    surface = Surface(flat, rng.random((12, 8, 3)), transports=[Transport(rng.random((9, 96)))])
    small = resize(surface, (6, 4))
    before = surface.grey_albedo * surface.transports[0].values
    np.testing.assert_allclose(
        small.grey_albedo * small.transports[0].values, means(before, surface, 2).reshape(9, -1), rtol=1e-12
    )


def test_transport_in_colours_goes_by_colours_and_black_pixels_by_the_mean():
    rng = np.random.default_rng(3)
    albedo = rng.random((2, 2, 3))
    albedo[..., 2] = 0
    flat = np.tile([0.0, 0, 1], (2, 2, 1))
    values = rng.random((4, 4, 3))
    one = resize(Surface(flat, albedo, transports=[Transport(values, 1)]), 1).transports[1].values
    weights = albedo.reshape(4, 3)
    np.testing.assert_allclose(one[:, 0, :2], ((values * weights).sum(axis=1) / weights.sum(axis=0).clip(1e-9))[:, :2])
    np.testing.assert_allclose(one[:, 0, 2], values[..., 2].mean(axis=1))


def test_attached_harmonic_images_are_nearly_the_means_of_what_they_were():
    surface = smooth_surface()
    before = means(harmonic_images(surface), surface, 4)
    after = harmonic_images(resize(surface, 30)).reshape(before.shape)
    assert np.linalg.norm(after - before) / np.linalg.norm(before) < 2e-3


def test_sizes_that_show_nothing_are_refused():
    mask = np.zeros((9, 9), bool)
    mask[4, 4] = True
    dot = Surface(np.tile([0.0, 0, 1], (9, 9, 1)), np.ones((9, 9)), mask)
    with pytest.raises(
        HarmonicFaceError, match=r"size: expected pixels that the mask covers half, got none at \(3, 3\)"
    ):
        resize(dot, 3)
    opposite = Surface(np.array([[[1.0, 0, 0], [-1.0, 0, 0]]]), np.ones((1, 2)))
    with pytest.raises(HarmonicFaceError, match=r"got none at \(1, 1\)"):
        resize(opposite, 1)
    for size in (0, (3, 0), (1, 2, 3), 2.5, 1 << 15):
        with pytest.raises(HarmonicFaceError, match="size: expected"):
            resize(dot, size)


def test_a_crop_in_which_the_mesh_is_out_of_sight_cannot_be_resized():
    whole = surface_from_mesh(ball_mesh(), 16, frame=(-4, -4, 4, 4))
    aside = through(whole.scene.view, Window(0, 0, 1.0, (1, 1)))
    away = Surface(whole.normals, whole.albedo, whole.mask, scene=Scene(whole.scene.mesh, aside))
    with pytest.raises(HarmonicFaceError, match="view: expected a part of the mesh in it"):
        resize(away, 1)
