"""The ICT head's textures: where on the head each texel lies, and how painted texels become pictures without seams."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from harmonicface.people.ict_model import LEFT_EYE, POLYGONS_OF, RIGHT_EYE, HeadModel
from harmonicface.people.ict_places import head_places
from harmonicface.people.mottling import field_at
from harmonicface.people.skin import SkinPixels
from harmonicface.surfaces.raster import rasterize

Array = NDArray[np.float64]

MILLIMETRES, MILLIMETRES_AN_EYE = 230.0, 40.0  # across the texture of the face and of an eye, roughly
RIM = 2.5  # texels by which what is painted reaches beyond the border of the head
LARGEST_REACH = 3.0  # of a triangle's sides by which it may be continued
COARSEST, FINEST, STEP = 128, 1024, 64  # texels a side
TEXELS_A_PIXEL = 1.6


@dataclass(frozen=True, eq=False, kw_only=True)
class HeadTexels(SkinPixels):
    """Where the texels of a texture lie on the mean head.

    Parameters
    ----------
    points
        (p, 3) mm; x and y of `SkinPixels` are the first two.
    facing
        (p, 3) how much the skin faces along each axis; squares sum to 1.
    """

    points: Array
    facing: Array

    def field(self, knots: NDArray[np.float32], across: float, up: float) -> Array:
        """Return the random field through knots some mm apart, seen from the front, the sides and above, (p,).

        Each view counts where the skin faces it, so the field is nowhere stretched; and as it depends on the place on
        the head alone, it is the same on both sides of a cut in the texture.
        """
        x, y, z = self.points.T
        along = np.sign(x) * (z + 60)  # the two sides of the head are not each other's mirror image
        views = ((along, y), (x, along), (x, y))
        return np.asarray(sum(self.facing[:, k] * field_at(knots, *views[k], across, up) for k in range(3)))


@dataclass(frozen=True, eq=False)
class TextureMap:
    """One texture of the head.

    Parameters
    ----------
    texels
        The p texels that lie on the head, or near its border.
    nearest
        (side, side) which of them each texel shows: itself, or the nearest one where the texture is empty, so that
        nothing foreign bleeds in at the borders.
    """

    texels: HeadTexels
    nearest: NDArray[np.intp]

    def picture(self, values: Array) -> NDArray[np.float32]:
        """Return values of the p texels, (p,) or (p, 3), as a texture."""
        return values.astype(np.float32)[self.nearest]


def texture_side(pixel_size: float) -> int:
    """Return how many texels a side of the face's texture do for pixels of some mm."""
    wanted = TEXELS_A_PIXEL * MILLIMETRES / pixel_size
    return int(np.clip(STEP * np.ceil(wanted / STEP), COARSEST, FINEST))


@lru_cache(maxsize=2)
def texture_maps(model: HeadModel, side: int) -> tuple[TextureMap, ...]:
    """Return the four textures of a model in the order of its parts, with so many texels a side; eyes have half."""
    return tuple(_texture_map(model, part, side) for part in POLYGONS_OF)


def _texture_map(model: HeadModel, part: int, side: int) -> TextureMap:
    """Lay a part of the head out on its texture."""
    places = head_places(model)
    eye = part in (LEFT_EYE, RIGHT_EYE)
    faces = model.faces[model.parts == part]
    own, triangle, weights = _spread_out(model.uv, faces, side // 2 if eye else side)
    attributes = np.concatenate([places.points, places.normals, places.gaze], axis=1)
    found = np.einsum("pk,pkc->pc", weights, attributes[faces[triangle]])
    points, normals, gaze = found[:, :3], found[:, 3:6], found[:, 6:]
    facing = normals**2
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    texels = HeadTexels(
        x=points[:, 0],
        y=points[:, 1],
        eye_x=gaze[:, 0],
        eye_y=gaze[:, 1],
        on_eye=np.full(len(points), eye),
        blur=MILLIMETRES_AN_EYE / side if eye else MILLIMETRES / side / 2,
        points=points,
        facing=facing,
    )
    rows, columns = distance_transform_edt(~own, return_distances=False, return_indices=True)
    number = np.cumsum(own).reshape(own.shape) - 1
    return TextureMap(texels, number[rows, columns])


def _spread_out(uv: Array, faces: NDArray[np.int64], side: int) -> tuple[NDArray[np.bool_], NDArray[np.intp], Array]:
    """Return which texels lie on the head or near its border, (side, side), and of these p the triangle and weights.

    The triangles at the border reach a little beyond it, so that what is interpolated there is still theirs.
    """
    corners = uv * (side, -side) + (0, side)
    raster = rasterize(np.concatenate([corners, np.zeros((len(uv), 1))], axis=1), faces, (side, side))
    distance, (rows, columns) = distance_transform_edt(~raster.mask, return_indices=True)
    own = distance <= RIM
    triangle = raster.triangle[rows, columns][own].astype(np.intp)
    inside = raster.weights[rows, columns][own]
    centres = np.argwhere(own)[:, ::-1] + 0.5
    a, b, c = np.moveaxis(corners[faces[triangle]], 1, 0)
    system = np.stack([b - a, c - a], axis=2)
    beyond = np.linalg.solve(system, (centres - a)[..., None])[..., 0]
    step = np.concatenate([1 - beyond.sum(axis=1, keepdims=True), beyond], axis=1) - inside
    # a triangle much smaller than a texel does not know what lies a texel away from it
    reach = LARGEST_REACH / np.maximum(np.abs(step).max(axis=1, keepdims=True), LARGEST_REACH)
    return own, triangle, inside + reach * step
