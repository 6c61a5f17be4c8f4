"""The conventions of pyshtools: its array `cilm`, four normalizations and two phases."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._checked import coefficients as checked
from harmonicface.harmonics._checked import nothing_outside
from harmonicface.harmonics.indexing import degrees, modes

Normalization = Literal["4pi", "ortho", "schmidt", "unnorm"]
NORMALIZATIONS = ("4pi", "ortho", "schmidt", "unnorm")
LARGEST_UNNORMALIZED = 80  # (2l)! leaves the doubles beyond


def to_pyshtools(coefficients: ArrayLike, normalization: Normalization = "4pi", csphase: int = 1) -> Floats:
    r"""Return the array `cilm` of pyshtools, from real coefficients.

    .. math:: f = \sum_{l, m \ge 0} \bar P_{lm}(\cos\theta) (c_{0lm} \cos m\phi + c_{1lm} \sin m\phi)

    with a mean square of the harmonics over the sphere of 1 ("4pi"), 1 / (4 pi) ("ortho"), 1 / (2l + 1) ("schmidt")
    or (l + m)! / ((2 - delta_m0) (2l + 1) (l - m)!) ("unnorm"): pyshtools' documentation of real harmonics.

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) real coefficients; of order 80 at most for "unnorm".
    normalization
        "4pi", "ortho", "schmidt" or "unnorm".
    csphase
        1 for harmonics without the Condon-Shortley phase, -1 with it.

    Returns
    -------
    array
        (2, order + 1, order + 1, ...): cosines and sines, degree l, mode m; zero where there is no harmonic.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity, another normalization or phase, a result that
        overflows.

    Examples
    --------
    >>> to_pyshtools([0.0, 1.0, 2.0, 3.0], "ortho")[:, 1]
    array([[2., 3.],
           [0., 1.]])
    """
    given, order = checked(coefficients)
    scale = _pyshtools_scale(order, normalization, csphase)
    result = np.zeros((2, order + 1, order + 1, *given.shape[1:]), given.dtype)
    result[_cilm(order)] = _scaled(given, 1 / scale)
    return result


def from_pyshtools(cilm: ArrayLike, normalization: Normalization = "4pi", csphase: int = 1) -> Floats:
    """Return real coefficients from the array `cilm` of pyshtools, the inverse of `to_pyshtools`.

    Parameters
    ----------
    cilm
        (2, order + 1, order + 1, ...): cosines and sines, degree l, mode m.
    normalization, csphase
        As in `to_pyshtools`.

    Returns
    -------
    array
        ((order + 1)^2, ...) real coefficients.

    Raises
    ------
    HarmonicFaceError
        Another shape than (2, order + 1, order + 1, ...), NaN or infinity, numbers where there is no harmonic,
        another normalization or phase, a result that overflows.

    Examples
    --------
    >>> from_pyshtools(to_pyshtools([0.0, 1.0, 2.0, 3.0])).round(6)
    array([0., 1., 2., 3.])
    """
    given = _validate.finite(cilm, "cilm")
    if given.ndim < 3 or given.shape[0] != 2 or given.shape[1] != given.shape[2] or given.shape[1] == 0:
        raise HarmonicFaceError(f"cilm: expected shape (2, order + 1, order + 1, ...), got {given.shape}")
    order = given.shape[1] - 1
    scale = _pyshtools_scale(order, normalization, csphase)
    places = _cilm(order)
    nothing_outside(given, places[0], places[1:], "m > l, and for the sine of m = 0")
    return _scaled(given[places], scale)


def _scaled(given: Floats, scale: NDArray[np.float64]) -> Floats:
    """Return numbers times one factor a harmonic, of their type, refused where they leave it."""
    with np.errstate(over="ignore"):
        result = (given.T * scale).T.astype(given.dtype, copy=False)
    if not np.isfinite(result).all():
        raise HarmonicFaceError(f"coefficients: expected ones that fit {given.dtype} when scaled, got an overflow")
    return np.asarray(result)


def _cilm(order: int) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return where each stored harmonic is in pyshtools' array."""
    mode = modes(order)
    return (mode < 0).astype(np.intp), degrees(order), np.abs(mode)


def _pyshtools_scale(order: int, normalization: Normalization, csphase: int) -> NDArray[np.float64]:
    """Return pyshtools' harmonics over ours, inverted: our coefficient over theirs, one number a harmonic."""
    if normalization not in NORMALIZATIONS:
        raise HarmonicFaceError(f"normalization: expected one of {', '.join(NORMALIZATIONS)}, got {normalization!r}")
    if csphase not in (1, -1):
        raise HarmonicFaceError(f"csphase: expected 1 or -1, got {csphase!r}")
    degree, mode = degrees(order), np.abs(modes(order))
    squared = np.full(len(degree), 4 * math.pi)  # mean square of theirs over mean square of ours
    if normalization == "ortho":
        squared /= 4 * math.pi
    elif normalization == "schmidt":
        squared /= 2 * degree + 1
    elif normalization == "unnorm":
        if order > LARGEST_UNNORMALIZED:
            raise HarmonicFaceError(
                f"normalization: expected order {LARGEST_UNNORMALIZED} at most for 'unnorm', got {order}"
            )
        ratios = [float(math.perm(l + m, 2 * m)) for l, m in zip(degree.tolist(), mode.tolist(), strict=True)]  # noqa: E741
        squared *= np.array(ratios) / ((2 * degree + 1) * np.where(mode, 2, 1))
    signs = np.where((csphase == -1) & (mode % 2 == 1), -1.0, 1.0)
    return np.asarray(np.sqrt(squared) * signs)
