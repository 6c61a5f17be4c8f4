"""The one door to transport: which way it goes, what it remembers, what it refuses."""

from __future__ import annotations

from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from harmonicface import HarmonicFaceError, Surface, surface_from_depth
from harmonicface.io.meshes import read_mesh
from harmonicface.surfaces import transfer
from harmonicface.surfaces.horizon_transport import horizon_transport
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.ray_transport import ray_transport
from harmonicface.surfaces.transfer import transport
from harmonicface.surfaces.transport import Transport


def rough(albedo: float = 0.5) -> Surface:
    return surface_from_depth(np.random.default_rng(0).normal(size=(8, 8)), albedo)


def tent(folder: Path) -> Surface:
    path = folder / "tent.obj"
    path.write_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 2 5\n")
    return surface_from_mesh(read_mesh(path), 8)


def test_depth_goes_by_horizons():
    surface = rough()
    found = transport(surface, 3)
    assert (found.order, found.bounces) == (3, 0)
    np.testing.assert_array_equal(found.values, horizon_transport(surface, 3))


def test_a_scene_goes_by_rays(tmp_path):
    surface = tent(tmp_path)
    found = transport(surface, 1)
    np.testing.assert_array_equal(found.values, ray_transport(surface, 1))


def test_bounces_only_add_light_and_none_to_a_black_surface():
    dark, bright = rough(albedo=0.0), rough(albedo=0.9)
    direct = transport(bright, 0).values
    np.testing.assert_array_equal(transport(dark, 0, bounces=1).values, direct)
    once, twice = (transport(bright, 0, bounces=count).values for count in (1, 2))
    assert (once >= direct).all() and once.sum() > 1.01 * direct.sum()
    assert (twice >= once).all() and twice.sum() > once.sum()
    assert sorted(bright.transports) == [0, 1, 2]


def test_what_is_known_is_not_computed_again():
    surface = rough()
    four = transport(surface, 4)
    with mock.patch.object(transfer, "horizon_transport", side_effect=AssertionError("computed again")):
        assert transport(surface, 4) is four
        two = transport(surface, 2)
        np.testing.assert_array_equal(two.values, four.values[:9])
        assert two.order == 2
    assert surface.transports[0] is four  # the highest order stays
    assert transport(surface, 5).order == 5
    assert surface.transports[0].order == 5


def test_a_saved_surface_remembers_without_its_scene(tmp_path):
    surface = tent(tmp_path)
    known = transport(surface, 2)
    surface.save(tmp_path / "tent.npz")
    read = Surface.load(tmp_path / "tent.npz")
    assert read.scene is None
    np.testing.assert_array_equal(transport(read, 2).values, known.values)


def test_a_known_transport_needs_no_depth():
    known = Transport(np.ones((9, 4)))
    surface = Surface(np.tile([0.0, 0, 1], (2, 2, 1)), np.ones((2, 2)), transports=[known])
    np.testing.assert_array_equal(transport(surface, 1).values, np.ones((4, 4)))
    with pytest.raises(HarmonicFaceError, match="neither depth nor scene"):
        transport(surface, 3)


@pytest.mark.parametrize(
    ("order", "bounces", "message"),
    [
        (2, 0, "surface: expected depth, which casts the shadows, got a Surface with neither depth nor scene"),
        (-1, 0, "order: expected"),
        (2, -1, "bounces: expected"),
    ],
)
def test_bad_arguments(order, bounces, message):
    with pytest.raises(HarmonicFaceError, match=message) as error:
        transport(Surface(np.tile([0.0, 0, 1], (2, 2, 1)), np.ones((2, 2))), order, bounces)
    assert "\n" not in str(error.value)


def test_orders_beyond_what_azimuths_and_rays_tell_apart(tmp_path):
    for surface in (rough(), tent(tmp_path)):
        assert transport(surface, 8).order == 8
        for order in (13, 99, 1000):
            with pytest.raises(HarmonicFaceError, match=f"order: expected at most 12 with shadows.*got {order};"):
                transport(surface, order)
