"""What a wall hides of the lobes of a floor, against sums over the sphere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.gloss import gloss
from harmonicface.appearance.specular_shadows import open_share
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.io.meshes import Mesh
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.reflectance.materials import Material, Microfacet, Phong
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.transport import Transport

SIZE, HEIGHT = 24, 0.6
COATS = [Phong(8, 0.5), Microfacet(0.25, 1.4)]


def floor_before_a_wall() -> hf.Surface:
    """A floor that looks at the camera, and a wall at its right end, of endless length, that it sees edge on."""
    far = 40.0
    corners = np.array(
        [[-1, -far, 0], [1, -far, 0], [1, far, 0], [-1, far, 0], [1, -far, HEIGHT], [1, far, HEIGHT]], dtype=float
    )
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    normals = np.tile([0.0, 0.0, 1.0], (6, 1))
    mesh = Mesh(corners, faces, normals, None, (), np.full(4, -1), np.full((6, 3), 0.5))
    return surface_from_mesh(mesh, SIZE, frame=(-1, -1, 1, 1))


def the_same_as_depth() -> hf.Surface:
    """The floor as a depth map, with a wall of five columns of pixels."""
    depth = np.zeros((201, SIZE + 5))
    depth[:, SIZE:] = HEIGHT
    shape = depth.shape
    return hf.Surface(np.tile([0.0, 0.0, 1.0], (*shape, 1)), np.full(shape, 0.5), depth=depth, pixel_size=2 / SIZE)


FLOOR = floor_before_a_wall()
DEPTH = the_same_as_depth()
# distance of the pixel centres of a row from the wall, which between two pixels of a depth map rises to the second one
AWAY = 2 - (np.arange(SIZE) + 0.5) * 2 / SIZE
AWAY_IN_DEPTH = AWAY + 1 / SIZE


def row_of(surface: hf.Surface, values: np.ndarray) -> np.ndarray:
    """The values of the middle row, of the floor alone."""
    picture = np.zeros((*surface.shape, *values.shape[1:]))
    picture[surface.mask] = values
    return np.asarray(picture[surface.shape[0] // 2, :SIZE])


def open_part(coat: Material, power: int, away: np.ndarray) -> np.ndarray:
    """The share of lobe times cosine^power that gets past the wall, by a fine sum over the half sphere."""
    height = (np.arange(400) + 0.5) / 400
    turn = (np.arange(720) + 0.5) / 720 * 2 * math.pi
    weight = (coat.lobe(height) * height**power)[:, None] * np.ones(720)
    right = np.sqrt(1 - height**2)[:, None] * np.cos(turn)
    hidden = [(right > 0) & (height[:, None] < HEIGHT / distance * right) for distance in away]
    return np.array([1 - (weight * each).sum() / weight.sum() for each in hidden])


@pytest.mark.parametrize("surface", [FLOOR, DEPTH], ids=["mesh", "depth"])
@pytest.mark.parametrize("coat", COATS, ids=repr)
def test_lamps_behind_the_wall_do_not_shine(surface: hf.Surface, coat: Material) -> None:
    lamp = hf.lights.directional([1, 0, 1])  # the shadow ends as far away as the wall is high
    free, found = (row_of(surface, gloss(surface, lamp, coat, shadows=shadows)) for shadows in (False, True))
    lit, dark = HEIGHT + 2 / SIZE < AWAY, HEIGHT - 2 / SIZE > AWAY
    assert lit.sum() > 10
    assert dark.sum() > 4
    assert_allclose(found[lit], free[lit], rtol=1e-6)
    assert not found[dark].any()


@pytest.mark.parametrize("surface", [FLOOR, DEPTH], ids=["mesh", "depth"])
def test_many_lamps_are_one_after_the_other(surface: hf.Surface) -> None:
    rng = np.random.default_rng(0)
    towards, strengths = rng.normal(size=(40, 3)), rng.uniform(size=(40, 3))
    whole = gloss(surface, DirectionalLights(towards, strengths), COATS[0], shadows=True)
    parts = [
        gloss(surface, DirectionalLights(towards[i : i + 1], strengths[i : i + 1]), COATS[0], shadows=True)
        for i in range(40)
    ]
    found, expected = (row_of(surface, each)[:-3] for each in (whole, sum(parts)))  # the last see very little
    assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(expected)


@pytest.mark.parametrize("surface", [FLOOR, DEPTH], ids=["mesh", "depth"])
@pytest.mark.parametrize("coat", COATS, ids=repr)
@pytest.mark.parametrize(
    "light", [hf.lights.ambient(1.0), hf.EnvironmentMap(np.ones((64, 128, 3)))], ids=["ambient", "map"]
)
def test_light_from_everywhere_comes_through_the_open_part_of_the_lobe(
    surface: hf.Surface, coat: Material, light: hf.Light
) -> None:
    free, found = (row_of(surface, gloss(surface, light, coat, shadows=shadows)) for shadows in (False, True))
    expected = open_part(coat, 0, AWAY_IN_DEPTH if surface is DEPTH else AWAY)
    share = found / free if light.channels == 1 else (found / free)[:, 0]
    assert expected.min() < 0.75
    assert np.sqrt(np.mean((share - expected) ** 2)) < 0.02
    assert np.abs(share - expected).max() < 0.06


def test_a_map_is_weighed_with_its_light() -> None:
    """Of a map that is brighter to the right more is hidden than of an even one."""
    toward = hf.EnvironmentMap(np.ones((64, 128))).directions
    uneven = hf.EnvironmentMap(np.stack([1 + toward[..., 0], 1 - toward[..., 0], np.ones((64, 128))], axis=-1))
    free, found = (row_of(FLOOR, gloss(FLOOR, uneven, COATS[0], shadows=shadows)) for shadows in (False, True))
    height = (np.arange(400) + 0.5) / 400
    turn = (np.arange(720) + 0.5) / 720 * 2 * math.pi
    right = np.sqrt(1 - height**2)[:, None] * np.cos(turn)
    for channel, bright in enumerate((1 + right, 1 - right)):
        weight = COATS[0].lobe(height)[:, None] * bright
        expected = [1 - (weight * (height[:, None] < HEIGHT / away * right)).sum() / weight.sum() for away in AWAY]
        assert np.sqrt(np.mean((found / free)[:, channel] - expected) ** 2) < 0.02
    assert (found / free)[-1, 0] < (found / free)[-1, 2] - 0.05 < (found / free)[-1, 1] - 0.1


def test_a_dark_map_stays_dark() -> None:
    assert not gloss(FLOOR, hf.EnvironmentMap(np.zeros((8, 16))), COATS[0], shadows=True).any()


@pytest.mark.parametrize("coat", COATS, ids=repr)
@pytest.mark.parametrize(("order", "error"), [(4, 0.1), (8, 0.05)])
def test_the_share_that_the_transport_tells(coat: Material, order: int, error: float) -> None:
    mirrored = np.tile([0.0, 0.0, 1.0], (int(DEPTH.mask.sum()), 1))
    found = row_of(DEPTH, open_share(DEPTH, mirrored, coat, order))
    assert np.sqrt(np.mean((found - open_part(coat, 1, AWAY_IN_DEPTH)) ** 2)) < error


@pytest.mark.parametrize("order", [1, 2, 4])
def test_where_nothing_shadows_everything_is_open(order: int) -> None:
    tilted = np.array([[[0.6, 0, 0.8], [0, 0, 1], [-0.6, 0.64, 0.48]]])
    flat = hf.Surface(tilted, np.ones((1, 3)), depth=np.zeros((1, 3)))
    alone = hf.Surface(tilted, np.ones((1, 3)), transports=[free_transport(tilted[0], order)])
    for coat in COATS:
        mirrored = 2 * tilted[0, :, 2:] * tilted[0] - [0, 0, 1]
        assert_allclose(open_share(alone, mirrored, coat, order), 1, rtol=1e-12)
        bright = hf.lights.directional([1, 2, 3])
        assert_allclose(
            gloss(alone, bright, coat, order=order, shadows=True), gloss(alone, bright, coat, order=order), rtol=1e-9
        )
        assert open_share(flat, mirrored, coat, order).max() <= 1


def free_transport(normals: np.ndarray, order: int) -> Transport:
    return Transport(lambertian_weights(order)[:, None] * real_harmonics(normals, order))


def test_a_surface_that_hides_everything_shows_nothing() -> None:
    pit = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.ones((1, 2)), transports=[Transport(np.zeros((9, 2)))])
    assert not gloss(pit, hf.lights.ambient(1), COATS[0], order=2, shadows=True).any()


@pytest.mark.parametrize("order", [None, 2])
def test_nothing_to_cast_shadows(order: int | None) -> None:
    bare = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.ones((1, 2)))
    with pytest.raises(hf.HarmonicFaceError, match=r"surface: expected .*depth.*, got"):
        gloss(bare, hf.lights.ambient(1), COATS[0], order=order, shadows=True)
