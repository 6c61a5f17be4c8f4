"""Rays: two engines, one answer, whatever the unit and the place."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces import rays
from harmonicface.surfaces.rays import RayCaster

embree = pytest.mark.skipif(importlib.util.find_spec("embreex") is None, reason="embreex is not installed")
ENGINES = [pytest.param("embree", marks=embree), "trimesh"]
TRIANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
FACE = np.array([[0, 1, 2]])


def bumpy(seed: int = 0) -> trimesh.Trimesh:
    ball = trimesh.creation.icosphere(subdivisions=2)
    rng = np.random.default_rng(seed)
    return trimesh.Trimesh(ball.vertices * rng.uniform(0.5, 1, (len(ball.vertices), 1)), ball.faces, process=False)


def rays_from(mesh: trimesh.Trimesh, offset: float, count: int, seed: int = 0):
    """Rays that leave triangles on their outer side."""
    rng = np.random.default_rng(seed)
    chosen = rng.integers(len(mesh.faces), size=count)
    weights = rng.dirichlet(np.ones(3), size=count)
    normals = mesh.face_normals[chosen]
    starts = np.einsum("nk,nki->ni", weights, mesh.triangles[chosen]) + offset * normals
    towards = rng.normal(size=(count, 3))
    return starts, towards * np.sign(np.einsum("ni,ni->n", towards, normals))[:, None]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_triangle_blocks_from_both_sides_and_only_ahead(engine):
    caster = RayCaster(TRIANGLE, FACE, engine)
    starts = np.array([[1.0, 1, 5], [1, 1, -5], [1, 1, 5], [3, 3, 5]])
    towards = np.array([[0.0, 0, -2], [0, 0, 3], [0, 0, 1], [0, 0, -1]])
    assert caster.blocked(starts, towards).tolist() == [True, True, False, False]
    triangle, weights = caster.first_hits(starts, towards)
    assert triangle.tolist() == [0, 0, -1, -1]
    assert weights == pytest.approx(np.array([[0.5, 0.25, 0.25]] * 2 + [[0, 0, 0]] * 2), abs=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_nearest_of_several_is_met_first(engine):
    layers = np.concatenate([np.add(TRIANGLE, (0, 0, z)) for z in (0, 2, 1)])
    caster = RayCaster(layers, np.arange(9).reshape(3, 3), engine)
    triangle, _ = caster.first_hits([[1.0, 1, 9], [1, 1, -9]], [[0.0, 0, -1], [0, 0, 1]])
    assert triangle.tolist() == [1, 0]


@embree
def test_both_engines_give_the_same_answer():
    mesh = bumpy()
    one, other = (RayCaster(mesh.vertices, mesh.faces, engine) for engine in ("embree", "trimesh"))
    starts, towards = rays_from(mesh, one.offset, 400)
    assert one.offset == other.offset
    blocked = one.blocked(starts, towards)
    assert np.array_equal(blocked, other.blocked(starts, towards))
    assert 0.1 < blocked.mean() < 0.9
    triangle, weights = one.first_hits(starts, towards)
    same, same_weights = other.first_hits(starts, towards)
    assert np.array_equal(triangle, same)
    assert np.array_equal(triangle >= 0, blocked)
    assert weights == pytest.approx(same_weights, abs=1e-9)


def test_weights_say_where_the_ray_meets():
    mesh = bumpy(1)
    caster = RayCaster(mesh.vertices, mesh.faces)
    starts, towards = rays_from(mesh, caster.offset, 2000)
    triangle, weights = caster.first_hits(starts, towards)
    met = triangle >= 0
    assert weights[met].sum(axis=1) == pytest.approx(1)
    assert weights.min() >= 0
    places = np.einsum("nk,nki->ni", weights[met], mesh.triangles[triangle[met]])
    along = places - starts[met]
    cosine = np.einsum("ni,ni->n", along, towards[met])
    assert (cosine > 0).all()
    off = np.linalg.norm(np.cross(along, towards[met]), axis=1) / np.linalg.norm(towards[met], axis=1)
    assert off.max() < 1e-5  # from the line, where the mesh is two wide


@given(seed=st.integers(0, 1000))
@settings(max_examples=10)
def test_rays_that_leave_a_convex_body_meet_nothing(seed):
    rng = np.random.default_rng(seed)
    hull = trimesh.convex.convex_hull(rng.normal(size=(40, 3)))
    caster = RayCaster(hull.vertices, hull.faces)
    starts, towards = rays_from(hull, caster.offset, 3000, seed)
    assert not caster.blocked(starts, towards).any()


@given(seed=st.integers(0, 1000), scale=st.sampled_from([1e-6, 1e-3, 1e3, 1e9]), far=st.sampled_from([0.0, 1e3]))
@settings(max_examples=10)
def test_unit_and_place_make_no_difference(seed, scale, far):
    mesh = bumpy(seed)
    caster = RayCaster(mesh.vertices, mesh.faces)
    starts, towards = rays_from(mesh, caster.offset, 2000, seed)
    moved = RayCaster((mesh.vertices + far) * scale, mesh.faces)
    same = caster.blocked(starts, towards) == moved.blocked((starts + far) * scale, towards * scale)
    assert same.sum() >= len(same) - 1  # a ray through an edge may go either way
    assert moved.offset == pytest.approx(caster.offset * scale, rel=1e-9)


def test_vertices_that_no_face_uses_do_not_count():
    stray = np.vstack([TRIANGLE, [[1e30, 0, 0]]])
    assert RayCaster(stray, FACE).offset == RayCaster(TRIANGLE, FACE).offset


@pytest.mark.parametrize("engine", ENGINES)
def test_triangles_without_area_stop_nothing(engine):
    points = np.vstack([TRIANGLE, [[2, 2, 1], [2, 2, 1], [3, 3, 1]]])
    caster = RayCaster(points, [[3, 4, 5], [0, 1, 2], [3, 3, 3]], engine)
    starts, towards = np.array([[2.5, 2.5, 5], [1, 1, 5]]), np.array([[0.0, 0, -1], [0, 0, -1]])
    assert caster.blocked(starts, towards).tolist() == [False, True]
    assert caster.first_hits(starts, towards)[0].tolist() == [-1, 1]
    nothing = RayCaster(np.zeros((3, 3)), FACE, engine)
    assert not nothing.blocked(starts, towards).any()


@pytest.mark.parametrize("engine", ENGINES)
def test_no_rays(engine):
    caster = RayCaster(TRIANGLE, FACE, engine)
    assert caster.blocked(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)
    triangle, weights = caster.first_hits(np.zeros((0, 3)), np.zeros((0, 3)))
    assert triangle.shape == (0,)
    assert weights.shape == (0, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((2, 3, 3)), FACE), r"vertices: expected shape \(n, 3\)"),
        ((TRIANGLE * np.nan, FACE), "vertices: expected finite"),
        ((TRIANGLE, FACE + 1), "faces: expected indices from 0 to 2"),
        ((TRIANGLE, np.zeros((0, 3), int)), "faces: expected at least one triangle, got none"),
        ((TRIANGLE, FACE, "optix"), "engine: expected one of embree, trimesh, got str 'optix'"),
    ],
)
def test_bad_meshes_are_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        RayCaster(*arguments)


def test_bad_rays_are_refused():
    caster = RayCaster(TRIANGLE, FACE)
    for ask in (caster.blocked, caster.first_hits):
        with pytest.raises(HarmonicFaceError, match=r"rays: expected .* of shape \(n, 3\), got \(1, 3\) and \(2, 3\)"):
            ask(np.zeros((1, 3)), np.ones((2, 3)))
        with pytest.raises(HarmonicFaceError, match="directions: expected directions, got a vector of zero length"):
            ask(np.zeros((1, 3)), np.zeros((1, 3)))


def test_without_embreex_trimesh_casts(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert RayCaster(TRIANGLE, FACE).engine == "trimesh"
    with pytest.raises(HarmonicFaceError, match="expected embreex to be installed"):
        RayCaster(TRIANGLE, FACE, "embree")


def test_many_rays_without_embreex_are_told_of_once(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(rays, "SLOW", 5)
    monkeypatch.setattr(rays, "_told", False)
    upward, below = np.tile([0.0, 0.0, 1.0], (3, 1)), np.tile([1.0, 1.0, -1.0], (3, 1))
    asked = RayCaster(TRIANGLE, FACE, engine="trimesh")  # who asks for it knows
    for _ in range(4):
        asked.blocked(below, upward)
    caster = RayCaster(TRIANGLE, FACE)
    caster.blocked(below, upward)
    with pytest.warns(UserWarning, match=r"more than 5 rays without embreex.*: pip install harmonicface\[embree\]"):
        assert caster.first_hits(below, upward)[0].tolist() == [0, 0, 0]
    RayCaster(TRIANGLE, FACE).blocked(np.tile(below, (9, 1)), np.tile(upward, (9, 1)))  # once is enough
