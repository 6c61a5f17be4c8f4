"""Determined modes: the combinations of images that a photograph tells from its own noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import f as f_distribution

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

Array = NDArray[np.float64]

ROUNDINGS = 8  # operations behind each number of an image
LEVEL = 0.05  # of the F-test: how often noise alone passes for a mode


@dataclass(frozen=True, eq=False)
class DeterminedModes:
    """The least squares fit of images to a photograph, without the modes that its noise would decide.

    Parameters
    ----------
    coefficients
        (k,) of the images, by the modes that are kept.
    std
        (k,) their standard deviation.
    fit
        (p,) the picture that they give.
    modes
        (r, k) orthonormal combinations of the images, strongest first.
    statistics
        (r,) F of each mode: its squared coefficient over that coefficient's variance.
    kept
        (r,) booleans: which modes the photograph determines.
    noise
        Standard deviation of a pixel, as given or as the full fit leaves it.
    """

    coefficients: Array
    std: Array
    fit: Array
    modes: Array
    statistics: Array
    kept: NDArray[np.bool_]
    noise: float


def determined_modes(
    photo: ArrayLike, images: ArrayLike, *, noise: float | None = None, level: float = LEVEL
) -> DeterminedModes:
    r"""Fit images to a photograph, and drop the modes whose coefficients it cannot determine.

    With the images B^T = V s U^T, the coefficients c_j = v_j . y of the modes are independent, each of variance
    \sigma^2. A mode is kept if

    .. math:: F_j = \frac{c_j^2}{\sigma^2} > F_{1, p - r}(1 - \alpha), \qquad
              \sigma^2 = \frac{\|y\|^2 - \sum_j c_j^2}{p - r}

    as in the F-test of a term of a linear model (of a known \sigma, with infinitely many degrees of freedom). A mode
    that is dropped costs the picture its c_j^2, one that is kept costs \sigma^2; the light along it errs by
    \sigma / s_j, which is what a cut spares most. What no image explains, shadows and gloss, counts as noise.

    Parameters
    ----------
    photo
        (p,) pixels.
    images
        (k, p) images at the same pixels, not all 0.
    noise
        Standard deviation of a pixel, above 0, in the photograph's units; by default what the full fit leaves.
    level
        \alpha: how often noise passes for a mode, above 0 and below 1.

    Raises
    ------
    HarmonicFaceError
        Shapes that do not fit, NaN, images that are all 0, a noise or level outside its range, no more pixels than
        modes and no `noise`.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> images = np.eye(3, 500) * 10
    >>> found = determined_modes([5.0, 4.0, 0.05] @ images + rng.normal(size=500), images)
    >>> found.kept, found.coefficients[2].item()
    (array([ True,  True, False]), 0.0)
    """
    basis = _validate.finite(images, "images").astype(np.float64)
    if basis.ndim != 2 or basis.size == 0:
        raise HarmonicFaceError(f"images: expected shape (k, p), got {_validate.describe(basis)}")
    pixels = _validate.finite(photo, "photo").astype(np.float64)
    if pixels.shape != basis.shape[1:]:
        raise HarmonicFaceError(f"photo: expected {basis.shape[1]} pixels, got {_validate.describe(pixels)}")
    if not 0 < _validate.fraction(level, "level") < 1:
        raise HarmonicFaceError(f"level: expected a number above 0 and below 1, got {level}")
    if not basis.any():
        raise HarmonicFaceError(f"images: expected one with something in it, got {len(basis)} of zeros")
    turned, strengths, rows = np.linalg.svd(basis, full_matrices=False)
    eps = max(np.finfo(np.float64).eps, _eps_of(images))
    rank = int((strengths > strengths[0] * ROUNDINGS * eps * np.sqrt(len(basis))).sum())
    turned, strengths, rows = turned[:, :rank], strengths[:rank], rows[:rank]
    amounts = rows @ pixels
    freedom, spread = _noise(pixels - amounts @ rows, rank, noise)
    squares = np.full(rank, spread**2)
    statistics = np.divide(amounts**2, squares, out=np.full(rank, np.inf), where=squares > 0)
    kept = statistics > f_distribution.isf(level, 1, freedom)
    inverse = (turned / strengths)[:, kept]
    return DeterminedModes(
        coefficients=inverse @ amounts[kept],
        std=spread * np.linalg.norm(inverse, axis=1),
        fit=amounts[kept] @ rows[kept],
        modes=np.ascontiguousarray(turned.T),
        statistics=statistics,
        kept=kept,
        noise=spread,
    )


def undetermined(images: Array, inverse: Array, photo: Array, noise: float, freedom: float) -> Array:
    """Return the modes, orthonormal columns (k, d), that some linear estimate of k coefficients cannot tell from noise.

    Parameters
    ----------
    images
        (n, k) images as columns.
    inverse
        (k, n) which takes a photograph to the coefficients.
    photo
        (n,) the photograph.
    noise
        Standard deviation of each of its numbers.
    freedom
        Degrees of freedom by which that is known.
    """
    turned = np.linalg.svd(images)[2]
    weights = turned @ inverse
    least = f_distribution.isf(LEVEL, 1, freedom) * noise**2 * np.einsum("ij,ij->i", weights, weights)
    return np.asarray(turned[(weights @ photo) ** 2 < least].T)


def _eps_of(images: ArrayLike) -> float:
    """Return the rounding of what came: images in float32 are not known better."""
    given = np.asarray(images)
    return float(np.finfo(given.dtype).eps) if given.dtype.kind == "f" else 0.0


def _noise(residual: Array, rank: int, noise: float | None) -> tuple[float, float]:
    """Return degrees of freedom and standard deviation of a pixel."""
    if noise is not None:
        return np.inf, _validate.positive(noise, "noise")
    freedom = len(residual) - rank
    if freedom < 1:
        raise HarmonicFaceError(
            f"noise: expected a number, for {len(residual)} pixels tell nothing beside {rank} modes; got None"
        )
    return freedom, float(np.sqrt(residual @ residual / freedom))
