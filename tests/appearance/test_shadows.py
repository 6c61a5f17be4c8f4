"""Shadows: exact irradiance past what is in the way, on meshes and on depth maps."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.appearance.shadows import shadowed_irradiance, shadowed_radiosity
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.lighting import lights
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import HarmonicLight
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.ray_transport import ray_transport
from harmonicface.surfaces.surface import Surface

OBLIQUE = (17.0, 8.0, 5.0)  # no sample lies on an edge, where rounding chooses the triangle
LIGHTS = {
    "lamp": lights.directional([2, 1, 2]),
    "ambient": lights.ambient(0.8),
    "sun": lights.area([2, 1, 2], 0.5),
    "sky": lights.sky(),
    "natural": lights.natural(0),
    "harmonics": HarmonicLight([1.0, 0.2, 0.5, 0.1, 0.0, 0.1, 0.0, 0.1, -0.2]),
    "together": lights.directional([2, 1, 2]) + lights.sky(0.5),
}


def mesh_of(vertices, faces, albedo=0.5):
    vertices = np.asarray(vertices, dtype=np.float64)
    colours = np.array(np.broadcast_to(albedo, vertices.shape))
    return Mesh(vertices, np.asarray(faces), np.zeros_like(vertices), None, (), np.full(len(faces), -1), colours)


def hills(count=17):
    x, y = np.meshgrid(np.linspace(-3, 3, count), np.linspace(3, -3, count))
    return surface_from_depth(np.sin(2 * x) * np.cos(2 * y), pixel_size=6 / (count - 1))


def hilly_mesh(albedo=0.5, scale=1.0, far=0.0):
    mesh = mesh_from_depth(hills())
    return mesh_of((mesh.vertices + far) * scale, mesh.faces, albedo)


def wall_on_a_floor(height=2.0):
    """A floor from x = 0 to 8 and a wall along x = 0 that the camera does not see."""
    vertices = [[0, -9, 0], [8, -9, 0], [8, 9, 0], [0, 9, 0], [0, -9, height], [0, 9, height]]
    return mesh_of(vertices, [[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]])


def test_the_shadow_of_a_wall_ends_where_it_must():
    """A lamp at 45 degrees, a wall 2.25 high: the shadow covers two pixels and a quarter of the third."""
    surface = surface_from_mesh(wall_on_a_floor(2.25), (2, 8), frame=(0, -1, 8, 1))
    found = shadowed_irradiance(surface, lights.directional([-1, 0, 1]))
    expected = np.sqrt(0.5) * np.array([0, 0, 0.75, 1, 1, 1, 1, 1])
    assert found.reshape(2, 8) == pytest.approx(np.tile(expected, (2, 1)), abs=1e-6)
    assert found.dtype == np.float32


def test_a_ball_throws_an_elliptical_shadow():
    ball = trimesh.creation.icosphere(subdivisions=4)
    floor = np.array([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]])
    vertices = np.vstack([np.add(ball.vertices, (-4, 0, 3)), floor])
    count = len(ball.vertices)
    faces = np.vstack([ball.faces, [[count, count + 1, count + 2], [count, count + 2, count + 3]]])
    surface = surface_from_mesh(mesh_of(vertices, faces), 60, frame=(-3, -3, 3, 3))
    towards = np.array([-1.0, 0.0, 1.0]) / np.sqrt(2)  # the shadow's centre is at x = -1
    shade = 1 - shadowed_irradiance(surface, lights.directional(towards)).reshape(60, 60) * np.sqrt(2)
    area = shade.sum() * surface.pixel_size**2
    assert area == pytest.approx(np.pi * np.sqrt(2), rel=5e-3)
    x = np.linspace(-3, 3, 121)[1::2]
    assert (shade.sum(axis=0) @ x) / shade.sum() == pytest.approx(-1, abs=5e-3)


def test_beside_a_long_wall_under_the_sky():
    surface = surface_from_mesh(wall_on_a_floor(), 16, frame=(0, -4, 8, 4))
    fine = (np.arange(64) + 0.5) / 8
    x, y = fine, fine[:, None] - 4
    slant = np.hypot(x, 2)  # the wall is two rectangles, 9 + y and 9 - y long and 2 high
    hidden = sum(np.arctan(side / x) - x / slant * np.arctan(side / slant) for side in (9 + y, 9 - y)) / (2 * np.pi)
    expected = 1 - hidden.reshape(16, 4, 16, 4).mean(axis=(1, 3))
    error = shadowed_irradiance(surface, lights.ambient(1.0)).reshape(16, 16) - expected
    assert np.abs(error).max() < 0.06  # of one pixel, by its own 512 directions
    assert np.abs(error.mean(axis=0)).max() < 0.01
    assert abs(error.mean()) < 2e-3


@pytest.mark.parametrize("name", LIGHTS)
def test_nothing_in_the_way_of_a_convex_body(name):
    light = LIGHTS[name]
    body = trimesh.creation.icosphere(subdivisions=2)
    surface = surface_from_mesh(mesh_of(body.vertices, body.faces), 10)
    samples = surface.scene.samples(surface.mask)
    free = samples.means(light.irradiance(samples.normals))
    assert shadowed_irradiance(surface, light) == pytest.approx(free, abs=1e-6)
    assert shadowed_radiosity(surface, light) == pytest.approx(0.5 * free, abs=1e-6)
    assert shadowed_irradiance(surface, light, bounces=1) == pytest.approx(free, abs=1e-6)


@pytest.mark.parametrize("name", LIGHTS)
def test_nothing_in_the_way_of_a_plane(name):
    plane = surface_from_depth(np.add.outer(0.3 * np.arange(9.0), 0.5 * np.arange(8.0)))
    light = LIGHTS[name]
    for bounces in (0, 1):
        found = shadowed_irradiance(plane, light, bounces)
        assert found == pytest.approx(light.irradiance(plane.pixel_normals), rel=1e-5)  # float32


@pytest.mark.parametrize(("scale", "far"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)])
@pytest.mark.parametrize("name", ["lamp", "natural"])
def test_unit_and_place_make_no_difference(name, scale, far):
    reference = surface_from_mesh(hilly_mesh(), 12, rotation=OBLIQUE)
    moved = surface_from_mesh(hilly_mesh(scale=scale, far=far), 12, rotation=OBLIQUE)
    same = shadowed_irradiance(reference, LIGHTS[name], 1)
    assert np.abs(shadowed_irradiance(moved, LIGHTS[name], 1) - same).max() < 1e-5


@pytest.mark.parametrize("name", LIGHTS)
def test_shadows_only_take_and_bounces_only_give(name):
    light = LIGHTS[name]
    for surface in (surface_from_mesh(hilly_mesh(), 12, rotation=OBLIQUE), hills()):
        free = light.irradiance(surface.pixel_normals)
        if surface.scene is not None:
            samples = surface.scene.samples(surface.mask)
            free = samples.means(light.irradiance(samples.normals))
        direct, one, two = (shadowed_irradiance(surface, light, bounces) for bounces in range(3))
        if name != "harmonics":  # a series may be negative somewhere
            assert (direct <= free + 1e-6).all()
            assert direct.min() >= 0
        assert direct.mean() < 0.99 * free.mean()
        assert (one >= direct).all()
        assert 0 < (two - one).mean() < 0.5 * (one - direct).mean()  # albedo 0.5


def test_a_depth_map_is_shadowed_as_its_mesh_is():
    surface = hills(33)
    edge = 3 + surface.pixel_size / 2
    seen = surface_from_mesh(mesh_from_depth(surface), 33, frame=(-edge, -edge, edge, edge))
    assert seen.mask[1:-1, 1:-1].all()
    for name in ("ambient", "natural", "together"):
        whole = np.zeros((2, 33, 33))
        for picture, one in zip(whole, (surface, seen), strict=True):
            picture[one.mask] = shadowed_irradiance(one, LIGHTS[name])
        by_depth, by_mesh = whole[:, 2:-2, 2:-2]
        assert by_depth.mean() == pytest.approx(by_mesh.mean(), rel=0.03)
        assert np.corrcoef(by_depth.ravel(), by_mesh.ravel())[0, 1] > 0.98


def test_a_pinhole_far_away_sees_the_same_shadows():
    far, half = 1e5, 2.0
    focal = far / (2 * half / 12)
    intrinsics = (focal, focal, 6.0, 6.0)
    pinhole = surface_from_mesh(hilly_mesh(), 12, rotation=OBLIQUE, intrinsics=intrinsics, distance=far)
    x, y = pinhole.scene.view.position[:2]
    frame = (x - half, y - half, x + half, y + half)
    same = surface_from_mesh(hilly_mesh(), 12, rotation=OBLIQUE, frame=frame)
    assert pinhole.mask.all()
    for name in ("lamp", "natural"):
        expected = shadowed_irradiance(same, LIGHTS[name])
        difference = np.abs(shadowed_irradiance(pinhole, LIGHTS[name]) - expected)
        assert difference.mean() < 0.01 * expected.mean()


def test_a_step_in_a_depth_map():
    """Five units high beside the pixel, one unit away: light at less than 79 degrees does not get in."""
    step = Surface(np.tile([0.0, 0.0, 1.0], (1, 3, 1)), np.ones((1, 3)), depth=np.array([[0.0, 0.0, 5.0]]))
    for degrees, lit in ((78.0, 0.0), (79.0, 1.0)):
        lamp = lights.directional([np.cos(np.radians(degrees)), 0, np.sin(np.radians(degrees))])
        found = shadowed_irradiance(step, lamp)
        assert found[1:] == pytest.approx(np.sin(np.radians(degrees)) * np.array([lit, 1.0]))


def test_harmonic_light_goes_through_the_transport():
    surface = surface_from_mesh(hilly_mesh(), 10, rotation=OBLIQUE)
    light = LIGHTS["harmonics"]
    assert shadowed_irradiance(surface, light) == pytest.approx(light.values @ ray_transport(surface, 2), abs=1e-5)


def test_a_sun_of_a_million_to_one_casts_the_shadow_of_a_lamp():
    radiance = np.ones((64, 128))
    radiance[20, 80] = 1e9
    sky = EnvironmentMap(radiance).rotated(np.diag([-1.0, 1.0, -1.0]))  # its sun in front
    towards, strength = sky.directions[20, 80], sky.strengths[20, 80]
    assert towards[2] > 0.5
    surface = surface_from_mesh(hilly_mesh(), 16, rotation=OBLIQUE)
    hard = shadowed_irradiance(surface, DirectionalLights(towards[None], [strength]))
    found = shadowed_irradiance(surface, sky)
    whole = np.bincount(surface.scene.samples(surface.mask).pixel) == 16
    assert (hard == 0).any()
    assert found[hard == 0].max() < 1e-3 * strength
    assert found[whole] == pytest.approx(hard[whole], abs=0.02 * strength)


def test_lamps_one_by_one_or_as_many_give_the_same():
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20, 3))
    strengths = rng.random(20)
    surface = surface_from_mesh(hilly_mesh(), 12, rotation=OBLIQUE)
    many = shadowed_irradiance(surface, DirectionalLights(directions, strengths))
    few = DirectionalLights(directions[:10], strengths[:10]) + DirectionalLights(directions[10:], strengths[10:])
    hard = shadowed_irradiance(surface, few)
    assert np.sqrt(np.mean((many - hard) ** 2)) < 0.02 * hard.mean()


def test_colours():
    grey, coloured = hilly_mesh(), hilly_mesh([0.8, 0.4, 0.2])
    white, tinted = LIGHTS["lamp"], LIGHTS["lamp"] + [1.0, 0.5, 0.0] * LIGHTS["harmonics"]
    for mesh, light, irradiance, radiosity in (
        (grey, white, (36,), (36,)),
        (grey, tinted, (36, 3), (36, 3)),
        (coloured, white, (36,), (36, 3)),
        (coloured, tinted, (36, 3), (36, 3)),
    ):
        surface = surface_from_mesh(mesh, 6)
        found = shadowed_irradiance(surface, light)
        thrown = shadowed_radiosity(surface, light)
        assert found.shape == irradiance
        assert thrown.shape == radiosity
        albedo = surface.pixel_albedo.reshape(36, -1)
        assert thrown.reshape(36, -1) == pytest.approx(albedo * found.reshape(36, -1), abs=1e-6)
        assert shadowed_radiosity(surface, light, 1).shape == radiosity
        assert shadowed_irradiance(surface, light, 1).ndim == len(radiosity)


def test_the_mean_over_a_pixel_is_that_of_the_product():
    """White where the shadow falls and black where the sun does: a photograph is black, the product of means is not."""
    vertices = np.array(
        [[0.0, -9, 0], [0.5, -9, 0], [0.5, 9, 0], [0, 9, 0], [0.5, -9, 0], [1, -9, 0], [1, 9, 0], [0.5, 9, 0]]
    )
    wall = [[0.0, -9, 0.5], [0, 9, 0.5]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [0, 3, 9], [0, 9, 8]]
    albedo = np.repeat([1.0, 0.0, 1.0], [4, 4, 2])[:, None]
    surface = surface_from_mesh(mesh_of(np.vstack([vertices, wall]), faces, albedo), 1, frame=(0, 0, 1, 1))
    lamp = lights.directional([-1, 0, 1])
    assert surface.pixel_albedo == pytest.approx(0.5)
    assert shadowed_irradiance(surface, lamp) == pytest.approx(np.sqrt(0.5) / 2)
    assert shadowed_radiosity(surface, lamp) == pytest.approx(0)


def test_an_albedo_that_was_changed_counts():
    surface = surface_from_mesh(hilly_mesh(), 8)
    lamp = LIGHTS["lamp"]
    before = shadowed_radiosity(surface, lamp)
    painted = Surface(surface.normals, 2 * surface.albedo, surface.mask, scene=surface.scene)
    assert shadowed_radiosity(painted, lamp) == pytest.approx(2 * before)
    black = surface_from_mesh(hilly_mesh(0.0), 8)
    assert not shadowed_radiosity(black, lamp).any()
    washed = Surface(black.normals, surface.albedo, black.mask, scene=black.scene)
    assert shadowed_radiosity(washed, lamp) == pytest.approx(before, abs=1e-6)
    coloured = surface_from_mesh(hilly_mesh([0.8, 0.4, 0.2]), 8)
    grey = Surface(coloured.normals, surface.albedo, coloured.mask, scene=coloured.scene)
    assert shadowed_radiosity(grey, lamp) == pytest.approx(before, abs=1e-6)


def test_a_spike_one_pixel_wide():
    """Thin as it is, it throws a shadow, and nothing becomes NaN."""
    depth = np.zeros((9, 9))
    depth[4, 4] = 50.0
    lamp = lights.directional([1, 0, 1])
    flat = Surface(np.tile([0.0, 0.0, 1.0], (9, 9, 1)), np.full((9, 9), 0.5), depth=depth)
    found = shadowed_irradiance(flat, lamp, 1).reshape(9, 9)
    assert np.isfinite(found).all()
    assert found[4, :4] == pytest.approx(0, abs=0.05)
    assert found[0] == pytest.approx(np.sqrt(0.5), abs=0.05)
    base = np.array([[-1e-3, -1e-3, 0], [1e-3, -1e-3, 0], [0, 1e-3, 0], [0, 0, 5]])
    floor = np.array([[-4.0, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]])
    needle = mesh_of(np.vstack([base, floor]), [[0, 1, 3], [1, 2, 3], [2, 0, 3], [4, 5, 6], [4, 6, 7]])
    surface = surface_from_mesh(needle, 9)
    for light in LIGHTS.values():
        assert np.isfinite(shadowed_irradiance(surface, light, 1)).all()


@given(seed=st.integers(0, 1000))
@settings(max_examples=8)
def test_soups_of_triangles_stay_between_dark_and_lit(seed):
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(30, 3))
    faces = np.vstack([rng.integers(30, size=(20, 3)), [[0, 1, 2], [3, 3, 4]]])  # one without area
    surface = surface_from_mesh(mesh_of(vertices, faces), 6)
    found = shadowed_irradiance(surface, lights.sky() + lights.directional([0, 1, 1]))
    assert (found >= 0).all()
    assert (found <= 2 + 1e-6).all()


def test_bad_arguments_are_refused():
    bare = Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2)))
    for ask in (shadowed_irradiance, shadowed_radiosity):
        with pytest.raises(
            HarmonicFaceError, match="surface: expected a scene or depth, which cast the shadows, got neither"
        ):
            ask(bare, LIGHTS["lamp"])
        with pytest.raises(HarmonicFaceError, match="bounces: expected an integer of at least 0"):
            ask(bare, LIGHTS["lamp"], -1)
