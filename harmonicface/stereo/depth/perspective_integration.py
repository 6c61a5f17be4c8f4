"""Integration before a pinhole camera: normals -> distances along its rays, in the units of one known distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.depth.integration import STEEPEST, checked_field, depth_from_steps
from harmonicface.surfaces.perspective import checked_intrinsics, rays

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Steps:
    """What normals say of the change from pixel to pixel: of depth in pixels, or of the logarithm of the distance.

    Parameters
    ----------
    right, down
        (h, w - 1) and (h - 1, w), to the neighbour on the right and to the one below.
    right_weights, down_weights
        The same shapes; 0 where there is no pair.
    scale
        The same shapes: pixels on the surface, seen from its front, that one unit of the change amounts to.
    mask
        (h, w) booleans.
    """

    right: Floats
    down: Floats
    right_weights: Floats
    down_weights: Floats
    scale: tuple[Floats, Floats]
    mask: Mask


def integrate_perspective(
    normals: ArrayLike,
    intrinsics: ArrayLike,
    mask: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    *,
    distance: float = 1.0,
    steepest: float = STEEPEST,
) -> NDArray[np.float64]:
    r"""Return the depth before a pinhole camera whose steps agree best with the normals.

    A pixel sees the point `Z r`, with its ray r scaled to z = -1 and Z the distance along the camera's axis. Between
    neighbours i, j the chord is at a right angle to the sum of their normals, :math:`(Z_j r_j - Z_i r_i) \cdot (n_i +
    n_j) = 0`, which is exact for planes and spheres, so that

    .. math:: \log Z_j - \log Z_i = \log \frac{(n_i + n_j) \cdot r_i}{(n_i + n_j) \cdot r_j}

    and :math:`\log Z` solves the same weighted Poisson equation as the depth of `integrate_normals` (the logarithm:
    Tankus, Sochen & Yeshurun, Shape-from-shading under perspective projection, 2005). Normals leave one factor open:
    the camera's focal lengths make angles known, and one distance makes lengths known.

    Parameters
    ----------
    normals
        (h, w, 3) unit vectors inside the mask, in the camera's axes: x right, y up, z toward the camera.
    intrinsics
        (fx, fy, cx, cy) in pixels, the centre of the first one at (0.5, 0.5), see `PerspectiveView`.
    mask
        (h, w) booleans; by default every pixel whose normal is not the zero vector.
    weights
        (h, w) trust in each pixel's normal, above 0 in the mask; all alike by default.
    distance
        World units from the pinhole to what is seen, along its axis: the geometric mean over each part of the mask.
    steepest
        Degrees between normal and line of sight, above 0 and below 90, to which steeper normals are turned back.

    Returns
    -------
    array
        (h, w) float64 z in the camera's axes, below 0: minus the distance; NaN outside the mask. This is what
        `surface_from_depth(..., intrinsics=...)` takes.

    Raises
    ------
    HarmonicFaceError
        Another shape, vectors that are not of unit length, an empty mask, weights that are not above 0, intrinsics of
        no camera, a number out of range, a normal that points straight away from the camera.

    Examples
    --------
    >>> wall = np.tile([0.0, 0.0, 1.0], (4, 5, 1))
    >>> integrate_perspective(wall, (100, 100, 2.5, 2), distance=2.0)[0].round(9)
    array([-2., -2., -2., -2., -2.])
    """
    found = steps_between(normals, mask, weights, intrinsics=intrinsics, steepest=steepest)
    logarithm = depth_from_steps(found.right, found.down, found.right_weights, found.down_weights, found.mask)
    return depth_of_logarithm(logarithm, distance)


def depth_of_logarithm(logarithm: Floats, distance: float) -> NDArray[np.float64]:
    """Return z below 0 from logarithms of distances whose mean is that of `distance`."""
    return -_validate.positive(distance, "distance") * np.exp(logarithm)


def steps_between(
    normals: ArrayLike,
    mask: ArrayLike | None,
    weights: ArrayLike | None,
    *,
    intrinsics: ArrayLike | None = None,
    steepest: float = STEEPEST,
) -> Steps:
    """Return the steps between neighbouring pixels, of parallel rays or those of a pinhole (see `Steps`).

    Raises
    ------
    HarmonicFaceError
        What `integrate_perspective` refuses.
    """
    field, inside = checked_field(normals, mask)
    shape = inside.shape[0], inside.shape[1]
    trust = _checked_weights(weights, inside)
    towards = np.broadcast_to([0.0, 0.0, 1.0], (*shape, 3))
    focal = None
    if intrinsics is not None:
        numbers = checked_intrinsics(np.asarray(intrinsics).tolist(), shape)
        towards, focal = rays(numbers, shape), numbers[:2]
    upright = _upright(np.where(inside[..., None], field, towards).astype(np.float64), inside, towards, steepest)
    steps, scales, pairs = [], [], []
    for axis in (1, 0):
        first, second = _neighbours(upright, axis)
        total = first + second
        if focal is None:
            sideways = total[..., 0] if axis == 1 else -total[..., 1]  # rows run downward
            steps.append(-sideways / total[..., 2])
            scales.append(total[..., 2] / np.linalg.norm(total, axis=2))
        else:
            ray, other = _neighbours(towards, axis)
            ahead, behind = (np.einsum("hwk,hwk->hw", total, each) for each in (ray, other))
            steps.append(np.log(ahead / behind))
            length = np.linalg.norm(total, axis=2)
            scales.append((ahead + behind) / (2 * length) * focal[1 - axis])
        one, two = _neighbours(trust, axis)
        pairs.append(np.divide(2 * one * two, one + two, out=np.zeros_like(one), where=(one > 0) & (two > 0)))
    return Steps(steps[0], steps[1], pairs[0], pairs[1], (scales[0], scales[1]), inside)


def _neighbours(field: Floats, axis: int) -> tuple[Floats, Floats]:
    """Return each pixel but the last along an axis, and the one after it."""
    return (field[:, :-1], field[:, 1:]) if axis == 1 else (field[:-1], field[1:])


def _upright(normals: Floats, inside: Mask, towards: Floats, steepest: float) -> Floats:
    """Turn normals that face away from their line of sight by more than the steepest angle back to it, in place."""
    angle = _validate.positive(steepest, "steepest")
    if angle >= 90:
        raise HarmonicFaceError(f"steepest: expected degrees below 90, got {steepest:g}")
    sight = towards / np.linalg.norm(towards, axis=2, keepdims=True)
    facing = np.einsum("hwk,hwk->hw", normals, sight)
    grazing = inside & (facing < np.cos(np.radians(angle)))
    across = normals[grazing] - facing[grazing, None] * sight[grazing]
    length = np.linalg.norm(across, axis=1, keepdims=True)
    if (length < 1e-6).any():
        raise HarmonicFaceError("normals: expected some slope, got a normal that points straight away from the camera")
    normals[grazing] = np.cos(np.radians(angle)) * sight[grazing] + np.sin(np.radians(angle)) * across / length
    return normals


def _checked_weights(weights: ArrayLike | None, inside: Mask) -> Floats:
    """Return weights, 0 outside the mask."""
    if weights is None:
        return inside.astype(np.float64)
    trust = _validate.floats(weights, "weights")
    if trust.shape != inside.shape:
        raise HarmonicFaceError(f"weights: expected shape {inside.shape}, got {_validate.describe(trust)}")
    if not (_validate.finite(trust[inside], "weights") > 0).all():
        raise HarmonicFaceError(f"weights: expected numbers above 0 in the mask, got {trust[inside].min():.4g}")
    shares = trust.astype(np.float64) / trust[inside].max()  # products of very small or large numbers are none
    return np.where(inside, np.maximum(shares, 1e-150), 0.0)
