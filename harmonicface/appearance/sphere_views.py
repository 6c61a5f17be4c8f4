"""Several photographs of one matte ball, put together: its radiosity at every normal, and the light behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from harmonicface import _memory, _validate
from harmonicface.appearance._inverse_problem import above_zero
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import degrees
from harmonicface.harmonics.scattered import HarmonicFit, fit
from harmonicface.lighting.light import HarmonicLight
from harmonicface.reflectance.filters import lambertian_weights

Array = NDArray[np.float64]

RIM = 0.97  # of the ball's radius: pixels beyond show normals at more than 76 degrees, and the background
WORST = (
    10.0  # times that a relative error of B may weigh in its coefficients: one photo has 2179, two opposite ones 1.8
)
BEYOND = 2  # degrees fitted above those asked for, so that they do not pass for them


@dataclass(frozen=True, eq=False)
class SphereRadiosity:
    """B of a ball at normals all over the sphere, one value where any photograph showed one.

    Parameters
    ----------
    normals
        (n, 3) unit normals in the world: mean normals of the cells of a latitude-longitude grid.
    values
        (n,) radiosity, averaged over photographs without their highlights.
    solid_angles
        (n,) of the cells; they sum to 4 pi where every cell was seen.
    views
        (n,) how many photographs a cell's value is the mean of.
    dropped
        Share of the measurements that were left out as highlights.
    """

    normals: Array
    values: Array
    solid_angles: Array
    views: NDArray[np.intp]
    dropped: float

    @property
    def coverage(self) -> float:
        """The share of the sphere whose radiosity was seen, above 0 to 1."""
        return float(self.solid_angles.sum() / (4 * np.pi))

    def condition(self, order: int = 2) -> float:
        """Return how many times more a relative error of B may weigh in B_lm; 1 if all of the sphere was seen.

        Raises
        ------
        HarmonicFaceError
            Fewer cells than coefficients, or cells that leave some of them free.
        """
        return self._fit(order).condition

    def coefficients(self, order: int = 2) -> Array:
        """Return B_lm, ((order + 1)^2,): for a white ball the irradiance coefficients E_lm.

        Raises
        ------
        HarmonicFaceError
            Cells that do not determine the coefficients: too few, or too little of the sphere, `condition` above 10.
        """
        found = self._fit(order)
        if found.condition > WORST:
            seen = f"{100 * self.coverage:.0f} % of the sphere, condition {found.condition:.3g}"
            raise HarmonicFaceError(
                f"photos: expected views that determine order {order}, condition at most {WORST:g}, got {seen}"
            )
        return np.asarray(found.coefficients[: (order + 1) ** 2])

    def _fit(self, order: int) -> HarmonicFit:
        """Fit B up to some degrees above the order."""
        return fit(self.normals, self.values, _validate.at_least(order, 0, "order") + BEYOND, self.solid_angles)

    def light(self, order: int = 2, albedo: float = 1.0) -> HarmonicLight:
        """Return the light, L_lm = B_lm / (albedo A_l); 0 for odd degrees above 1, which the ball does not show.

        Raises
        ------
        HarmonicFaceError
            An albedo that is not above 0, or what `coefficients` refuses.
        """
        weights = lambertian_weights(order) * _validate.positive(albedo, "albedo")
        radiosity = self.coefficients(order)
        return HarmonicLight(np.divide(radiosity, weights, out=np.zeros_like(radiosity), where=weights != 0))


def combine_sphere_views(
    photos: Sequence[ArrayLike],
    rotations: Rotation | ArrayLike,
    rows: int = 32,
    *,
    highlight: float = 0.1,
    saturation: float = np.inf,
) -> SphereRadiosity:
    """Put photographs of one matte ball together to its radiosity B(alpha, beta), without highlights.

    A highlight moves over the ball with the camera, the matte radiosity stays where it is. So of the photographs that
    show a normal, those that are brighter than their median by more than `highlight` are left out, and the others
    averaged (the experiment of Ramamoorthi & Hanrahan, On the relationship between radiance and irradiance, 2001,
    section 6.B).

    Parameters
    ----------
    photos
        n photographs (h, h), linear, from far away: the ball touches the four borders.
    rotations
        n rotations from the camera's axes (x right, y up, z toward the camera) to the world's: scipy Rotation or
        (n, 3, 3).
    rows
        Of the grid of normals, at least 2; it has twice as many columns.
    highlight
        How much brighter than the median of the photographs a measurement may be, as a fraction of the median over
        the ball; infinity keeps all.
    saturation
        Pixels at or above it are left out.

    Returns
    -------
    SphereRadiosity
        Radiosity at the normals that were seen.

    Raises
    ------
    HarmonicFaceError
        Photographs that are not square, not finite or negative all over the ball, rotations that are none or of another
        number, bad settings, nothing below saturation.

    Examples
    --------
    >>> views = combine_sphere_views([np.full((32, 32), 0.5)] * 2, [np.eye(3), np.diag([-1.0, 1.0, -1.0])], rows=8)
    >>> views.coefficients(order=1).round(3) + 0.0  # 0.5 sqrt(4 pi), and nothing else
    array([1.772, 0.   , 0.   , 0.   ])
    """
    turns = _checked_rotations(rotations, len(photos))
    height = _validate.at_least(rows, 2, "rows")
    above_zero(highlight, "highlight")
    above_zero(saturation, "saturation")
    cells = 2 * height**2
    _memory.require(8 * cells * (4 * len(photos) + 3), f"{len(photos)} photos on a grid of {height} rows")
    sums, counts, normals = np.zeros((len(photos), cells)), np.zeros((len(photos), cells)), np.zeros((cells, 3))
    for view, (photo, turn) in enumerate(zip(photos, turns, strict=True)):
        towards, values = _ball(photo, saturation)
        towards = towards @ turn.T
        cell = _cell(towards, height)
        sums[view], counts[view] = np.bincount(cell, values, cells), np.bincount(cell, minlength=cells)
        normals += np.stack([np.bincount(cell, axis, cells) for axis in towards.T], axis=1)
    seen = counts.any(axis=0)
    if not seen.any():
        raise HarmonicFaceError(f"photos: expected pixels below saturation={saturation:g}, got none")
    means = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)[:, seen]
    median = np.nanmedian(means, axis=0)
    kept = means <= median + highlight * np.median(np.abs(median))
    weights = np.where(kept, counts[:, seen], 0)
    values = (np.where(kept, means, 0) * weights).sum(axis=0) / weights.sum(axis=0)
    measured = counts[:, seen] > 0
    bands = -np.diff(np.cos(np.pi * np.arange(height + 1) / height)) * np.pi / height
    return SphereRadiosity(
        normals[seen] / np.linalg.norm(normals[seen], axis=1, keepdims=True),
        np.asarray(values, np.float64),
        np.repeat(bands, 2 * height)[seen],
        kept.sum(axis=0),
        float(1 - kept.sum() / measured.sum()),
    )


def _checked_rotations(rotations: Rotation | ArrayLike, count: int) -> Array:
    """Return n rotation matrices, (n, 3, 3)."""
    given = rotations.as_matrix() if isinstance(rotations, Rotation) else _validate.finite(rotations, "rotations")
    matrices: Array = np.asarray(given).astype(np.float64)
    if count == 0 or matrices.shape != (count, 3, 3):
        got = f"{count} photos and rotations of shape {matrices.shape}"
        raise HarmonicFaceError(f"rotations: expected one 3 x 3 for each of at least one photo, got {got}")
    if np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max() > 1e-6 or np.linalg.det(matrices).min() < 0:
        raise HarmonicFaceError("rotations: expected orthogonal matrices of determinant 1, got others")
    return matrices


def _ball(photo: ArrayLike, saturation: float) -> tuple[Array, Array]:
    """Return normals in the camera's axes and intensities of the pixels that show the ball's face."""
    image = np.asarray(_validate.image(photo, "photo"), np.float64)
    if image.ndim != 2 or image.shape[0] != image.shape[1]:
        raise HarmonicFaceError(f"photo: expected a square grey image of a ball, got {image.shape}")
    centre = (np.arange(len(image)) + 0.5) / len(image) * 2 - 1
    x, y = np.meshgrid(centre, -centre)
    inside = (x**2 + y**2 < RIM**2) & (image < saturation)
    if inside.any() and image[inside].max() <= 0 and image[inside].min() < 0:  # noise around black is no fault
        least, most = image[inside].min(), image[inside].max()
        raise HarmonicFaceError(f"photo: expected some light on the ball, got values from {least:.4g} to {most:.4g}")
    x, y = x[inside], y[inside]
    return np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1), image[inside]


def _cell(normals: Array, rows: int) -> NDArray[np.intp]:
    """Return which cell of the latitude-longitude grid around the z axis a normal falls into."""
    row = np.minimum(np.arccos(np.clip(normals[:, 2], -1, 1)) / np.pi * rows, rows - 1).astype(np.intp)
    column = np.minimum((np.arctan2(normals[:, 1], normals[:, 0]) / (2 * np.pi) % 1) * 2 * rows, 2 * rows - 1)
    return row * 2 * rows + column.astype(np.intp)


def relative_errors(found: ArrayLike, real: ArrayLike) -> Array:
    """Return the relative L2 error of each degree after one common scale, (order + 1,); NaN-free: 0 / 0 is 0.

    The scale is the least squares one over degrees 0 to 2, as two balls' albedos are never quite known.

    Raises
    ------
    HarmonicFaceError
        Coefficients of unlike number, or of a number that is no square.

    Examples
    --------
    >>> relative_errors([2.0, 0.0, 0.0, 2.0], [1.0, 0.0, 0.0, 1.0])
    array([0., 0.])
    """
    first, second = (np.asarray(_validate.finite(value, "coefficients"), np.float64) for value in (found, real))
    if first.shape != second.shape or first.ndim != 1:
        raise HarmonicFaceError(f"coefficients: expected two vectors of one length, got {first.shape}, {second.shape}")
    order = int(np.sqrt(len(first))) - 1
    if order < 0 or len(first) != (order + 1) ** 2:
        raise HarmonicFaceError(f"coefficients: expected (order + 1)^2 of them, as 1, 4, 9, got {len(first)}")
    low = degrees(order) <= 2
    scale = (first[low] @ second[low]) / (first[low] @ first[low]) if first[low].any() else 1.0
    errors = []
    for degree in range(order + 1):
        same = degrees(order) == degree
        size = np.linalg.norm(second[same])
        error = np.linalg.norm(scale * first[same] - second[same])
        errors.append(error / size if size > 0 else 0.0 if error == 0 else np.inf)
    return np.array(errors)
