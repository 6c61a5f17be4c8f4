"""Rays: which directions a triangle mesh blocks, and what a ray meets first."""

from __future__ import annotations

import importlib.util
import warnings
from typing import Protocol

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from trimesh.ray.ray_triangle import RayMeshIntersector

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.raster import checked_faces

Doubles = NDArray[np.float64]
Integers = NDArray[np.int64]

ENGINES = ("embree", "trimesh")
OFFSET = 1e-5  # of the mesh's extent: a hundred float32 roundings of a coordinate, a hundredth of a pixel in 1,000


SLOW = 100_000  # rays that are worth a word where they take minutes
_told = False


class _Engine(Protocol):
    """Rays against triangles whose coordinates are within one of the origin."""

    def blocked(self, origins: Floats, directions: Floats) -> NDArray[np.bool_]: ...

    def first_hits(self, origins: Floats, directions: Floats) -> Integers: ...


class RayCaster:
    """Rays against a triangle mesh, which both sides of a triangle stop.

    The mesh is moved and scaled into the unit box first, so that metres, millimetres and a place far from the origin
    give the same answers (the fast engine works in float32). A triangle without area stops nothing.

    Parameters
    ----------
    vertices
        (n, 3) finite positions, in any unit.
    faces
        (m, 3) vertex indices, at least one row.
    engine
        "embree" takes millions of rays a second and needs the package embreex; "trimesh" comes with trimesh and takes
        hundreds a second at a scanned head, which is enough for a few pixels. By default embree where it is installed;
        where it is not, a warning says so once after 100,000 rays.

    Raises
    ------
    HarmonicFaceError
        NaN, another shape, indices out of range, no face, an engine of another name or one that is not installed.

    Examples
    --------
    >>> wall = RayCaster([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> wall.blocked([[1.0, 1.0, 5.0], [1.0, 1.0, 5.0]], [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    array([ True, False])
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, engine: str | None = None) -> None:
        points = _validate.vectors(vertices, "vertices").astype(np.float64, copy=False)
        if points.ndim != 2:
            raise HarmonicFaceError(f"vertices: expected shape (n, 3), got {_validate.describe(points)}")
        corners = checked_faces(faces, len(points)).astype(np.int64, copy=False)
        if len(corners) == 0:
            raise HarmonicFaceError("faces: expected at least one triangle, got none")
        self.engine = _checked_engine(engine)
        self._unasked = engine is None and self.engine != "embree"
        self._cast = 0
        self._faces = corners
        used = np.zeros(len(points), dtype=np.bool_)
        used[corners] = True
        low, high = points[used].min(axis=0), points[used].max(axis=0)
        self._centre = low + (high - low) / 2
        extent = float((high - low).max())
        self._extent = extent if extent > 0 else 1.0
        self._unit = np.where(used[:, None], self._in_box(points), 0.0)
        self._engine: _Engine = (_Embree if self.engine == "embree" else _Trimesh)(self._unit, corners)

    @property
    def offset(self) -> float:
        """How far above its triangle a ray has to start so that rounding does not let it meet that one, world units."""
        return OFFSET * self._extent

    def blocked(self, origins: ArrayLike, directions: ArrayLike) -> NDArray[np.bool_]:
        """Tell which rays meet a triangle anywhere.

        Parameters
        ----------
        origins
            (n, 3) where the rays start, in the mesh's units; off the surface by `offset` at least.
        directions
            (n, 3) where they go, of any length above 0.

        Returns
        -------
        (n,) booleans.

        Raises
        ------
        HarmonicFaceError
            Other shapes, NaN, a direction of zero length.
        """
        starts, towards = _checked_rays(origins, directions)
        return self.blocked_from(self._in_box(starts), towards)

    def starts(self, points: Floats, normals: Floats) -> NDArray[np.float32]:
        """Return where rays start that leave points of the mesh on the side of some normals, for `blocked_from`."""
        return np.asarray(self._in_box(points) + OFFSET * normals, dtype=np.float32)

    def blocked_from(self, starts: Floats, directions: Floats) -> NDArray[np.bool_]:
        """Tell which rays meet a triangle: `blocked` without its checks, from what `starts` returned."""
        self._count(len(starts))
        return self._engine.blocked(starts, directions)

    def first_hits(self, origins: ArrayLike, directions: ArrayLike) -> tuple[Integers, Doubles]:
        """Return the triangle that each ray meets first, and where in it.

        Parameters
        ----------
        origins, directions
            (n, 3) as for `blocked`.

        Returns
        -------
        triangle
            (n,) its index, -1 where there is none.
        weights
            (n, 3) barycentric weights of its corners at the place, at least 0 with sum 1; all 0 where there is none.

        Raises
        ------
        HarmonicFaceError
            Other shapes, NaN, a direction of zero length.

        Examples
        --------
        >>> wall = RayCaster([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
        >>> triangle, weights = wall.first_hits([[1.0, 2.0, 5.0]], [[0.0, 0.0, -1.0]])
        >>> triangle, weights.round(6)
        (array([0]), array([[0.25, 0.25, 0.5 ]]))
        """
        starts, towards = _checked_rays(origins, directions)
        return self.hits_from(self._in_box(starts), towards)

    def hits_from(self, starts: Floats, directions: Floats) -> tuple[Integers, Doubles]:
        """Return what rays meet first: `first_hits` without its checks, from what `starts` returned."""
        self._count(len(starts))
        triangle = self._engine.first_hits(starts, directions)
        weights = np.zeros((len(triangle), 3))
        met = np.flatnonzero(triangle >= 0)
        corners = self._unit[self._faces[triangle[met]]]
        weights[met] = _weights_where_met(corners, starts[met].astype(np.float64), directions[met].astype(np.float64))
        return triangle, weights

    def _count(self, rays: int) -> None:
        """Say once that the slow engine, which nobody asked for, is slow."""
        global _told
        self._cast += rays
        if self._unasked and self._cast > SLOW and not _told:
            _told = True
            warnings.warn(
                f"more than {SLOW:,} rays without embreex, which is thousands of times as fast: "
                "pip install harmonicface[embree]",
                UserWarning,
                stacklevel=2,
            )

    def _in_box(self, points: Floats) -> Doubles:
        """Return points in coordinates in which the mesh is at most one wide, around the origin."""
        return np.asarray((points - self._centre) / self._extent)


class _Embree:
    """Embree by its Python binding embreex; the only place that knows it."""

    def __init__(self, points: Doubles, faces: Integers) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)  # no ray falls through the crack between two triangles
        TriangleMesh(
            scene=self._scene,
            vertices=_singles(points),
            indices=np.ascontiguousarray(faces, dtype=np.int32),
        )

    def blocked(self, origins: Floats, directions: Floats) -> NDArray[np.bool_]:
        if len(origins) == 0:
            return np.zeros(0, dtype=np.bool_)
        found = self._scene.run(_singles(origins), _singles(directions), query="OCCLUDED")
        return np.asarray(found >= 0)  # any triangle, without the search for the nearest one: twice as fast

    def first_hits(self, origins: Floats, directions: Floats) -> Integers:
        if len(origins) == 0:
            return np.zeros(0, dtype=np.int64)
        found = self._scene.run(_singles(origins), _singles(directions), query="INTERSECT")
        return np.asarray(found, dtype=np.int64)


class _Trimesh:
    """The ray caster of trimesh in numpy over an r-tree."""

    def __init__(self, points: Doubles, faces: Integers) -> None:
        corners = points[faces]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        self._kept = np.flatnonzero(area > 0)  # trimesh has no normals for the others
        mesh = trimesh.Trimesh(points, faces[self._kept], process=False)
        self._caster = RayMeshIntersector(mesh) if len(self._kept) else None

    def blocked(self, origins: Floats, directions: Floats) -> NDArray[np.bool_]:
        return self.first_hits(origins, directions) >= 0

    def first_hits(self, origins: Floats, directions: Floats) -> Integers:
        result = np.full(len(origins), -1, dtype=np.int64)
        if len(origins) == 0 or self._caster is None:
            return result
        triangle, ray = self._caster.intersects_id(origins, directions, multiple_hits=False)
        result[ray] = self._kept[triangle]
        return result


def _singles(array: Floats) -> NDArray[np.float32]:
    """Return what embree takes."""
    return np.ascontiguousarray(array, dtype=np.float32)


def _checked_engine(engine: str | None) -> str:
    """Return the engine's name: the one asked for if it is there."""
    installed = importlib.util.find_spec("embreex") is not None
    if engine is None:
        return "embree" if installed else "trimesh"
    if engine not in ENGINES:
        raise HarmonicFaceError(f"engine: expected one of {', '.join(ENGINES)}, got {_validate.describe(engine)}")
    if engine == "embree" and not installed:
        raise HarmonicFaceError("engine: expected embreex to be installed (the extra harmonicface[embree]), got none")
    return engine


def _checked_rays(origins: ArrayLike, directions: ArrayLike) -> tuple[Doubles, Doubles]:
    """Return origins and unit directions of as many rays."""
    starts = _validate.vectors(origins, "origins").astype(np.float64, copy=False)
    towards = _validate.vectors(directions, "directions").astype(np.float64, copy=False)
    if starts.ndim != 2 or starts.shape != towards.shape:
        raise HarmonicFaceError(
            f"rays: expected origins and directions of shape (n, 3), got {starts.shape} and {towards.shape}"
        )
    return starts, np.asarray(_validate.directions(towards, "directions"), dtype=np.float64)


def _weights_where_met(corners: Doubles, starts: Doubles, towards: Doubles) -> Doubles:
    """Return the barycentric weights of where rays cross the planes of triangles they meet (Möller & Trumbore 1997)."""
    across, along = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    gap = starts - corners[:, 0]
    side = np.cross(towards, along)
    turn = np.cross(gap, across)
    volume = np.einsum("ni,ni->n", across, side)
    volume[volume == 0] = np.finfo(float).tiny
    second = np.einsum("ni,ni->n", gap, side) / volume
    third = np.einsum("ni,ni->n", towards, turn) / volume
    weights = np.clip(np.stack([1 - second - third, second, third], axis=1), 0, 1)  # rounding beyond an edge
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))
