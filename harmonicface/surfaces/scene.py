"""Scene: the whole shape behind a Surface, so that what the view does not show can cast shadows too."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.perspective import Camera, PerspectiveView
from harmonicface.surfaces.rays import RayCaster
from harmonicface.surfaces.samples import sample

Doubles = NDArray[np.float64]
Integers = NDArray[np.int64]

FINEST = 1024  # samples a side of the picture beyond which pixels are not divided any further


@dataclass(frozen=True, eq=False)
class FineSamples:
    """Points of a mesh that share out the pixels of a picture among them.

    Parameters
    ----------
    positions
        (n, 3) where they are, in the axes of the camera and world units.
    geometric
        (n, 3) unit normals of their triangles, on the side that the camera sees.
    normals
        (n, 3) unit shading normals.
    albedo
        (n,) or (n, 3) reflectances.
    pixel
        (n,) which masked pixel each belongs to, ascending.
    slots
        (p, s) indices of the samples of each pixel; those of a pixel with fewer than s are repeated in turn.
    """

    positions: Doubles
    geometric: Floats
    normals: Floats
    albedo: Floats
    pixel: Integers
    slots: Integers

    @property
    def pixels(self) -> int:
        """How many pixels there are."""
        return len(self.slots)

    def means(self, values: Floats) -> Floats:
        """Return the means of (n,) or (n, c) values over the samples of each pixel, (p,) or (p, c)."""
        counts = np.bincount(self.pixel, minlength=self.pixels)
        columns = values.T if values.ndim == 2 else values[None]
        means = np.stack([np.bincount(self.pixel, column, minlength=self.pixels) / counts for column in columns])
        return means.T if values.ndim == 2 else means[0]


@dataclass(frozen=True, eq=False)
class Scene:
    """A mesh and the view of it that a Surface is.

    Parameters
    ----------
    mesh
        The mesh, in its own axes and units.
    view
        What turned it and cut the picture out.
    """

    mesh: Mesh
    view: Camera

    @cached_property
    def points(self) -> Doubles:
        """The vertices in the axes of the camera, in world units, (n, 3)."""
        return self.view.place(self.mesh.vertices)

    @cached_property
    def caster(self) -> RayCaster:
        """What casts rays at the mesh, in the axes of the camera."""
        return RayCaster(self.points, self.mesh.faces)

    @cached_property
    def triangle_normals(self) -> Doubles:
        """The unit normals of the triangles in the axes of the camera, (m, 3); 0 without area."""
        corners = self.points[self.mesh.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.asarray(np.divide(normals, length, out=np.zeros_like(normals), where=length > 0))

    def divisions(self, most: int = 4) -> int:
        """Return into how many parts a side a pixel is divided: `most`, or fewer in a large picture."""
        return int(np.clip(FINEST // max(self.view.shape), 1, most))

    def samples(self, mask: NDArray[np.bool_], divisions: int | None = None) -> FineSamples:
        """Return what the masked pixels see of the mesh, each divided into `divisions` x `divisions`.

        Parameters
        ----------
        mask
            (h, w) booleans, the shape of the view.
        divisions
            Parts of a pixel along each side; by default those of `divisions()`.

        Raises
        ------
        HarmonicFaceError
            A mask of another shape than the view's, or with a pixel in which the mesh is not seen.
        """
        if mask.shape != self.view.shape:
            raise HarmonicFaceError(
                f"scene: expected a view of the Surface's shape {mask.shape}, got {self.view.shape}"
            )
        parts = self.divisions() if divisions is None else divisions
        found = self._seen(mask, parts)
        missing = mask.copy()
        missing[mask] = np.bincount(found.pixel, minlength=found.pixels) == 0
        if missing.any() and parts > 1:  # a sliver over the pixel's centre that the finer grid passes by
            centres = self._seen(missing, 1)
            found = _together(found, centres, np.flatnonzero(missing[mask]))
            missing[missing] = np.bincount(centres.pixel, minlength=centres.pixels) == 0
        if missing.any():
            raise HarmonicFaceError(
                f"scene: expected a mesh seen in each pixel of the mask, got {missing.sum()} of {mask.sum()} without"
            )
        return replace(found, slots=_slots(found.pixel, int(mask.sum()), parts**2))

    def _seen(self, mask: NDArray[np.bool_], parts: int) -> FineSamples:
        """Return the samples of the masked pixels in the order of the pixels; slots are still empty."""
        samples = sample(self.mesh, self.view.finer(parts))
        number = np.cumsum(mask).reshape(mask.shape) - 1
        seen = samples.mask & np.repeat(np.repeat(mask, parts, axis=0), parts, axis=1)
        rows, columns = np.nonzero(seen)
        pixel = number[rows // parts, columns // parts]
        order = np.argsort(pixel, kind="stable")
        rows, columns = rows[order], columns[order]
        triangle = samples.raster.triangle[rows, columns]
        weights = samples.raster.weights[rows, columns]
        positions = np.einsum("nk,nki->ni", weights, self.points[self.mesh.faces[triangle]])
        side = np.where(self._seen_from_behind(), -1.0, 1.0)[triangle]
        geometric = self.triangle_normals[triangle] * side[:, None]
        empty = np.zeros((int(mask.sum()), 0), dtype=np.int64)
        normals, albedo = samples.normals[rows, columns], samples.albedo[rows, columns]
        return FineSamples(positions, geometric, normals, albedo, pixel[order], empty)

    def _seen_from_behind(self) -> NDArray[np.bool_]:
        """Tell which triangles turn their back on the camera, (m,)."""
        if isinstance(self.view, PerspectiveView):  # the camera is the origin
            corner = self.points[self.mesh.faces[:, 0]]
            return np.asarray(np.einsum("mi,mi->m", self.triangle_normals, corner) > 0)
        corners = self.view.project(self.mesh.vertices)[self.mesh.faces]
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0)  # rows point down


def _together(some: FineSamples, others: FineSamples, pixel: Integers) -> FineSamples:
    """Return samples of two sets of pixels in the order of the pixels; `pixel` numbers those of the others."""
    numbers = np.concatenate([some.pixel, pixel[others.pixel]])
    order = np.argsort(numbers, kind="stable")
    names = ("positions", "geometric", "normals", "albedo")
    joined = {name: np.concatenate([getattr(some, name), getattr(others, name)])[order] for name in names}
    return FineSamples(**joined, pixel=numbers[order], slots=some.slots)


def _slots(pixel: Integers, pixels: int, parts: int) -> Integers:
    """Return the indices of the samples of each pixel, as many for each, (p, parts)."""
    counts = np.bincount(pixel, minlength=pixels)
    first = np.cumsum(counts) - counts
    return np.asarray(first[:, None] + np.arange(parts) % counts[:, None])
