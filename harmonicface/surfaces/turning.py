"""Turning: what a Surface looks like from another side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.rotation import rotate
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces._resampling import spread
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.samples import Samples, sample
from harmonicface.surfaces.seen_again import see_again
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transport import Transport
from harmonicface.surfaces.view import View, rotation_matrix
from harmonicface.surfaces.windows import middle, turned

EXACT = 15  # decimals: quarter turns have no rounding errors for sines


def turn(surface: Surface, rotation: Sequence[float], about: float | None = None) -> Surface:
    """Return a Surface turned before the camera, in a picture of the same size and scale.

    The axis goes through the middle of the picture. A Surface with a scene is seen again from its mesh, and its
    transports are left to be computed again. With depth alone, the triangles between its pixels (`mesh_from_depth`) are
    turned and drawn at the centres of the pixels; normals, albedo and transports are those of the pixels, interpolated.
    What the picture did not show stays unknown: the mask has holes where hidden parts would come into view and where
    the surface shows its back, and it ends half a pixel earlier, at the centres of the outermost pixels. Without depth
    there is no other side, but the picture may roll.

    Parameters
    ----------
    surface
        What is turned.
    rotation
        (yaw, pitch, roll) in degrees about the camera's axes, see `rotation_matrix`.
    about
        Depth of the axis in world units; by default the middle of the depths. With a scene before an orthographic
        camera, depths are those of the turned world, which turns about its own origin; all else keeps the axis' depth.

    Returns
    -------
    Surface
        Of the same types and pixel size.

    Raises
    ------
    HarmonicFaceError
        Anything but three angles, an axis that is no number, yaw or pitch without depth, nothing in view afterwards.

    Examples
    --------
    >>> slope = Surface(np.tile([0.6, 0.0, 0.8], (2, 2, 1)), np.array([[0.1, 0.2], [0.3, 0.4]]))
    >>> quarter = turn(slope, (0.0, 0.0, 90.0))  # counterclockwise
    >>> quarter.albedo, quarter.normals[0, 0]
    (array([[0.2, 0.4], [0.1, 0.3]]), array([0. , 0.6, 0.8]))
    """
    matrix = np.round(rotation_matrix(rotation), EXACT)
    depth = _axis_depth(surface) if about is None else _number(about)
    if surface.scene is not None:
        view = surface.scene.view
        return see_again(surface.scene.mesh, turned(view, matrix, middle(view, depth)))
    if surface.depth is None and abs(matrix[2, 2] - 1) > 1e-12:
        yaw, pitch, _ = rotation
        raise HarmonicFaceError(
            f"rotation: expected a roll only of a Surface without depth, got yaw {yaw}, pitch {pitch}"
        )
    return _drawn(surface, matrix, depth)


def _axis_depth(surface: Surface) -> float:
    """Return the middle of the depths."""
    if surface.depth is not None:
        depths = surface.depth[surface.mask].astype(np.float64)
    elif surface.scene is not None:
        depths = surface.scene.view.place(surface.scene.mesh.vertices)[:, 2]
    else:
        return 0.0
    return float(depths.min() + depths.max()) / 2


def _number(about: float) -> float:
    depth = _validate.finite(about, "about")
    if depth.ndim:
        raise HarmonicFaceError(f"about: expected one depth, got {_validate.describe(depth)}")
    return float(depth)


def _drawn(surface: Surface, matrix: NDArray[np.float64], about: float) -> Surface:
    """Return the turned triangles between the pixels, drawn at the pixel centres.

    Lengths are in pixels, so that the corners of a quarter turn fall on the centres exactly.
    """
    height, width = surface.shape
    flat = (
        np.zeros(surface.shape)
        if surface.depth is None
        else (surface.depth.astype(np.float64) - about) / surface.pixel_size
    )
    mesh = mesh_from_depth(Surface(surface.normals, surface.albedo, surface.mask, flat))
    mesh = replace(mesh, vertices=mesh.vertices @ matrix.T, normals=mesh.normals @ matrix.T)
    samples = sample(mesh, View(np.eye(3), (-width / 2, -height / 2, width / 2, height / 2), surface.shape))
    inside = samples.mask.copy()
    inside[inside] = _from_the_front(mesh, samples)
    if not inside.any():
        raise HarmonicFaceError(
            "rotation: expected a part of the front in view, got none: all of it is turned away or out"
        )
    depth = None
    if surface.depth is not None:
        heights = samples.raster.depth[inside] * surface.pixel_size + about
        depth = spread(heights, inside, surface.depth.dtype)
    albedo = samples.albedo.reshape(*surface.shape, -1)  # one channel where all colours are grey
    return Surface(
        samples.normals.astype(surface.normals.dtype),
        np.broadcast_to(albedo, (*surface.shape, surface.albedo.size // inside.size))
        .reshape(surface.albedo.shape)
        .astype(surface.albedo.dtype),
        inside,
        depth,
        surface.pixel_size,
        transports=[_turned_transport(known, matrix, mesh, samples, inside) for known in surface.transports.values()],
    )


def _from_the_front(mesh: Mesh, samples: Samples) -> NDArray[np.bool_]:
    """Return for each seen pixel whether its triangle shows the side that the first camera saw."""
    corners = mesh.vertices[mesh.faces[samples.raster.triangle[samples.mask]], :2]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(a[:, 0] * b[:, 1] > a[:, 1] * b[:, 0])


def _turned_transport(
    known: Transport, matrix: NDArray[np.float64], mesh: Mesh, samples: Samples, inside: NDArray[np.bool_]
) -> Transport:
    """Return the transport of turned pixels: the harmonics turn with them."""
    values = rotate(known.values.reshape(len(known.values), -1), matrix).reshape(known.values.shape)
    rows: list[Floats] = [samples.raster.interpolate(row, mesh.faces)[inside] for row in values]
    return Transport(np.stack(rows), known.bounces)
