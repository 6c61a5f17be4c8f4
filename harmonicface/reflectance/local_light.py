"""The light in the frame of the surface: tangent frames of normals, and coefficients turned into them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of
from harmonicface.harmonics.rotation import rotation_blocks
from harmonicface.reflectance._brdf_quadrature import Reals

POLE = 1e-300  # nearer to the pole a normal has no azimuth: subnormal numbers have lost their digits


def tangent_frames(normals: ArrayLike, gamma: ArrayLike = 0.0) -> Reals:
    """Return R = Rz(beta) Ry(alpha) Rz(gamma) of each normal: columns are tangent, bitangent and normal.

    Parameters
    ----------
    normals
        (..., 3) unit vectors with polar angle alpha and azimuth beta (0 where a normal is the z axis).
    gamma
        Radians by which the tangent is turned about the normal; broadcasts with the normals' (...).

    Returns
    -------
    array
        (..., 3, 3): `R @ local` is global, `R.T @ global` is local.

    Raises
    ------
    HarmonicFaceError
        Normals that are no unit vectors, angles that are not finite.

    Examples
    --------
    >>> tangent_frames([1.0, 0.0, 0.0]).round(6) + 0.0
    array([[ 0.,  0.,  1.],
           [ 0.,  1.,  0.],
           [-1.,  0.,  0.]])
    """
    unit, turn = oriented(normals, gamma)
    x, y, z = np.moveaxis(unit, -1, 0)
    sine = np.hypot(x, y)
    turned = (sine > POLE)[..., None]
    along = np.where(turned, np.stack([x, y], axis=-1), [1.0, 0.0]) / np.where(turned, sine[..., None], 1.0)
    down = np.stack([along[..., 0] * z, along[..., 1] * z, -sine], axis=-1)
    side = np.stack([-along[..., 1], along[..., 0], np.zeros_like(z)], axis=-1)
    cosine, sine = np.cos(turn)[..., None], np.sin(turn)[..., None]
    return np.stack(np.broadcast_arrays(cosine * down + sine * side, cosine * side - sine * down, unit), axis=-1)


def local_light(light: ArrayLike, normals: ArrayLike, gamma: ArrayLike = 0.0) -> Reals:
    r"""Return the coefficients of the light as each tangent frame sees it.

    .. math:: L(R\,\omega) = \sum_{lq} L^{local}_{lq} Y_{lq}(\omega), \qquad
              L^{local}_{lq} = \sum_m L_{lm} D^l_{mq}(\alpha, \beta, \gamma)

    in real harmonics (Ramamoorthi & Hanrahan 2004, equations 33 and 46).

    Parameters
    ----------
    light
        ((order + 1)^2,) or ((order + 1)^2, channels) real coefficients in global axes.
    normals, gamma
        See `tangent_frames`.

    Returns
    -------
    array
        ((order + 1)^2, ...) or ((order + 1)^2, ..., channels), 8 bytes a number.

    Raises
    ------
    HarmonicFaceError
        A light that is not that, normals that are no unit vectors.

    Examples
    --------
    >>> local_light([0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0]).round(6) + 0.0   # light from z is seen from -x
    array([ 0.,  0.,  0., -1.])
    """
    coefficients = real_light(light)
    unit, turn = oriented(normals, gamma)
    x, y, z = np.moveaxis(unit, -1, 0)
    sine = np.hypot(x, y)
    beta = np.where(sine > POLE, np.arctan2(y, x), 0.0)  # not pi for x = -0
    turn, alpha, beta = np.broadcast_arrays(turn, np.arctan2(sine, z), beta)
    columns = coefficients.reshape(len(coefficients), 1, -1)
    order = order_of(len(columns))
    require(8 * len(columns) * turn.size * columns.shape[2], f"light of order {order} at {turn.size} normals")
    result = np.empty((len(columns), turn.size, columns.shape[2]))
    waves = [turns_about_z(angle.ravel(), order) for angle in (alpha, beta, turn)]
    for degree in range(order + 1):
        rows = slice(degree**2, (degree + 1) ** 2)
        result[rows] = degree_in_frames(columns[rows], waves)
    return result.reshape((len(columns), *turn.shape, *coefficients.shape[1:]))


def turns_about_z(angles: Reals, order: int) -> Reals:
    """Return cos(m angle) and sin(m angle) of n turns, (2, 2 order + 1, n, 1)."""
    modes = (np.arange(-order, order + 1)[:, None] * angles)[..., None]
    return np.stack([np.cos(modes), np.sin(modes)])


def degree_in_frames(columns: Reals, waves: Sequence[Reals]) -> Reals:
    """Turn the coefficients of one degree, (2l + 1, 1, channels), into n frames: (2l + 1, n, channels).

    `waves` are those of alpha, beta and gamma. A turn about y is one about z between two tippings of the z axis, so
    that a frame costs two products with the same matrix whatever its angles.
    """
    alpha, beta, gamma = waves
    tipped = _tipping(alpha.shape[1] // 2)[len(columns) // 2]
    seen = np.tensordot(tipped, _turned(columns, beta), (0, 0))
    return _turned(np.tensordot(tipped, _turned(seen, alpha), (1, 0)), gamma)


def real_light(light: ArrayLike) -> Reals:
    """Return the real coefficients of a light, (k,) or (k, channels), checked."""
    coefficients = _validate.finite(light, "light").astype(np.float64)
    if coefficients.ndim not in (1, 2):
        expected = "expected coefficients of shape (k,) or (k, channels)"
        raise HarmonicFaceError(f"light: {expected}, got {_validate.describe(coefficients)}")
    order_of(len(coefficients))
    return coefficients


def oriented(normals: ArrayLike, gamma: ArrayLike) -> tuple[Reals, Reals]:
    """Return unit normals and the turns about them, which broadcast."""
    unit = _validate.unit_normals(normals, "normals").astype(np.float64)
    turn = _validate.finite(gamma, "gamma").astype(np.float64)
    try:
        np.broadcast_shapes(unit.shape[:-1], turn.shape)
    except ValueError:
        raise HarmonicFaceError(
            f"gamma: expected angles that broadcast with normals of shape {unit.shape}, got {_validate.describe(turn)}"
        ) from None
    return unit, turn


def _turned(rows: Reals, waves: Reals) -> Reals:
    """Return the (2l + 1, points, channels) coefficients of a function of Rz(angle) w."""
    degree, order = len(rows) // 2, waves.shape[1] // 2
    cosines, sines = waves[:, order - degree : order + degree + 1]
    result = cosines * rows
    result += sines * rows[::-1]
    return np.asarray(result)


@lru_cache(maxsize=4)
def _tipping(order: int) -> list[Reals]:
    """Return how the real harmonics of each degree mix when z goes to y: Y(Q w) = M Y(w)."""
    return rotation_blocks(np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), order)
