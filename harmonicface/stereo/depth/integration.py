"""Integration: normals -> the depth whose slopes they are, by a weighted Poisson equation on the mask."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import dctn, idctn
from scipy.ndimage import label
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import LinearOperator, cg, spsolve

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

STEEPEST = 80.0  # degrees: a surface steeper than this drops by more than 5 pixels a pixel, and its normal is a guess
TOLERANCE = 1e-11  # of the residual against the right side
ITERATIONS = 200  # more than any mask needs; weights over many decades go to the direct solver

Mask = NDArray[np.bool_]


def integrate_normals(
    normals: ArrayLike,
    mask: ArrayLike | None = None,
    pixel_size: float = 1.0,
    weights: ArrayLike | None = None,
    *,
    steepest: float = STEEPEST,
) -> NDArray[np.float64]:
    r"""Return the depth whose steps from pixel to pixel agree best with the normals.

    The depth minimizes, over all pairs of neighbouring pixels i, j of the mask, j to the right of i or above it,

    .. math:: \sum_{ij} w_{ij} (z_j - z_i - s_{ij})^2, \quad
              s_{ij} = -d \frac{(n_i + n_j) \cdot e}{(n_i + n_j) \cdot e_z}

    with e the unit vector from i to j and d the pixel size. Its normal equations are a Poisson equation with the
    natural, free boundary (Horn & Brooks 1986; Quéau, Durou & Aujol, Normal integration: a survey, 2018). The step
    from the sum of two normals is exact for planes and spheres, and of second order otherwise; where one of the two
    is grazing the other one holds it.

    Parameters
    ----------
    normals
        (h, w, 3) unit vectors inside the mask: x right, y up, z toward the camera.
    mask
        (h, w) booleans; by default every pixel whose normal is not the zero vector.
    pixel_size
        World units a pixel.
    weights
        (h, w) trust in each pixel's normal, above 0 in the mask, as an inverse variance: a pair has the harmonic mean
        of its two. All alike by default.
    steepest
        Degrees from the camera's axis, above 0 and below 90. A normal beyond is turned back to this angle about its
        own azimuth: slopes are bounded by tan(steepest) pixels a pixel.

    Returns
    -------
    array
        (h, w) float64 heights in world units, larger nearer the camera, NaN outside the mask. Normals do not tell
        an absolute distance, nor how parts of the mask that do not touch lie to each other: each part has mean 0.

    Raises
    ------
    HarmonicFaceError
        Another shape, vectors that are not of unit length, an empty mask, weights that are not above 0, a number out
        of range, a normal that points straight away from the camera.

    Examples
    --------
    >>> tilted = np.tile([-0.6, 0.0, 0.8], (2, 3, 1))  # rises to the right by 3 in 4
    >>> integrate_normals(tilted)[0].round(6)
    array([-0.75,  0.  ,  0.75])
    """
    field, inside = checked_field(normals, mask)
    step = _validate.positive(pixel_size, "pixel_size")
    upright = _upright(np.where(inside[..., None], field, 0.0).astype(np.float64), inside, _checked_angle(steepest))
    trust = np.ones(inside.shape) if weights is None else _checked_weights(weights, inside)
    right = _steps(upright[:, :-1], upright[:, 1:], 0)
    down = -_steps(upright[1:], upright[:-1], 1)
    between = _between(trust[:, :-1], trust[:, 1:]), _between(trust[:-1], trust[1:])
    return step * depth_from_steps(right, down, *between, inside)


def checked_field(normals: ArrayLike, mask: ArrayLike | None) -> tuple[Floats, Mask]:
    """Return normals (h, w, 3) of unit length in their mask, and the mask: by default where they are not zero.

    Raises
    ------
    HarmonicFaceError
        Another shape, vectors that are not of unit length, an empty mask.
    """
    field = _validate.floats(normals, "normals")
    if field.ndim != 3 or field.shape[2] != 3 or field.size == 0:
        raise HarmonicFaceError(f"normals: expected an array of shape (h, w, 3), got {_validate.describe(field)}")
    shape = (field.shape[0], field.shape[1])
    inside = _validate.mask(field.any(axis=2) if mask is None else mask, "mask", shape)
    _validate.unit_normals(field[inside], "normals")
    return field, inside


def depth_from_steps(
    right: Floats, down: Floats, right_weights: Floats, down_weights: Floats, mask: Mask
) -> NDArray[np.float64]:
    """Return the depth whose steps from pixel to pixel are nearest to the given ones by weighted least squares.

    The normal equations are solved by conjugate gradients; the cosine transform solves those of the whole rectangle
    at equal weights exactly and is the preconditioner. Weights that differ too much for it go to a direct solver.

    Parameters
    ----------
    right, down
        (h, w - 1) and (h - 1, w) changes of depth to the neighbour on the right, and to the one below.
    right_weights, down_weights
        The same shapes, weights of at least 0: 0 cuts two pixels apart.
    mask
        (h, w) booleans. Steps to pixels outside count for nothing.

    Returns
    -------
    array
        (h, w) float64, NaN outside the mask, mean 0 on each connected part.

    Examples
    --------
    >>> everywhere, equal = np.ones((1, 3), bool), np.ones((1, 2))
    >>> depth_from_steps(np.array([[1.0, 2.0]]), np.zeros((0, 3)), equal, np.zeros((0, 3)), everywhere).round(6)
    array([[-1.333333, -0.333333,  1.666667]])
    """
    right_weights = np.where(mask[:, :-1] & mask[:, 1:], right_weights, 0.0)
    down_weights = np.where(mask[:-1] & mask[1:], down_weights, 0.0)
    scale = max(right_weights.max(initial=0.0), down_weights.max(initial=0.0)) or 1.0
    right_weights, down_weights = right_weights / scale, down_weights / scale
    target = _divergence(right_weights * right, down_weights * down)
    size = np.abs(target).max() or 1.0  # squares of tiny steps would vanish
    depth = size * _solve(target / size, right_weights, down_weights)
    parts = _parts(mask, right_weights > 0, down_weights > 0)
    means = np.bincount(parts.ravel(), depth.ravel()) / np.maximum(np.bincount(parts.ravel()), 1)
    return np.where(mask, depth - means[parts], np.nan)


def _solve(target: Floats, right_weights: Floats, down_weights: Floats) -> Floats:
    """Solve the normal equations up to a constant on each part."""
    shape = target.shape

    def steps_back(flat: Floats) -> Floats:
        depth = flat.reshape(shape)
        right, down = right_weights * np.diff(depth, axis=1), down_weights * np.diff(depth, axis=0)
        return _divergence(right, down).ravel()

    waves = [2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in shape]
    spectrum = waves[0][:, None] + waves[1]
    spectrum[0, 0] = np.inf  # of a constant

    def rectangle(flat: Floats) -> Floats:
        return np.asarray(idctn(dctn(flat.reshape(shape), norm="ortho") / spectrum, norm="ortho").ravel())

    size = (target.size, target.size)
    matrix, preconditioner = (LinearOperator(size, function, dtype=float) for function in (steps_back, rectangle))
    depth, failed = cg(matrix, target.ravel(), rtol=TOLERANCE, maxiter=ITERATIONS, M=preconditioner)
    if failed:
        depth = _solve_directly(target, right_weights, down_weights)
    return np.asarray(depth).reshape(shape)


def _solve_directly(target: Floats, right_weights: Floats, down_weights: Floats) -> Floats:
    """Solve the normal equations by elimination; pixels that nothing else holds are held at 0."""
    index = np.arange(target.size).reshape(target.shape)
    first = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    second = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    weights = np.concatenate([right_weights.ravel(), down_weights.ravel()])
    size = (target.size, target.size)
    links = csr_array((weights, (first, second)), size)
    links = links + links.T
    everywhere = np.ones(target.shape, bool)
    parts = _parts(everywhere, right_weights > 0, down_weights > 0).ravel()
    held = np.zeros(target.size)
    held[np.unique(parts, return_index=True)[1]] = 1  # one pixel a part
    matrix = diags_array(links.sum(axis=1) + held) - links
    return np.asarray(spsolve(matrix.tocsc(), target.ravel()))


def _divergence(right: Floats, down: Floats) -> Floats:
    """Return what flows into each pixel minus what leaves it: the transpose of taking differences."""
    total = np.zeros((down.shape[0] + 1, right.shape[1] + 1))
    total[:, 1:] += right
    total[:, :-1] -= right
    total[1:] += down
    total[:-1] -= down
    return total


def _parts(mask: Mask, right: Mask, down: Mask) -> NDArray[np.int32]:
    """Return a number from 1 for each part of a mask that links hold together; 0 outside."""
    height, width = mask.shape
    fine = np.zeros((2 * height - 1, 2 * width - 1), bool)  # pixels, and the links between them
    fine[::2, ::2], fine[::2, 1::2], fine[1::2, ::2] = mask, right, down
    return np.asarray(label(fine)[0][::2, ::2], np.int32)


def _upright(normals: Floats, inside: Mask, steepest: float) -> Floats:
    """Turn normals beyond the steepest angle back to it, about their azimuth; outside the mask face the camera."""
    sideways = np.linalg.norm(normals[..., :2], axis=2)
    grazing = inside & (normals[..., 2] < np.cos(steepest))
    if (sideways[grazing] < 1e-6).any():
        raise HarmonicFaceError("normals: expected some slope, got a normal that points straight away from the camera")
    normals[grazing, :2] *= (np.sin(steepest) / sideways[grazing])[:, None]
    normals[grazing, 2] = np.cos(steepest)
    normals[~inside] = 0, 0, 1
    return normals


def _steps(from_: Floats, to: Floats, axis: int) -> Floats:
    """Return the change of depth in pixels between neighbours, along x (axis 0) or y (axis 1)."""
    total = from_ + to
    return np.asarray(-total[..., axis] / total[..., 2])


def _between(first: Floats, second: Floats) -> Floats:
    """Return the harmonic mean of two weights."""
    return np.asarray(2 * first * second / (first + second))


def _checked_angle(degrees: float) -> float:
    angle = _validate.positive(degrees, "steepest")
    if angle >= 90:
        raise HarmonicFaceError(f"steepest: expected degrees below 90, got {degrees:g}")
    return float(np.radians(angle))


def _checked_weights(weights: ArrayLike, inside: Mask) -> Floats:
    trust = _validate.floats(weights, "weights")
    if trust.shape != inside.shape:
        raise HarmonicFaceError(f"weights: expected shape {inside.shape}, got {_validate.describe(trust)}")
    if not (_validate.finite(trust[inside], "weights") > 0).all():
        raise HarmonicFaceError(f"weights: expected numbers above 0 in the mask, got {trust[inside].min():.4g}")
    shares = trust.astype(np.float64) / trust[inside].max()  # products of very small or large numbers are none
    return np.where(inside, np.maximum(shares, 1e-150), 1.0)
