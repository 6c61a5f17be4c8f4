"""Scenes: samples that share out the pixels, with the triangles they lie on."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.view import View


def mesh_of(vertices, faces, albedo=0.5, normals=None):
    vertices = np.asarray(vertices, dtype=np.float64)
    return Mesh(
        vertices,
        np.asarray(faces),
        np.zeros_like(vertices) if normals is None else normals,
        None,
        (),
        np.full(len(faces), -1),
        np.array(np.broadcast_to(albedo, vertices.shape)),
    )


BALL = trimesh.creation.icosphere(subdivisions=3)
SMOOTH = mesh_of(BALL.vertices, BALL.faces, normals=BALL.vertices / np.linalg.norm(BALL.vertices, axis=1)[:, None])


def test_the_means_of_the_samples_are_the_surface():
    surface = surface_from_mesh(SMOOTH, 12)
    samples = surface.scene.samples(surface.mask)
    assert samples.pixels == surface.mask.sum()
    assert samples.means(samples.albedo) == pytest.approx(surface.pixel_albedo, rel=1e-6)
    assert samples.means(samples.positions[:, 2]) == pytest.approx(surface.depth[surface.mask], rel=1e-6)
    means = samples.means(samples.normals)
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    assert means == pytest.approx(surface.pixel_normals, abs=1e-6)


def test_samples_lie_on_the_triangles_whose_normals_they_have():
    surface = surface_from_mesh(SMOOTH, 12, rotation=(20.0, 10.0, 5.0))
    samples = surface.scene.samples(surface.mask)
    assert np.linalg.norm(samples.geometric, axis=1) == pytest.approx(1)
    assert (samples.geometric[:, 2] >= 0).all()
    radius = np.linalg.norm(samples.positions, axis=1)
    assert radius.max() <= 1
    assert radius.min() > 0.99
    assert (np.einsum("ni,ni->n", samples.positions, samples.geometric) > 0.99).all()  # outward, a flat facet
    assert (np.einsum("ni,ni->n", samples.positions, samples.normals) > 0.98).all()


def test_samples_seen_from_behind_have_normals_toward_the_camera():
    inward = mesh_of(SMOOTH.vertices, SMOOTH.faces[:, ::-1])
    surface = surface_from_mesh(inward, 8)
    samples = surface.scene.samples(surface.mask)
    assert (samples.geometric[:, 2] >= 0).all()
    assert np.einsum("ni,ni->n", samples.positions, samples.geometric).min() > 0.99


def test_slots_repeat_the_samples_of_a_pixel_that_has_few():
    surface = surface_from_mesh(SMOOTH, 7)
    samples = surface.scene.samples(surface.mask)
    assert samples.slots.shape == (samples.pixels, 16)
    assert np.array_equal(samples.pixel[samples.slots], np.repeat(np.arange(samples.pixels)[:, None], 16, axis=1))
    counts = np.bincount(samples.pixel)
    assert counts.min() < 16 == counts.max()
    for slots, count in zip(samples.slots, counts, strict=True):
        uses = np.bincount(slots - slots.min())
        assert len(uses) == count
        assert np.ptp(uses) <= 1


@pytest.mark.parametrize(("size", "divisions"), [(16, 4), (256, 4), (300, 3), (512, 2), (2000, 1)])
def test_large_pictures_are_divided_less(size, divisions):
    assert Scene(SMOOTH, View.fit(SMOOTH.vertices, size)).divisions() == divisions


def test_a_sliver_over_the_centre_of_a_pixel_is_found():
    sliver = mesh_of([[-0.01, -1, 0], [0.01, -1, 0], [0.01, 1, 0], [-0.01, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    surface = surface_from_mesh(sliver, 3, frame=(-1.5, -1.5, 1.5, 1.5), supersample=1)
    assert surface.mask[:, 1].all()
    samples = surface.scene.samples(surface.mask)
    assert np.bincount(samples.pixel).tolist() == [1, 1, 1]
    assert samples.positions[:, :2] == pytest.approx(np.array([[0, 1], [0, 0], [0, -1]]), abs=1e-12)
    assert samples.slots.tolist() == [[row] * 16 for row in range(3)]


def test_masks_that_are_not_of_the_view_are_refused():
    scene = surface_from_mesh(SMOOTH, 8).scene
    with pytest.raises(
        HarmonicFaceError, match=r"scene: expected a view of the Surface's shape \(4, 4\), got \(8, 8\)"
    ):
        scene.samples(np.ones((4, 4), bool))
    with pytest.raises(
        HarmonicFaceError, match="scene: expected a mesh seen in each pixel of the mask, got 4 of 64 without"
    ):
        scene.samples(np.ones((8, 8), bool))
