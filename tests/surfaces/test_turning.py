"""Turned Surfaces: seen again from the mesh, drawn from the depth, or rolled."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.io.meshes import Mesh
from harmonicface.people.synthetic import synthetic_person
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transport import Transport
from harmonicface.surfaces.turning import turn
from harmonicface.surfaces.view import rotation_matrix


def ball(size=64, radius=0.8, albedo=None, dtype=np.float64):
    """The front half of a ball of radius 1 in a picture as wide, without its limb."""
    across = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(across, -across)
    inside = x**2 + y**2 < radius**2
    z = np.sqrt(np.where(inside, 1 - x**2 - y**2, 1))
    normals = np.stack([x, y, z], axis=-1)
    normals[~inside] = 0
    colour = 0.5 + 0.3 * y if albedo is None else albedo
    return Surface(normals.astype(dtype), colour.astype(dtype), inside, (z + 5).astype(dtype), 2 / size)


def noisy(shape=(9, 9), depth=True, seed=0, channels=(), order=2):
    rng = np.random.default_rng(seed)
    normals = rng.normal((0, 0, 4), size=(*shape, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    mask = np.ones(shape, bool)
    mask[1, 2] = False
    known = Transport(rng.normal(size=((order + 1) ** 2, mask.sum())))
    heights = rng.normal(size=shape) if depth else None
    return Surface(normals, rng.random((*shape, *channels)), mask, heights, 2.0, transports=[known])


def spread(values, mask):
    picture = np.zeros((len(values), *mask.shape))
    picture[:, mask] = values
    return picture


@pytest.mark.parametrize("depth", [True, False])
@pytest.mark.parametrize("channels", [(), (3,)])
@pytest.mark.parametrize("quarters", [0, 1, 2, 3, -1])
def test_quarter_turns_move_pixels_and_change_nothing(quarters, channels, depth):
    surface = noisy(depth=depth, channels=channels)
    rolled = turn(surface, (0.0, 0.0, 90.0 * quarters))
    np.testing.assert_array_equal(rolled.mask, np.rot90(surface.mask, quarters))
    np.testing.assert_allclose(rolled.albedo, np.rot90(surface.albedo, quarters), atol=1e-15)
    matrix = rotation_matrix((0.0, 0.0, 90.0 * quarters))
    np.testing.assert_allclose(rolled.normals, np.rot90(surface.normals @ matrix.T, quarters), atol=1e-12)
    if depth:
        np.testing.assert_allclose(rolled.depth, np.rot90(surface.depth, quarters), atol=1e-12)
    else:
        assert rolled.depth is None
    assert rolled.pixel_size == 2.0
    pixels = spread(surface.transports[0].values, surface.mask)
    moved = np.rot90(pixels, quarters, axes=(1, 2))[:, rolled.mask]
    if quarters == 0:
        np.testing.assert_allclose(rolled.transports[0].values, moved, atol=1e-12)
    np.testing.assert_allclose(  # turns about the camera's axis leave the m = 0 harmonics alone
        rolled.transports[0].values[[0, 2, 6]], moved[[0, 2, 6]], atol=1e-12
    )


def test_types_stay_what_they_were():
    turned = turn(ball(32, dtype=np.float32), (10.0, 0.0, 0.0))
    assert turned.normals.dtype == turned.albedo.dtype == turned.depth.dtype == np.float32
    grey = noisy(channels=(3,))
    grey = Surface(grey.normals, np.repeat(grey.albedo[..., :1], 3, axis=2), grey.mask, grey.depth)
    assert turn(grey, (0.0, 0.0, 0.0)).albedo.shape == (9, 9, 3)


@settings(max_examples=25)
@given(st.floats(-40, 40), st.floats(-40, 40), st.floats(-180, 180))
def test_a_turned_ball_is_a_ball(yaw, pitch, roll):
    turned = turn(ball(), (yaw, pitch, roll), about=5.0)  # about its centre
    x, y = ((np.arange(64) + 0.5) / 32 - 1 for _ in range(2))
    x, y = np.meshgrid(x, -y)
    inside = turned.mask & (x**2 + y**2 < 0.75)
    exact = np.stack([x, y, np.sqrt(np.where(inside, 1 - x**2 - y**2, 1))], axis=-1)
    assert np.abs(turned.normals[inside] - exact[inside]).max() < 2e-3
    assert np.abs(turned.depth[inside] - 5 - exact[inside, 2]).max() < 2e-3
    pole = exact[inside] @ rotation_matrix((yaw, pitch, roll))  # where the point was before
    assert np.abs(turned.albedo[inside] - (0.5 + 0.3 * pole[:, 1])).max() < 1e-3
    assert (pole[:, 2] > 0.55).all()  # what was not seen before stays unknown


@settings(max_examples=10)
@given(st.floats(-15, 15), st.floats(-15, 15))
def test_there_and_back(yaw, pitch):
    surface = synthetic_person(3, 64)
    axis = float(surface.depth[surface.mask].mean())
    there = turn(surface, (yaw, 0.0, 0.0), axis)
    back = turn(turn(there, (0.0, pitch, 0.0), axis), (0.0, -pitch, 0.0), axis)
    back = turn(back, (-yaw, 0.0, 0.0), axis)
    both = surface.mask & back.mask
    assert both.sum() > 0.75 * surface.mask.sum()
    error = np.abs(back.albedo - surface.albedo)[both] / surface.albedo[both].mean()
    assert np.sqrt(np.mean(error**2)) < 0.1
    angle = np.degrees(np.arccos(np.clip(np.einsum("pi,pi->p", back.normals[both], surface.normals[both]), -1, 1)))
    assert np.median(angle) < 1.5


def test_what_was_hidden_stays_unknown():
    depth = np.zeros((40, 40))
    depth[:, 15:25] = 8.0  # a bar before a wall
    flat = np.tile([0.0, 0, 1], (40, 40, 1))
    bar = Surface(flat, np.where(depth > 0, 0.9, 0.2), depth=depth)
    turned = turn(bar, (30.0, 0.0, 0.0), about=0.0)
    row = turned.mask[20]
    where = np.flatnonzero(np.abs(turned.albedo[20] - 0.9) < 1e-9)
    assert where.min() == pytest.approx(20 - 5 * np.cos(np.pi / 6) + 4, abs=1)  # the bar moved to the right
    behind = np.arange(where.min() - 4, where.min() - 1)
    assert not row[behind].any()  # what it hid from the first camera
    assert row[where.min() - 8] and row[where.max() + 2]
    np.testing.assert_allclose(
        turned.pixel_normals, np.tile([0.5, 0, np.sqrt(0.75)], (turned.mask.sum(), 1)), atol=1e-12
    )


def test_backs_are_not_shown():
    across = ball(48)
    with pytest.raises(HarmonicFaceError, match="expected a part of the front in view"):
        turn(across, (180.0, 0.0, 0.0))
    side = turn(across, (75.0, 0.0, 0.0), about=5.0)
    columns = np.flatnonzero(side.mask.any(axis=0))
    assert columns.min() > 24  # the cut through the ball is not filled by the inside of its far half


def test_transports_turn_with_the_surface():
    surface = ball(48)
    weights = np.array([np.pi, *[2 * np.pi / 3] * 3, *[np.pi / 4] * 5])
    known = Transport(weights[:, None] * real_harmonics(surface.pixel_normals, 2))
    coloured = Transport(np.stack([known.values, 2 * known.values, 3 * known.values], axis=-1), 1)
    surface = Surface(
        surface.normals, surface.albedo, surface.mask, surface.depth, 2 / 48, transports=[known, coloured]
    )
    turned = turn(surface, (20.0, -15.0, 40.0), about=5.0)
    exact = weights[:, None] * real_harmonics(turned.pixel_normals, 2)
    assert np.abs(turned.transports[0].values - exact).max() < 5e-3
    np.testing.assert_allclose(turned.transports[1].values[..., 2], 3 * turned.transports[0].values, atol=1e-9)


def two_boxes():
    """A large and a small square, one before the other, with a tilted one beside them."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    vertices = np.concatenate(
        [corners, 0.3 * corners + [0.2, 0.1, 0.5], 0.4 * corners @ np.diag([1, 1, 0.0]) + [1.5, 0, 0]]
    )
    vertices[8:, 2] = vertices[8:, 0]
    normals = np.repeat([[0, 0, 1], [0, 0, 1], np.array([-1, 0, 1]) / np.sqrt(2)], 4, axis=0)
    faces = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * k for k in range(3)])
    albedo = np.repeat(np.linspace(0.2, 0.9, 12)[:, None], 3, axis=1)
    return Mesh(vertices, faces, normals, None, (), np.full(6, -1), albedo)


@pytest.mark.parametrize("rotation", [(0.0, 0.0, 0.0), (35.0, 0.0, 0.0), (10.0, -20.0, 30.0), (0.0, 90.0, 0.0)])
def test_with_a_scene_the_mesh_is_seen_again(rotation):
    mesh = two_boxes()
    first = surface_from_mesh(mesh, 32, rotation=(15.0, 5.0, 0.0), frame=(-2, -2, 2.5, 2.5))
    if rotation == (0.0, 90.0, 0.0):
        with pytest.raises(HarmonicFaceError, match="view: expected a part of the mesh in it"):
            turn(surface_from_mesh(mesh, 32, frame=(-0.5, 0.8, -0.4, 0.9)), rotation, about=50.0)
        return
    turned = turn(first, rotation, about=0.25)
    matrix = rotation_matrix(rotation)
    pivot = np.array([0.25, 0.25, 0.25])
    view = turned.scene.view
    np.testing.assert_allclose(view.rotation, matrix @ rotation_matrix((15.0, 5.0, 0.0)), atol=1e-14)
    np.testing.assert_allclose(view.frame, np.array([-2, -2, 2.5, 2.5]) + np.tile((matrix @ pivot - pivot)[:2], 2))
    yaw, pitch, roll = Rotation.from_matrix(view.rotation).as_euler("yxz", degrees=True)
    fresh = surface_from_mesh(mesh, 32, rotation=(yaw, pitch, roll), frame=view.frame)
    np.testing.assert_array_equal(turned.mask, fresh.mask)
    for name in ("normals", "albedo", "depth"):
        np.testing.assert_allclose(getattr(turned, name), getattr(fresh, name), atol=1e-5)
    assert turned.pixel_size == pytest.approx(first.pixel_size)


def test_before_a_pinhole_the_axis_stays_where_it_is():
    mesh = two_boxes()
    first = surface_from_mesh(mesh, 48, intrinsics=(90.0, 80.0, 20.0, 26.0), distance=7.0)
    turned = turn(first, (25.0, 10.0, -5.0), about=-7.0)
    pivot = np.array([(24 - 20) / 90 * 7, (26 - 24) / 80 * 7, -7.0])
    before, after = first.scene.view, turned.scene.view
    world = np.linalg.inv(before.rotation) @ (pivot + before.position)
    np.testing.assert_allclose(after.place(world), before.place(world), atol=1e-12)
    np.testing.assert_allclose(before.project(world[None])[0, :2], [24, 24], atol=1e-9)
    same = turn(first, (0.0, 0.0, 0.0))
    for name in ("mask", "normals", "albedo", "depth"):
        np.testing.assert_allclose(getattr(same, name), getattr(first, name), atol=1e-6)
    back = turn(turned, (0.0, 0.0, 0.0), about=-7.0)
    np.testing.assert_allclose(back.scene.view.position, after.position)


def test_the_axis_is_in_the_middle_of_the_depths():
    first = surface_from_mesh(two_boxes(), 32, frame=(-2, -2, 2.5, 2.5))
    depths = first.depth[first.mask]
    middle = (depths.min() + depths.max()) / 2
    np.testing.assert_allclose(
        turn(first, (20.0, 0.0, 0.0)).scene.view.frame,
        turn(first, (20.0, 0.0, 0.0), middle).scene.view.frame,
        atol=1e-6,
    )
    without = Surface(first.normals, first.albedo, first.mask, scene=first.scene)
    placed = first.scene.view.place(first.scene.mesh.vertices)[:, 2]
    middle = (placed.min() + placed.max()) / 2
    np.testing.assert_allclose(
        turn(without, (20.0, 0.0, 0.0)).scene.view.frame, turn(first, (20.0, 0.0, 0.0), middle).scene.view.frame
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((1.0, 2.0),), "rotation: expected"),
        (((1.0, 2.0, np.nan),), "rotation: expected"),
        (((1.0, 2.0, 0.0),), r"rotation: expected a roll only of a Surface without depth, got yaw 1\.0, pitch 2\.0"),
        (((0.0, 180.0, 0.0),), "rotation: expected a roll only"),
        (((0.0, 0.0, 1.0), np.inf), "about: expected finite"),
        (((0.0, 0.0, 1.0), [1.0, 2.0]), "about: expected one depth"),
    ],
)
def test_other_turns_are_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        turn(noisy(depth=False), *arguments)


def test_a_single_pixel_cannot_be_turned():
    dot = Surface([[[0.0, 0.0, 1.0]]], [[1.0]], depth=[[0.0]])
    with pytest.raises(HarmonicFaceError, match="three neighbouring pixels"):
        turn(dot, (0.0, 0.0, 0.0))
