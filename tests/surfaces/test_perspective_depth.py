"""Depth maps of a pinhole camera: planes exactly, spheres to second order, scenes that the camera sees as they are."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.appearance.render import render
from harmonicface.bench.stability.hard_surfaces import bumpy_mesh, nine_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.perspective import rays
from harmonicface.surfaces.samples import sample
from harmonicface.surfaces.transfer import transport

INTRINSICS = (50.0, 45.0, 20.3, 14.8)
SHAPE = (30, 40)


def plane(normal, distance, intrinsics=INTRINSICS, shape=SHAPE):
    """z where the ray p = z (x', y', 1) meets n . p = -distance."""
    return -distance / (rays(intrinsics, shape) @ np.asarray(normal))


def sphere(centre, radius, intrinsics, shape):
    """z of the nearer of two points where z rays meets the sphere; NaN where it passes by."""
    toward = rays(intrinsics, shape)
    square = (toward**2).sum(axis=2)
    along = toward @ centre
    inner = along**2 - square * (centre @ centre - radius**2)
    with np.errstate(invalid="ignore"):
        return (along + np.sqrt(inner)) / square


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0, 0.8), (-0.3, 0.5, 0.81), (0.1, -0.9, 0.42)])
def test_a_plane_is_exact_everywhere(normal):
    normal = np.array(normal) / np.linalg.norm(normal)
    z = plane(normal, 3.0)
    z[z > 0] = np.nan
    z[np.random.default_rng(0).random(SHAPE) < 0.1] = np.nan
    surface = surface_from_depth(z, intrinsics=INTRINSICS, steepest=90)
    assert surface.mask.sum() > 300
    np.testing.assert_allclose(surface.pixel_normals, np.tile(normal, (surface.mask.sum(), 1)), atol=1e-9)
    np.testing.assert_array_equal(surface.depth[surface.mask], z[surface.mask])
    assert surface.pixel_size == pytest.approx(-z[surface.mask].mean() / np.sqrt(50 * 45))


def test_a_sphere_is_right_to_second_order():
    centre = np.array([0.1, -0.05, -4.0])
    worst = []
    for scale in (1, 2, 4):
        intrinsics, shape = tuple(scale * number for number in INTRINSICS), tuple(scale * side for side in SHAPE)
        z = sphere(centre, 1.0, intrinsics, shape)
        surface = surface_from_depth(z, intrinsics=intrinsics)
        exact = z[..., None] * rays(intrinsics, shape) - centre
        core = surface.mask & (np.einsum("ijk,ijk->ij", exact, rays(intrinsics, shape)) > 0.5)
        assert core.sum() > 300 * scale**2
        cosine = np.einsum("pk,pk->p", surface.normals[core], exact[core])
        worst.append(np.degrees(np.arccos(np.minimum(cosine, 1))).max())
    assert worst[0] < 2
    assert worst[1] < 0.3 * worst[0] and worst[2] < 0.3 * worst[1]  # a quarter, and what the rim adds


def test_the_scene_is_what_the_camera_saw():
    z = sphere(np.array([0.0, 0, -4.0]), 1.0, INTRINSICS, SHAPE)
    z = np.where(np.isnan(z), plane((0, 0, 1), 9.0), z)
    surface = surface_from_depth(z, np.random.default_rng(0).random((*SHAPE, 3)), intrinsics=INTRINSICS)
    again = sample(surface.scene.mesh, surface.scene.view)
    assert again.mask[surface.mask].all()
    np.testing.assert_allclose(again.raster.depth[surface.mask], z[surface.mask], rtol=1e-9)
    np.testing.assert_allclose(again.albedo[surface.mask], surface.pixel_albedo, atol=1e-7)
    np.testing.assert_allclose(again.normals[surface.mask], surface.pixel_normals, atol=1e-7)


def test_no_triangle_spans_the_step_between_things():
    z = np.full(SHAPE, -9.0)
    z[10:20, 10:30] = -3.0
    surface = surface_from_depth(z, intrinsics=INTRINSICS)
    assert surface.mask.all()
    np.testing.assert_allclose(surface.pixel_normals, np.tile([0, 0, 1.0], (surface.mask.sum(), 1)), atol=1e-12)
    corners = surface.scene.mesh.vertices[surface.scene.mesh.faces][..., 2]
    assert (corners == corners[:, :1]).all()
    # squares behind, those before, and half a square at each corner of the nearer thing
    assert len(corners) == 2 * (29 * 39 - 11 * 21) + 2 * 9 * 19 + 4


def test_types_are_kept():
    z = plane((0, 0, 1), 3.0).astype(np.float32)
    surface = surface_from_depth(z, 0.25, intrinsics=INTRINSICS)
    assert surface.normals.dtype == surface.depth.dtype == surface.albedo.dtype == np.float32
    assert (surface.scene.mesh.vertex_albedo == 0.25).all()


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_units_do_not_matter(scale):
    z = sphere(np.array([0.1, 0, -4.0]), 1.0, INTRINSICS, SHAPE)
    one, other = (surface_from_depth(unit * z, intrinsics=INTRINSICS) for unit in (1, scale))
    np.testing.assert_array_equal(one.mask, other.mask)
    np.testing.assert_allclose(one.normals, other.normals, atol=1e-9)


LONELY = np.full((6, 6), np.nan)
LONELY[2, 2] = LONELY[2, 3] = LONELY[3, 2] = -1.0


@pytest.mark.parametrize(
    ("depth", "arguments", "message"),
    [
        (np.ones((4, 4)), {}, "depth: expected z below 0 before the camera .*, got 16 pixels of at least 0"),
        (-np.ones((4, 4)), {"pixel_size": 1.0}, "pixel_size: expected none beside intrinsics"),
        (-np.ones((4, 4)), {"intrinsics": (0, 1, 2, 2)}, "intrinsics: expected focal lengths above 0"),
        (-np.ones((4, 4)), {"intrinsics": (1, 1, 1e9, 1e9)}, r"intrinsics: expected .cx, cy. within 100 sizes of"),
        (
            -np.ones((4, 4)),
            {"intrinsics": (1e-9, 1e-9, 4, 4)},
            r"intrinsics: expected focal lengths of at least 0\.001",
        ),
        (-np.ones((4, 4)), {"intrinsics": (1, 1, 2)}, "intrinsics: expected .fx, fy, cx, cy."),
        (np.full((4, 4), np.nan), {}, "mask: expected at least one pixel"),
        (np.full((4, 4), -np.inf), {}, "got infinity"),
        (LONELY[:3], {}, "expected pixels with neighbours"),
        (-np.ones((4, 4)), {"albedo": np.ones((3, 3))}, "albedo: expected shape"),
    ],
)
def test_bad_depth_is_refused(depth, arguments, message):
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        surface_from_depth(depth, **({"intrinsics": (4, 4, 2, 2)} | arguments))
    assert "\n" not in str(caught.value)


def test_a_pixel_without_a_triangle_is_left_outside():
    """One pixel has neighbours beside and below, those have not: a normal, and nothing to span."""
    with pytest.raises(HarmonicFaceError, match="expected three neighbouring pixels without a step"):
        surface_from_depth(LONELY, intrinsics=(4, 4, 3, 3))


def test_shadows_follow_the_true_shape():
    """A plate before a wall, light from the right: the pinhole's shadow falls where the rays through it say."""
    z = np.full(SHAPE, -4.0)
    z[8:20, 16:24] = -3.0
    surface = surface_from_depth(z, intrinsics=INTRINSICS)
    light = np.array([0.6, 0.0, 0.8])
    places = z[..., None] * rays(INTRINSICS, SHAPE)
    lit = render(surface, light, shadows=True) > 0.2
    wall = surface.mask & (z == -4)
    met = places + light * ((-3 - z) / light[2])[..., None]  # where the way to the light crosses the plate's plane
    column = INTRINSICS[2] - INTRINSICS[0] * met[..., 0] / met[..., 2]
    row = INTRINSICS[3] + INTRINSICS[1] * met[..., 1] / met[..., 2]
    # the plate's triangles end at the centres of its outermost pixels
    across, down = np.abs(column - 20) - 3.5, np.abs(row - 14) - 5.5
    hidden = np.maximum(across, down)
    assert (wall & (hidden < -0.7)).sum() > 20
    assert not lit[wall & (hidden < -0.7)].any()
    assert lit[wall & (hidden > 0.7)].all()


def test_transport_of_a_wall_is_the_closed_form_up_to_its_slant():
    z = plane((0.3, 0, 0.954), 3.0)
    surface = surface_from_depth(z, intrinsics=INTRINSICS)
    normal = surface.pixel_normals[0]
    values = transport(surface, 2).values
    expected = nine_images(normal[None])
    assert np.abs(values - expected).max() < 0.01 * np.abs(expected).max()


def test_a_pinhole_in_front_of_a_ball_sees_its_shadows():
    """From afar with a long lens the transport is that of parallel rays."""
    mesh = bumpy_mesh()
    flat = surface_from_mesh(mesh, 16)
    side = 1 / flat.pixel_size
    deep = surface_from_mesh(mesh, 16, intrinsics=(1e6 * side, 1e6 * side, 8, 8), distance=1e6)
    np.testing.assert_array_equal(flat.mask, deep.mask)
    one, other = (transport(surface, 2).values for surface in (flat, deep))
    np.testing.assert_allclose(other, one, atol=1e-4)
