"""Material from its reflection of a known light: each degree of it by least squares over all modes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import degrees, order_of
from harmonicface.reflectance._arguments import at_least_zero, numbers
from harmonicface.reflectance.spectra import degree_norms

NOTHING = 1e-12  # of the strongest degree of the light: what rounding leaves of an exact zero


@dataclass(frozen=True, eq=False)
class ReflectanceEstimate:
    """A material's filter, degree by degree, as a reflection under known light tells it.

    Attributes
    ----------
    filter
        (order + 1, ...) f_l = Lambda_l rho_l; masked at the degrees that the light does not hold.
    std
        (order + 1,) standard deviation of each; infinite where masked.
    noise
        Standard deviation of each coefficient of the reflection: what was given, or what the residual shows.
    residual
        Root mean square of what the estimate leaves of the reflection.
    """

    filter: np.ma.MaskedArray[Any, np.dtype[Any]]
    std: NDArray[np.float64]
    noise: float
    residual: float

    @property
    def coefficients(self) -> np.ma.MaskedArray[Any, np.dtype[Any]]:
        """(order + 1, ...) the material's own rho_l = f_l / Lambda_l, or rho_lpq; masked like the filter."""
        norms = degree_norms(len(self.std) - 1)
        result: np.ma.MaskedArray[Any, np.dtype[Any]] = self.filter / norms.reshape(-1, *[1] * (self.filter.ndim - 1))
        return result

    @property
    def lost(self) -> tuple[int, ...]:
        """The degrees that the light does not hold, and that the reflection thus cannot tell."""
        return tuple(int(degree) for degree in np.flatnonzero(np.isinf(self.std)))


def estimate_reflectance(reflected: ArrayLike, light: ArrayLike, noise: float | None = None) -> ReflectanceEstimate:
    r"""Estimate a material's filter from its reflection under known light.

    .. math:: f_l = \Lambda_l \hat\rho_l = \frac{\sum_m L_{lm}^* B_{lm}}{\sum_m |L_{lm}|^2}, \quad
              \text{std} = \frac{\text{noise}}{\sqrt{\sum_m |L_{lm}|^2}}

    Ramamoorthi & Hanrahan 2004, equation 58, over all m by least squares: a small L_lm spoils nothing, the others
    tell. The same holds for B_lmpq = Lambda_l L_lm rho_lpq, each (p, q) by itself.

    Parameters
    ----------
    reflected
        ((order + 1)^2, ...) coefficients B_lm about the reflection vector, or B_lmpq of complex harmonics with p and q
        in the further axes.
    light
        ((order + 1)^2,) coefficients L_lm in the same harmonics, real or complex.
    noise
        Standard deviation of each B_lm; taken from the residual if not given.

    Returns
    -------
    ReflectanceEstimate

    Raises
    ------
    HarmonicFaceError
        Light that is nothing, coefficients that do not fit each other, NaN or infinity, too few coefficients to see
        the noise in.

    Examples
    --------
    >>> from harmonicface.reflectance.spectra import apply_filter
    >>> light = np.array([1.0, 0.2, 0.0, 0.3, 0, 0, 0, 0, 0])
    >>> estimate = estimate_reflectance(apply_filter([3.0, 2.0, 1.0], light), light)
    >>> print(estimate.filter, estimate.lost)
    [3.0 2.0 --] (2,)
    """
    known, seen = numbers(light, "light"), numbers(reflected, "reflected")
    if known.ndim != 1 or seen.ndim == 0 or len(seen) != len(known):
        raise HarmonicFaceError(
            f"reflected: expected as many coefficients as light has, got {_validate.describe(seen)} "
            f"and {_validate.describe(known)}"
        )
    order = order_of(len(known))
    starts = np.arange(order + 1) ** 2
    powers = np.add.reduceat(np.abs(known).astype(np.float64) ** 2, starts)
    told = powers > NOTHING**2 * powers.max()
    if not told.any():
        raise HarmonicFaceError("light: expected a coefficient that is not 0, got none")
    flat = seen.reshape(len(seen), -1)
    products = np.add.reduceat(known.conj()[:, None] * flat, starts, axis=0)
    values = np.zeros_like(products)
    np.divide(products, powers[:, None], out=values, where=told[:, None])
    rest = flat - known[:, None] * values[degrees(order)]
    squares = float((np.abs(rest) ** 2).sum())
    freedom = (len(known) - int(told.sum())) * flat.shape[1]
    if noise is None and not freedom:
        raise HarmonicFaceError("noise: expected a number, since these coefficients leave no residual to see it in")
    level = math.sqrt(squares / freedom) if noise is None else at_least_zero(noise, "noise")
    std = np.full(order + 1, np.inf)
    np.divide(level, np.sqrt(powers), out=std, where=told)
    shape = (order + 1, *seen.shape[1:])
    hidden = np.broadcast_to(~told.reshape(-1, *[1] * (len(shape) - 1)), shape)
    estimate = np.ma.MaskedArray(values.reshape(shape), hidden)
    return ReflectanceEstimate(estimate, std, level, math.sqrt(squares / flat.size))
