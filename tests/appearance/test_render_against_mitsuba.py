"""Pictures with cast shadows and bounces against an independent renderer's, of the same pixels."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.ndimage import binary_erosion

import harmonicface as hf
from harmonicface.bench.agreement import agreement
from harmonicface.bench.mitsuba_oracle import mitsuba_picture
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.mesh import surface_from_mesh

pytest.importorskip("mitsuba")

SIZE = 48
LAMP = hf.lights.directional([1.0, 0.3, 0.6], [1.0, 0.9, 0.7])


def ball_over_a_floor() -> Mesh:
    """Return a red ball over a grey floor, which it shadows and colours."""
    ball = trimesh.creation.icosphere(4)
    steps = np.linspace(-3, 3, 25)
    x, z = (grid.ravel() for grid in np.meshgrid(steps, steps))
    floor = np.stack([x, np.full(x.size, -1.2), z], axis=1)
    corner = (np.arange(24)[:, None] * 25 + np.arange(24)).reshape(-1, 1)
    tiles = np.concatenate([corner + np.array(half) for half in ([0, 25, 1], [1, 25, 26])])
    faces = np.concatenate([tiles, ball.faces + len(floor)])
    return Mesh(
        np.concatenate([floor, ball.vertices]),
        faces,
        np.concatenate([np.tile([0.0, 1.0, 0.0], (len(floor), 1)), ball.vertices]),
        None,
        (),
        np.full(len(faces), -1),
        np.concatenate([np.full((len(floor), 3), 0.6), np.tile([0.8, 0.2, 0.1], (len(ball.vertices), 1))]),
    )


def sunny_sky() -> hf.EnvironmentMap:
    """Return a dim sky with a sun ten pixels wide, up on the left."""
    radiance = np.random.default_rng(0).uniform(0.1, 0.3, (16, 32, 3))
    radiance[4:7, 3:6] = [6.0, 5.0, 4.0]
    return hf.EnvironmentMap(radiance)


def errors(surface: hf.Surface, light: hf.Light, paths: int, *ways: dict, depth: int | None = None) -> list[float]:
    """Return the relative RMS differences of several ways to render, over the mask without its outermost pixels."""
    mask = binary_erosion(surface.mask)
    scene = surface.scene
    pictures = [mitsuba_picture(scene.mesh, scene.view, light, paths, depth, seed=seed) for seed in (0, 1)]
    found = [agreement(hf.render(surface, light, **way), pictures, mask) for way in ways]
    assert found[0].noise < 0.03
    return [each.error for each in found]


@pytest.fixture(scope="module")
def scenery() -> hf.Surface:
    return surface_from_mesh(ball_over_a_floor(), SIZE, rotation=(0.0, 35.0, 0.0), frame=(-1.8, -1.8, 1.8, 1.8))


@pytest.mark.parametrize(("light", "paths"), [(LAMP, 64), (sunny_sky(), 128)])
def test_shadows_of_a_ball(scenery, light, paths):
    shadowed, flat = errors(scenery, light, paths, {"shadows": True}, {})
    assert shadowed < 0.02
    assert flat > 0.1  # what shadows are worth, and that the test can tell


@pytest.mark.parametrize(("light", "paths"), [(LAMP, 64), (sunny_sky(), 128)])
def test_light_thrown_back_once(scenery, light, paths):
    bounced, direct = errors(scenery, light, paths, {"bounces": 1}, {"shadows": True}, depth=3)
    assert bounced < 0.04
    assert direct > 0.06


@pytest.fixture(scope="module")
def face(data_dir) -> hf.Surface:
    folder = data_dir / "heads" / "LeePerrySmith"
    return hf.load_surface(
        folder / "LeePerrySmith.glb",
        SIZE,
        texture=folder / "Map-COL.jpg",
        flip_texture=True,
        frame=(-1.524, -0.479, 1.364, 2.409),
    )


@pytest.mark.data
@pytest.mark.parametrize("angle", [30, 85])
def test_scanned_face_under_a_lamp(face, angle):
    lamp = hf.lights.from_angles(angle, 0)
    shadowed, flat = errors(face, lamp, 25, {"shadows": True}, {})
    assert shadowed < 0.02
    assert flat > 0.05
    bounced, direct = errors(face, lamp, 49, {"bounces": 1}, {"shadows": True}, depth=3)
    assert bounced < 0.04
    assert direct > 0.02


@pytest.mark.data
def test_scanned_face_under_a_measured_sky(face, data_dir):
    sky = hf.EnvironmentMap.load(data_dir / "probes" / "latlong" / "uffizi.hdr")
    shadowed, flat = errors(face, sky, 100, {"shadows": True}, {})
    assert shadowed < 0.02
    assert flat > 0.2
    (bounced,) = errors(face, sky, 100, {"bounces": 1}, depth=3)
    assert bounced < 0.04
