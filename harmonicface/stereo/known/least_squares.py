"""The 3x3 normal equations of photometric stereo, solved for all pixels at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface._validate import Floats

_ROWS, _COLUMNS = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 1, 2, 2])  # upper triangle of a symmetric matrix
UNKNOWNS = 3  # of a pixel: albedo times normal
POOLED = 4  # photographs: what the noise of all pixels counts for against a pixel's own
_BLOCK = 1 << 11  # pixels at a time: read once from memory, and twice more from the processor's cache
_SINGULAR = 1e-12  # of the determinant over the cube of the trace: beyond what float64 resolves


def plain_least_squares(observations: Floats, lights: Floats) -> Floats:
    """Return albedo times normal of each pixel by least squares over all its observations (Woodham 1980).

    A product with the pseudo-inverse of the lights, in the observations' own precision: a single pass over them.

    Parameters
    ----------
    observations
        (n, p) intensities.
    lights
        (n, 3) directions to the lights, times their brightness, spanning space.

    Returns
    -------
    array
        (p, 3) of the observations' type, a view of contiguous components.

    Examples
    --------
    >>> plain_least_squares(np.array([[0.1], [0.2], [0.4]]), np.eye(3))
    array([[0.1, 0.2, 0.4]])
    """
    inverse = np.linalg.pinv(lights).astype(observations.dtype)
    scaled = np.empty((3, observations.shape[1]), observations.dtype)
    for start in range(0, observations.shape[1], _BLOCK):
        block = slice(start, start + _BLOCK)
        for row, component in zip(inverse, scaled, strict=True):
            np.matmul(row, observations[:, block], out=component[block])
    return scaled.T


def scaled_normals(
    observations: Floats, lights: Floats, weights: ArrayLike | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    r"""Return albedo times normal of each pixel by weighted least squares, and how much noise its lights amplify.

    Each pixel's b minimizes `sum_i w_i (I_i - b . l_i)**2`, so `G b = sum_i w_i I_i l_i` with the 3x3 matrix
    `G = sum_i w_i l_i l_i'`. Noise of standard deviation s in the images leaves an error of root mean square
    `s * sqrt(trace(inverse(G)))` in b (weights 0 and 1); the gain is that factor for lights of brightness 1.

    Parameters
    ----------
    observations
        (n, p) intensities.
    lights
        (n, 3) directions to the lights, times their brightness, none of them zero.
    weights
        (n, p) weights of at least 0, or booleans; all 1 by default.

    Returns
    -------
    scaled
        (p, 3) albedo times normal; 0 where the matrix is singular.
    gain
        (p,) the noise's amplification; infinite where the matrix is singular.

    Examples
    --------
    >>> scaled, gain = scaled_normals(np.array([[0.1], [0.2], [0.4]]), np.eye(3))
    >>> scaled, gain.round(3)
    (array([[0.1, 0.2, 0.4]]), array([1.732]))
    """
    observations = np.asarray(observations, np.float64)
    weights = np.ones_like(observations) if weights is None else np.asarray(weights, np.float64)
    unit = 2.0 ** np.floor(np.log2(np.abs(lights).max() or 1.0))  # sixth powers of it stay numbers, and no bit changes
    lights = lights / unit
    products = lights[:, _ROWS] * lights[:, _COLUMNS]
    xx, xy, xz, yy, yz, zz = products.T @ weights
    right = lights.T @ (weights * observations)
    cofactors = np.stack([yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy])
    determinant = xx * cofactors[0] + xy * cofactors[1] + xz * cofactors[2]
    diagonal = np.stack([cofactors[0], xx * zz - xz * xz, xx * yy - xy * xy])
    corner = xy * xz - xx * yz
    regular = determinant > _SINGULAR * (xx + yy + zz) ** 3
    inverse = np.divide(1.0, determinant, out=np.zeros_like(determinant), where=regular)
    scaled = np.stack(
        [
            diagonal[0] * right[0] + cofactors[1] * right[1] + cofactors[2] * right[2],
            cofactors[1] * right[0] + diagonal[1] * right[1] + corner * right[2],
            cofactors[2] * right[0] + corner * right[1] + diagonal[2] * right[2],
        ],
        axis=1,
    )
    scaled *= inverse[:, None] / unit
    brightness = np.sqrt(products[:, [0, 3, 5]].sum() / len(lights))
    gain = np.where(regular, np.sqrt(np.maximum(diagonal.sum(axis=0) * inverse, 0.0)) * brightness, np.inf)
    return scaled, gain


def noise_of(residual: Floats, used: NDArray[np.integer[Any]]) -> NDArray[np.float64]:
    """Return the standard deviation of each pixel's noise, from what is left of its photographs after three unknowns.

    One photograph more than unknowns says next to nothing of one pixel's noise, so the median of all pixels counts
    as four photographs more; of a pixel of three photographs it is all there is.

    Parameters
    ----------
    residual
        (p,) root mean square over the photographs that were used.
    used
        (p,) how many were.

    Returns
    -------
    array
        (p,); infinite where no pixel has more than three photographs.

    Examples
    --------
    >>> noise_of(np.array([0.1, 0.1, 0.0]), np.array([12, 12, 3])).round(3)
    array([0.117, 0.117, 0.12 ])
    """
    freedom = np.maximum(used - UNKNOWNS, 0)
    some = freedom > 0
    if not some.any():
        return np.full(len(used), np.inf)
    squares = np.asarray(residual, np.float64) ** 2 * used
    free = freedom[some]
    usual = float(np.median(squares[some] / free / (1 - 2 / (9 * free)) ** 3))  # the median of chi^2 is below its mean
    return np.asarray(np.sqrt((squares * some + POOLED * usual) / (freedom + POOLED)))
