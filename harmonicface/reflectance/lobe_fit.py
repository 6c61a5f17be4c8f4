"""Shininess or roughness of a material from its reflection of a known light, with how sure that is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq, minimize_scalar

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of
from harmonicface.reflectance._arguments import at_least_zero
from harmonicface.reflectance.microfacet import microfacet_filter, microfacet_sensitivity
from harmonicface.reflectance.phong import phong_filter, phong_sensitivity
from harmonicface.reflectance.spectra import degree_power

SHININESS_RANGE = (0.05, 1e6)
ROUGHNESS_RANGE = (1e-3, 3.0)
STEPS = 121  # of the search over the range, evenly in the logarithm
QUANTILE = 3.841  # of chi squared with one degree of freedom: 95 %

Filter = Callable[[float, int], NDArray[np.float64]]


@dataclass(frozen=True)
class LobeFit:
    """A lobe's width from a reflection under known light.

    Attributes
    ----------
    parameter
        "shininess" or "roughness".
    value, std
        The estimate and its standard deviation, linearized at the estimate; infinite where the estimate is an end of
        the range that was searched, since the reflection asks for a width beyond it.
    low, high
        The interval of 95 %, by the likelihood's own profile: it need not be even about the estimate, and where the
        light tells no bound, or the estimate is an end of the range, it ends at 0 or at infinity. It holds where the
        linearization does not.
    strength
        The lobe's strength, given or estimated.
    noise
        Standard deviation of each coefficient of the reflection, given or taken from the residual.
    gain
        Relative error of the estimate for each part of relative error (noise over signal) in the reflection: the
        condition number of the problem under this light, whatever the noise.
    """

    parameter: str
    value: float
    std: float
    low: float
    high: float
    strength: float
    noise: float
    gain: float

    def __str__(self) -> str:
        return (
            f"{self.parameter} {self.value:.4g} +- {self.std:.2g} (95 %: {self.low:.4g} to {self.high:.4g}), "
            f"noise amplified {self.gain:.3g} times"
        )


def fit_shininess(
    reflected: ArrayLike, light: ArrayLike, noise: float | None = None, strength: float | None = 1.0
) -> LobeFit:
    r"""Estimate the shininess of a Phong material from its reflection of a known light.

    .. math:: \min_{s, k} \sum_{lm} (B_{lm} - k f_l(s) L_{lm})^2, \quad
              \text{std}(s) = \text{noise} \; / \; \| k L_{lm} \, \partial f_l / \partial s \|

    The filter is near exp(-l^2 / 2s): degrees far below sqrt(s) pass unchanged and tell nothing of s, so under soft
    light the problem is ill-conditioned (Ramamoorthi & Hanrahan 2004, section 5.2.5), and the answer says by how much.

    Parameters
    ----------
    reflected
        ((order + 1)^2,) coefficients B_lm about the reflection vector. If they are a fit to n evenly spread samples of
        noise e, each has the noise e sqrt(4 pi / n).
    light
        ((order + 1)^2,) coefficients L_lm of the light, of the same order.
    noise
        Standard deviation of each B_lm; taken from the residual if not given.
    strength
        The known factor k of the lobe; None if it is to be estimated as well, which costs certainty.

    Returns
    -------
    LobeFit
        Its shininess between 0.05 and 1e6; at either end the standard deviation is infinite and the interval open.

    Raises
    ------
    HarmonicFaceError
        Coefficients that do not fit each other, NaN or infinity, a light that tells nothing of the shininess
        (uniform), a reflection of zeros.

    Examples
    --------
    >>> from harmonicface.reflectance.spectra import apply_filter, directional_spectrum
    >>> lamp = directional_spectrum([0, 1, 1], 12)
    >>> round(fit_shininess(apply_filter(phong_filter(50, 12), lamp), lamp).value, 6)
    50.0
    """
    return _fit("shininess", phong_filter, phong_sensitivity, SHININESS_RANGE, reflected, light, noise, strength)


def fit_roughness(
    reflected: ArrayLike, light: ArrayLike, noise: float | None = None, strength: float | None = 1.0
) -> LobeFit:
    r"""Estimate the roughness of a microfacet material from its reflection of a known light.

    As `fit_shininess`, with the filter of `microfacet_filter`, near exp(-(sigma l)^2): degrees far below 1 / sigma tell
    nothing of sigma (Ramamoorthi & Hanrahan 2004, section 5.2.6). The roughness lies between 1e-3 and 3 radians.

    Parameters
    ----------
    reflected, light, noise, strength
        As of `fit_shininess`.

    Raises
    ------
    HarmonicFaceError
        As of `fit_shininess`.

    Examples
    --------
    >>> from harmonicface.reflectance.spectra import apply_filter, directional_spectrum
    >>> lamp = directional_spectrum([0, 1, 1], 12)
    >>> round(fit_roughness(apply_filter(microfacet_filter(0.2, 12), lamp), lamp).value, 6)
    0.2
    """
    return _fit(
        "roughness", microfacet_filter, microfacet_sensitivity, ROUGHNESS_RANGE, reflected, light, noise, strength
    )


class _Misfit:
    """The squared misfit of a lobe of any width, from each degree's least squares (which nothing else enters)."""

    def __init__(self, reflected: Floats, light: Floats, filter_: Filter, strength: float | None) -> None:
        self.order, self.filter, self.given = order_of(len(light)), filter_, strength
        self.power = degree_power(light)
        starts = np.arange(self.order + 1) ** 2
        products = np.add.reduceat(light * reflected, starts)
        self.seen = np.zeros_like(self.power)  # each degree's filter by itself
        np.divide(products, self.power, out=self.seen, where=self.power > 0)
        modes = np.repeat(self.seen, 2 * np.arange(self.order + 1) + 1)
        self.floor = float(((reflected - modes * light) ** 2).sum())  # what no width could explain

    def strength(self, values: NDArray[np.float64]) -> float:
        """Return the strength: the given one or the best one that is not negative."""
        if self.given is not None:
            return self.given
        return max(float(self.power @ (values * self.seen) / (self.power @ values**2)), 0.0)

    def __call__(self, logarithm: float) -> float:
        """Return the squared misfit above the floor, at the logarithm of a width."""
        return self.of(self.filter(math.exp(logarithm), self.order))

    def of(self, values: NDArray[np.float64]) -> float:
        """Return the squared misfit above the floor of given filter values."""
        return float(self.power @ (self.strength(values) * values - self.seen) ** 2)

    def slope(self, width: float, sensitivity: Filter) -> float:
        """Return the norm of the reflection's change with the logarithm of the width, beside any change of strength."""
        values = self.filter(width, self.order)
        change = self.strength(values) * width * sensitivity(width, self.order)
        if self.given is None:
            change = change - values * (self.power @ (values * change)) / (self.power @ values**2)
        return math.sqrt(float(self.power @ change**2))


def _fit(
    parameter: str,
    filter_: Filter,
    sensitivity: Filter,
    bounds: tuple[float, float],
    reflected: ArrayLike,
    light: ArrayLike,
    noise: float | None,
    strength: float | None,
) -> LobeFit:
    """Search the whole range, refine, and measure how sharply the misfit rises about the best."""
    seen, known = _validate.finite(reflected, "reflected"), _validate.finite(light, "light")
    if known.ndim != 1 or seen.shape != known.shape:
        raise HarmonicFaceError(
            f"reflected: expected as many coefficients as light has, got {_validate.describe(seen)} "
            f"and {_validate.describe(known)}"
        )
    given = None if strength is None else _validate.positive(strength, "strength")
    if noise is not None:
        noise = at_least_zero(noise, "noise")
    order_of(len(known))
    size = float(np.linalg.norm(known))
    telling = float(np.linalg.norm(known[1:])) > 1e-12 * size
    if telling and not seen.any():
        raise HarmonicFaceError("reflected: expected light that came back, got only zeros")
    misfit = _Misfit(seen.astype(np.float64), known.astype(np.float64), filter_, given)
    grid, table = _table(filter_, bounds, misfit.order)
    heights = [misfit.of(values) for values in table]
    place = int(np.argmin(heights))
    neighbours = grid[max(place - 1, 0)], grid[min(place + 1, STEPS - 1)]
    best = float(minimize_scalar(misfit, bounds=neighbours, method="bounded", options={"xatol": 1e-11}).x)
    ends = [end for end in (0, STEPS - 1) if heights[end] <= misfit(best)]
    if ends:
        best = float(grid[ends[0]])
    width = math.exp(best)
    slope = misfit.slope(width, sensitivity)
    if not (telling and slope > 1e-12 * size):
        raise HarmonicFaceError(f"light: expected degrees that tell of the {parameter}, got light that tells nothing")
    freedom = len(known) - (1 if given is not None else 2)
    least = misfit(best)
    level = math.sqrt((misfit.floor + least) / freedom) if noise is None else noise
    std = math.inf if ends else width * level / slope
    low, high = _profile(misfit, grid, heights, best, least + QUANTILE * level**2)
    values = filter_(width, misfit.order)
    factor = misfit.strength(values)
    signal = factor * math.sqrt(float(misfit.power @ values**2))
    return LobeFit(parameter, width, std, low, high, factor, level, signal / math.sqrt(len(known)) / slope)


@lru_cache(maxsize=8)
def _table(filter_: Filter, bounds: tuple[float, float], order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the logarithms of the widths that the search looks at first, and their filters."""
    grid = np.linspace(math.log(bounds[0]), math.log(bounds[1]), STEPS)
    return grid, np.stack([filter_(math.exp(point), order) for point in grid])


def _profile(
    misfit: _Misfit, grid: NDArray[np.float64], heights: list[float], best: float, limit: float
) -> tuple[float, float]:
    """Return where the misfit reaches the limit below and above the best; 0 or infinity where it never does."""
    points = list(zip(grid.tolist(), heights, strict=True))
    ends = []
    for outward, nowhere in (
        ([point for point in reversed(points) if point[0] < best], 0.0),
        ([point for point in points if point[0] > best], math.inf),
    ):
        inside, end = best, nowhere
        for at, height in outward:
            if height > limit:
                rises = misfit(inside) < limit  # not where there is no noise at all: then the end is the best itself
                end = math.exp(brentq(lambda place: misfit(place) - limit, inside, at) if rises else inside)
                break
            inside = at
        ends.append(end)
    return ends[0], ends[1]
