"""Discontinuities: integration of normals that lets depth jump where one thing stands before another."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import expit

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.stereo.depth.integration import STEEPEST, depth_from_steps
from harmonicface.stereo.depth.perspective_integration import depth_of_logarithm, steps_between

SHARPNESS = 2.0  # a pixel of step more on one side than on the other: 0.88 against 0.12
ROUNDS = 100
SETTLED = 1e-4  # of the cost, from round to round
LEAST = 1e-6  # of an ordinary weight: what is cut stays determined, though by next to nothing

Mask = NDArray[np.bool_]


def integrate_bilaterally(
    normals: ArrayLike,
    mask: ArrayLike | None = None,
    pixel_size: float = 1.0,
    weights: ArrayLike | None = None,
    *,
    intrinsics: ArrayLike | None = None,
    distance: float = 1.0,
    sharpness: float = SHARPNESS,
    steepest: float = STEEPEST,
) -> NDArray[np.float64]:
    r"""Return the depth that follows the normals on at least one side of each pixel, and may jump on the other.

    A surface is smooth on one side of a pixel wherever it is smooth at all, also at an occluding edge (Cao, Santo,
    Shi, Okura & Matsushita, Bilateral Normal Integration, 2022). With the misfits :math:`r = n_z (z_j - z_i - s_{ij})`
    of the steps to the left and to the right of a pixel, in pixels, each side is trusted by how much worse the other
    one is,

    .. math:: w^+ = \sigma(k (r_-^2 - r_+^2)), \quad w^- = 1 - w^+

    and likewise above and below; a step counts by the product of what its two pixels make of it, and where one of
    them has no other side, by what the other one does. Depth and trust alternate from that of `integrate_normals`
    until the cost has settled. The steps are the same as there (from the sum of two normals: exact for planes and
    spheres), or with `intrinsics` those of `integrate_perspective`.

    Parameters
    ----------
    normals, mask, pixel_size, weights, steepest
        See `integrate_normals`.
    intrinsics, distance
        Of a pinhole camera, see `integrate_perspective`; the pixel size is then of no account.
    sharpness
        k above, per square pixel, above 0: the larger, the smaller the steps that count as jumps.

    Returns
    -------
    array
        (h, w) float64, NaN outside the mask. How far a jump goes is known only as far as the surface is whole around
        its ends: of a thing that floats before another, normals do not tell how far.

    Raises
    ------
    HarmonicFaceError
        What `integrate_normals` and `integrate_perspective` refuse; a sharpness that is not above 0.

    Examples
    --------
    >>> flat = np.tile([0.0, 0.0, 1.0], (4, 5, 1))
    >>> float(abs(integrate_bilaterally(flat)).max().round(9))
    0.0
    """
    steepness = _validate.positive(sharpness, "sharpness")
    found = steps_between(normals, mask, weights, intrinsics=intrinsics, steepest=steepest)
    size = _validate.positive(pixel_size, "pixel_size")
    right, down = found.right_weights.copy(), found.down_weights.copy()
    depth = depth_from_steps(found.right, found.down, right, down, found.mask)
    before = np.inf
    for _ in range(ROUNDS):
        across = found.scale[0] * (np.diff(depth, axis=1) - found.right)
        along = found.scale[1] * (np.diff(depth, axis=0) - found.down)
        right = found.right_weights * _trust(across, steepness)
        down = found.down_weights * _trust(along.T, steepness).T
        cost = float(np.nansum(right * across**2) + np.nansum(down * along**2))
        if abs(before - cost) <= SETTLED * before < np.inf:
            break
        before = cost
        depth = depth_from_steps(found.right, found.down, right, down, found.mask)
    return size * depth if intrinsics is None else depth_of_logarithm(depth, distance)


def _trust(misfits: Floats, sharpness: float) -> Floats:
    """Return the weights of steps along rows, (h, w - 1), from their misfits, NaN for steps that are none."""
    there = np.isfinite(misfits)
    squares = np.where(there, misfits, 0.0) ** 2
    empty = np.zeros((len(squares), 1))
    left = np.concatenate([empty, squares], axis=1)  # of each pixel
    right = np.concatenate([squares, empty], axis=1)
    both = np.zeros(left.shape, bool)
    both[:, 1:-1] = there[:, :-1] & there[:, 1:]
    to_right = np.where(both, 2 * expit(sharpness * (left - right)), 1.0)
    to_left = np.where(both, 2 - to_right, 1.0)
    return np.where(there, np.maximum(to_right[:, :-1] * to_left[:, 1:], LEAST), 0.0)
