"""Patches: the pieces of a mesh between which light is exchanged, each side of each piece by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.scene import FineSamples, Scene
from harmonicface.surfaces.texture import look_up, shrink_to_density

Doubles = NDArray[np.float64]
Integers = NDArray[np.int64]

PIECES = 32  # a patch is at most about one part in so many of the mesh's extent wide


class Patches:
    """The triangles of a mesh, the large ones cut into n x n smaller ones of the same shape.

    A patch has two sides, of which the front is the one from which its corners run counterclockwise; side 2 i is the
    front of patch i, side 2 i + 1 its back.

    Parameters
    ----------
    scene
        The mesh, in the axes of its camera.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        corners = scene.points[scene.mesh.faces]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        extent = np.ptp(scene.points[np.unique(scene.mesh.faces)], axis=0).max()
        step = extent / PIECES if extent > 0 else 1.0
        self._cuts = np.maximum(1, np.ceil(np.sqrt(area) / step)).astype(np.int64)  # n of each triangle
        self._first = np.cumsum(self._cuts**2) - self._cuts**2
        self.sides = 2 * int((self._cuts**2).sum())

    def side(self, triangle: Integers, weights: Doubles, from_behind: NDArray[np.bool_]) -> Integers:
        """Return the numbers of the sides in which points lie, (n,)."""
        cuts = self._cuts[triangle]
        across, along = (weights[:, corner] * cuts for corner in (1, 2))
        row = np.minimum(along.astype(np.int64), cuts - 1)
        column = np.minimum(across.astype(np.int64), cuts - 1 - row)
        beyond = (across - column) + (along - row) > 1  # the upper of the two triangles of a small parallelogram
        # row r holds n - r small triangles that point up and n - r - 1 that point down
        place = row * (2 * cuts - row) + 2 * column + (beyond & (column + row < cuts - 1))
        return np.asarray(2 * (self._first[triangle] + place) + from_behind)

    def samples(self, sides: Integers) -> FineSamples:
        """Return the middles of some sides as samples, one each, with their normals and albedo."""
        mesh, points = self._scene.mesh, self._scene.points
        triangle, weights = self._middles(sides // 2)
        corners = mesh.faces[triangle]
        positions = np.einsum("nk,nki->ni", weights, points[corners])
        turned = np.where(sides % 2, -1.0, 1.0)[:, None]
        geometric = self._scene.triangle_normals[triangle] * turned
        normals = self._smooth(corners, weights, geometric)
        number = np.arange(len(sides))
        albedo = _albedo(mesh, triangle, weights, self._cuts[triangle])
        return FineSamples(positions, geometric, normals, albedo, number, number[:, None])

    def _middles(self, patch: Integers) -> tuple[Integers, Doubles]:
        """Return the triangle of each patch and the weights of its corners in the patch's middle."""
        triangle = np.searchsorted(self._first, patch, side="right") - 1
        cuts, place = self._cuts[triangle], patch - self._first[triangle]
        row = np.floor(cuts - np.sqrt(np.maximum(cuts**2 - place, 0))).astype(np.int64)
        row -= row * (2 * cuts - row) > place  # the root was rounded
        row += (row + 1) * (2 * cuts - row - 1) <= place
        column, down = np.divmod(place - row * (2 * cuts - row), 2)
        third = (1 + down) / 3
        second, last = (column + third) / cuts, (row + third) / cuts
        return triangle, np.stack([1 - second - last, second, last], axis=1)

    def _smooth(self, corners: Integers, weights: Doubles, geometric: Doubles) -> Doubles:
        """Return the shading normals on the sides of geometric ones; these where a mesh has none that make sense."""
        normals = np.einsum("nk,nki->ni", weights, self._scene.view.turn(self._scene.mesh.normals)[corners])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 1e-6)
        cosine = np.einsum("ni,ni->n", normals, geometric)[:, None]
        return np.where(cosine == 0, geometric, np.copysign(1.0, cosine) * normals)


def _albedo(mesh: Mesh, triangle: Integers, weights: Doubles, cuts: Integers) -> Floats:
    """Return the albedo of the patches around points, (n,) or (n, 3): the vertices', times the texture's."""
    tint = np.einsum("nk,nkc->nc", weights, mesh.vertex_albedo[mesh.faces[triangle]])
    if mesh.uv is not None:
        for number, texture in enumerate(mesh.textures):
            here = np.flatnonzero(mesh.face_texture[triangle] == number)
            if len(here) == 0:
                continue
            corners = mesh.uv[mesh.faces[triangle[here]]]
            a, b = ((corners[:, k] - corners[:, 0]) * (texture.shape[1], texture.shape[0]) for k in (1, 2))
            texels = np.sqrt(np.median(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2 / cuts[here] ** 2))
            values = look_up(shrink_to_density(texture, texels), np.einsum("nk,nki->ni", weights[here], corners))
            tint[here] *= values.reshape(len(values), -1)
    return np.asarray(tint[:, 0] if mesh.is_grey else tint)
