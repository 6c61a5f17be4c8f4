"""The oracle itself against closed forms: pixel grid, a sphere, shadows, maps, a bowl that throws light back."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import harmonicface as hf
from harmonicface.bench.agreement import agreement
from harmonicface.bench.mitsuba_oracle import mitsuba_picture
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.lighting.light import HarmonicLight
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.view import View

pytest.importorskip("mitsuba")

FRONT = np.array([0.0, 0.0, 1.0])


def mesh_of(vertices, faces, normals, albedo=0.5, uv=None, textures=(), face_texture=None) -> Mesh:
    points = np.asarray(vertices, dtype=np.float64)
    return Mesh(
        points,
        np.asarray(faces, dtype=np.int64),
        np.broadcast_to(np.asarray(normals, dtype=np.float64), points.shape).copy(),
        None if uv is None else np.asarray(uv, dtype=np.float64),
        textures,
        np.full(len(faces), -1 if face_texture is None else face_texture),
        np.broadcast_to(np.asarray(albedo, dtype=np.float64), points.shape).copy(),
    )


def wall(half: float = 1.0, height: float = 0.0, albedo=0.5, **dress) -> Mesh:
    corners = [[-half, -half, height], [half, -half, height], [half, half, height], [-half, half, height]]
    return mesh_of(corners, [[0, 1, 2], [0, 2, 3]], FRONT, albedo, **dress)


def ball(albedo=0.5, subdivisions: int = 5) -> Mesh:
    sphere = trimesh.creation.icosphere(subdivisions)
    return mesh_of(sphere.vertices, sphere.faces, sphere.vertices, albedo)


def ball_normals(size: int, fine: int) -> np.ndarray:
    """Return the unit sphere's normals at the centres of `fine` parts of a pixel, NaN beside it."""
    steps = (np.arange(size * fine) + 0.5) / (size * fine / 2) - 1
    x, y = np.meshgrid(steps, -steps)
    inside = x**2 + y**2 < 1
    z = np.sqrt(np.where(inside, 1 - x**2 - y**2, np.nan))
    return np.stack([x, y, z], axis=-1)


def block_means(picture: np.ndarray, fine: int) -> np.ndarray:
    height, width = picture.shape[0] // fine, picture.shape[1] // fine
    return picture.reshape(height, fine, width, fine, *picture.shape[2:]).mean(axis=(1, 3))


def test_pixels_are_the_views_pixels():
    corners = np.array([[-3.1, 0.4, 2.0], [2.2, -1.7, -1.0], [0.3, 3.3, 0.5]])
    view = View.fit(corners, (30, 50), rotation=(20.0, -10.0, 35.0), frame=(-6.0, -2.5, 5.0, 4.0))
    picture = mitsuba_picture(mesh_of(corners, [[0, 1, 2]], FRONT, 1.0), view, hf.lights.ambient(1.0), samples=1024)
    assert picture.shape == (30, 50, 3)
    seen = view.project(corners)[:, :2]
    (ax, ay), (bx, by) = seen[1] - seen[0], seen[2] - seen[0]
    area = abs(ax * by - ay * bx) / 2
    coverage = picture[..., 0].astype(np.float64)
    rows, columns = np.indices(coverage.shape) + 0.5
    centroid = np.array([(coverage * columns).sum(), (coverage * rows).sum()]) / coverage.sum()
    assert coverage.sum() == pytest.approx(area, abs=0.2)
    np.testing.assert_allclose(centroid, seen.mean(axis=0), atol=0.01)


def test_ball_under_a_lamp_is_the_clamped_cosine():
    normals = ball_normals(32, 8)
    lamp = hf.lights.directional([1.0, 0.4, 0.6], [1.0, 0.5, 0.25])
    view = View.fit(np.zeros((1, 3)), 32, frame=(-1, -1, 1, 1))
    pictures = [mitsuba_picture(ball([0.8, 0.6, 0.4]), view, lamp, samples=64, seed=seed) for seed in (0, 1)]
    towards = np.array([1.0, 0.4, 0.6]) / np.linalg.norm([1.0, 0.4, 0.6])
    cosine = block_means(np.maximum(normals @ towards, 0), 8)
    mask = np.isfinite(cosine)
    expected = cosine[..., None] * np.array([0.8, 0.3, 0.1])
    found = agreement(expected, pictures, mask)
    assert found.error < 0.003
    assert found.noise < 0.003


def test_wall_shows_its_albedo_and_its_texture_upright():
    texture = np.random.default_rng(0).uniform(0.1, 0.9, (4, 4, 3)).astype(np.float32)
    uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    view = View.fit(wall().vertices, 4)
    for light, tolerance in ((hf.lights.ambient(2.0), 0.01), (hf.lights.directional(FRONT, 2.0), 1e-4)):
        plain = mitsuba_picture(wall(albedo=[0.1, 0.2, 0.3]), view, light, samples=1024)
        np.testing.assert_allclose(plain, np.broadcast_to([0.2, 0.4, 0.6], (4, 4, 3)), rtol=tolerance)
    lamp = hf.lights.directional(FRONT, 2.0)
    for image in (texture, texture[..., 0]):
        dressed = wall(albedo=0.5, uv=uv, textures=(image,), face_texture=0)
        seen = mitsuba_picture(dressed, View.fit(wall().vertices, 100), lamp, samples=16)
        expected = np.broadcast_to(np.atleast_3d(image), (4, 4, 3))
        np.testing.assert_allclose(seen[12::25, 12::25], expected, atol=0.01)  # around the texels' centres


def test_plate_casts_its_shadow_where_the_lamp_puts_it():
    plate, ground = wall(0.2, height=0.5), wall(1.0)
    both = mesh_of(
        np.concatenate([ground.vertices, plate.vertices]), np.concatenate([ground.faces, plate.faces + 4]), FRONT, 1.0
    )
    view = View.fit(ground.vertices, 40)
    picture = mitsuba_picture(both, view, hf.lights.directional([1.0, 0.0, 1.0]), samples=16)[..., 0]
    expected = np.full((40, 40), np.sqrt(0.5))
    expected[16:24, 6:14] = 0  # the plate at 0.5 above, a lamp at 45 degrees on the right: 10 pixels to the left
    np.testing.assert_allclose(picture, expected, atol=1e-5)


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("shape", [(16, 32), (9, 15, 3)])
def test_map_shines_from_where_ours_says(shape, rotated):
    rng = np.random.default_rng(1)
    sky = hf.EnvironmentMap(rng.uniform(0, 1, shape) ** 2)
    if rotated:
        sky = sky.rotated(Rotation.random(rng=rng))
    fine = sky.converted("latlong", 64)  # for the exact sum over what is bilinear between the pixels
    view = View.fit(np.zeros((1, 3)), 16, frame=(-1, -1, 1, 1))
    pictures = [mitsuba_picture(ball(1.0, 4), view, sky, samples=512, seed=seed) for seed in range(3)]
    normals = ball_normals(16, 4)
    mask = np.isfinite(normals).all(axis=2)
    irradiance = fine.irradiance(normals[mask])
    exact = np.zeros((*mask.shape, 3))
    exact[mask] = irradiance if irradiance.ndim == 2 else irradiance[:, None]
    inside = block_means(normals[..., 2] > 0.3, 4) == 1  # not the rim, where a pixel is partly beside the ball
    found = agreement(block_means(exact, 4), pictures, inside)
    assert found.error < 0.005
    assert found.noise < 0.015


def bowl(albedo: float) -> Mesh:
    """Return a hemisphere that is open toward the camera, its normals inside."""
    sphere = ball(albedo)
    low = sphere.vertices[sphere.faces][..., 2].max(axis=1) < 1e-6
    return mesh_of(sphere.vertices, sphere.faces[low], -sphere.vertices, albedo)


def test_one_bounce_in_a_bowl_is_the_integrating_spheres():
    albedo = 0.6
    view = View.fit(np.zeros((1, 3)), 32, frame=(-1, -1, 1, 1))
    lamp = hf.lights.directional(FRONT)
    cosine = block_means(ball_normals(32, 8)[..., 2], 8)[..., None].repeat(3, axis=2)
    mask = np.isfinite(cosine[..., 0])
    # any part of a sphere sees any other part alike: the flux through the opening over the area of the whole sphere
    for depth, bounced in ((2, 0.0), (3, albedo * albedo / 4)):
        pictures = [mitsuba_picture(bowl(albedo), view, lamp, 128, depth, seed) for seed in (0, 1)]
        found = agreement(albedo * cosine + bounced, pictures, mask)
        assert found.error < 0.003
        assert found.noise < 0.01
        assert pictures[0][mask].mean() == pytest.approx((albedo * cosine[mask]).mean() + bounced, rel=0.002)


def test_furnace_gives_what_comes_in():
    """A white ball in light from everywhere shows its light, and cannot be told from it."""
    view = View.fit(np.zeros((1, 3)), 16, frame=(-0.7, -0.7, 0.7, 0.7))
    for depth in (None, 3):
        picture = mitsuba_picture(ball(1.0, 3), view, hf.lights.ambient([0.3, 0.2, 0.1]), samples=64, depth=depth)
        np.testing.assert_allclose(picture.mean(axis=(0, 1)), [0.3, 0.2, 0.1], rtol=0.01)


def test_both_sides_are_seen():
    view = View.fit(wall().vertices, 4)
    turned = mesh_of(wall().vertices, wall().faces[:, ::-1], -FRONT, 0.5)
    picture = mitsuba_picture(turned, view, hf.lights.directional(FRONT), samples=4)
    np.testing.assert_allclose(picture, 0.5, rtol=1e-5)


def test_seeds_differ_and_repeat():
    view = View.fit(np.zeros((1, 3)), 8, frame=(-1, -1, 1, 1))
    pictures = [mitsuba_picture(ball(0.5, 2), view, hf.lights.ambient(), samples=4, seed=seed) for seed in (0, 0, 1)]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_lights_add():
    view = View.fit(wall().vertices, 4)
    lamps = hf.lights.directional(FRONT) + DirectionalLights([[0.0, 0.6, 0.8]], [0.5]) + hf.lights.ambient(0.25)
    picture = mitsuba_picture(wall(albedo=1.0), view, lamps, samples=256)
    np.testing.assert_allclose(picture.mean(), 1.0 + 0.4 + 0.25, rtol=0.01)


@pytest.mark.parametrize(
    ("light", "message"),
    [
        (HarmonicLight(np.ones(4)), "got a HarmonicLight"),
        (hf.EnvironmentMap(np.ones((6, 4, 4)), "cube"), "got a cube map"),
        (hf.lights.ambient() + hf.lights.ambient(), "at most one ambient light or environment, got 2"),
    ],
)
def test_lights_it_does_not_take(light, message):
    with pytest.raises(HarmonicFaceError, match=message):
        mitsuba_picture(wall(), View.fit(wall().vertices, 4), light)


def test_meshes_it_does_not_take():
    view = View.fit(wall().vertices, 4)
    uv, texture = np.zeros((4, 2)), np.ones((2, 2), np.float32)
    colours = wall(albedo=np.linspace(0, 1, 4)[:, None], uv=uv, textures=(texture,), face_texture=0)
    with pytest.raises(HarmonicFaceError, match="one colour of the vertices, got several"):
        mitsuba_picture(colours, view, hf.lights.ambient())
    bare = mesh_of(wall().vertices, wall().faces, 0.0)
    with pytest.raises(HarmonicFaceError, match="got vertices without"):
        mitsuba_picture(bare, view, hf.lights.ambient())


def test_views_it_does_not_take():
    with pytest.raises(HarmonicFaceError, match="expected an orthographic View, got a str"):
        mitsuba_picture(wall(), "front", hf.lights.ambient())
