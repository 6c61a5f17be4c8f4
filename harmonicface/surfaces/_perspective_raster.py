"""Perspective raster: which triangle each pixel of a pinhole camera sees; what reaches behind the camera is cut off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.surfaces._triangles import Integers
from harmonicface.surfaces.perspective import PerspectiveView
from harmonicface.surfaces.raster import Raster, rasterize

SUBPIXELS = 2.0**30  # a pixel, to which corners are rounded
NEAR = 1e-4  # of the farthest vertex's distance along the axis: what is nearer the camera is not seen


def perspective_raster(placed: Floats, faces: Integers, view: PerspectiveView) -> Raster:
    """Return the nearest triangle, its weights in space and the depth at every pixel.

    1 / z is linear in the picture, so the z-buffer holds -1 / z, and a weight w_k in the picture becomes w_k / z_k over
    their sum in space (Blinn 1992, Hyperbolic interpolation). Triangles that cross the near plane are cut there.

    Parameters
    ----------
    placed
        (n, 3) vertices in the camera's axes.
    faces
        (m, 3) vertex indices.
    view
        The camera.
    """
    ahead = -placed[:, 2]
    near = NEAR * ahead.max(initial=0.0)
    if near <= 0:
        return rasterize(np.zeros((1, 3)), np.zeros((0, 3), dtype=np.int64), view.shape)
    behind = (ahead < near)[faces]
    whole = np.flatnonzero(~behind.any(axis=1))
    owner, cuts = _cut(ahead, faces, behind, near)
    corners = np.einsum("tij,tjk->tik", cuts, placed[faces[owner]]).reshape(-1, 3)
    vertices = np.concatenate([np.where((ahead >= near)[:, None], placed, [0.0, 0.0, -1.0]), corners])
    cut_faces = len(placed) + np.arange(len(corners)).reshape(-1, 3)
    drawn = np.concatenate([faces[whole], cut_faces])
    pixels = np.rint(view.pixels(vertices) * SUBPIXELS) / SUBPIXELS  # what was meant to be a pixel's centre is one
    picture = np.column_stack([pixels, -1 / vertices[:, 2]])
    raster = rasterize(picture, drawn, view.shape)
    return _in_space(raster, picture[:, 2], drawn, np.concatenate([whole, owner]), cuts, placed, faces)


def _in_space(
    raster: Raster,
    inverse: Floats,
    drawn: Integers,
    owner: Integers,
    cuts: Floats,
    placed: Floats,
    faces: Integers,
) -> Raster:
    """Return the raster with the numbers, weights and depth of the triangles in space."""
    seen = raster.mask
    number = raster.triangle[seen]
    weights = raster.weights[seen] * inverse[drawn[number]]
    weights /= weights.sum(axis=1, keepdims=True)
    part = number - (len(drawn) - len(cuts))
    is_part = part >= 0
    weights[is_part] = np.einsum("pi,pij->pj", weights[is_part], cuts[part[is_part]])
    triangle = owner[number]
    raster.triangle[seen] = triangle
    raster.weights[seen] = weights
    raster.depth[seen] = np.einsum("pk,pk->p", weights, placed[faces[triangle], 2])
    return raster


def _cut(
    ahead: Floats, faces: Integers, behind: NDArray[np.bool_], near: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return what of the crossing triangles lies beyond the near plane: owners (t,), and each new corner's weights.

    The weights, (t, 3, 3), are of the owner's corners. Of a triangle with one corner behind a quadrangle is left, of
    one with two a triangle. A cut is computed from the end behind, whichever of two triangles that share an edge asks.
    """
    owners, cuts = [], []
    for count in (1, 2):
        owner = np.flatnonzero(behind.sum(axis=1) == count)
        odd = np.argmax(behind[owner] == (count == 1), axis=1)  # the corner that is alone on its side
        order = (odd[:, None] + np.arange(3)) % 3
        corner = np.eye(3)[order]  # (t, 3, 3): weights of the corners, the odd one first
        depth = np.take_along_axis(ahead[faces[owner]], order, axis=1)
        one, other = (_crossing(corner, depth, end, near, odd_is_behind=count == 1) for end in (1, 2))
        if count == 1:
            owners += [owner, owner]
            cuts += [np.stack([one, corner[:, 1], corner[:, 2]], 1), np.stack([one, corner[:, 2], other], 1)]
        else:
            owners.append(owner)
            cuts.append(np.stack([corner[:, 0], one, other], 1))
    return np.concatenate(owners), np.concatenate(cuts)


def _crossing(corner: Floats, depth: Floats, end: int, near: float, *, odd_is_behind: bool) -> Floats:
    """Return the weights of the point between the odd corner and another at which the near plane is met."""
    back, front = (0, end) if odd_is_behind else (end, 0)
    share = ((near - depth[:, back]) / (depth[:, front] - depth[:, back]))[:, None]
    return np.asarray((1 - share) * corner[:, back] + share * corner[:, front])
