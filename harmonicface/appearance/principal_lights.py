"""Light statistics: the mean and covariance of the harmonics of light that is drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import roots_legendre

from harmonicface import _validate
from harmonicface.appearance.principal_natural import natural_statistics
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.grid import SphereGrid, sphere_grid
from harmonicface.harmonics.indexing import count, order_of
from harmonicface.harmonics.quadrature import project, synthesize
from harmonicface.io.colour import luminance
from harmonicface.lighting.as_light import as_light
from harmonicface.lighting.light import Light
from harmonicface.reflectance.filters import lambertian_weights

Array = NDArray[np.float64]

HIGHEST_ORDER = 12  # beyond it a matte surface reflects 1.3e-4 of the energy of a single lamp
POWER_ORDER = 4  # of the mean square irradiance as a function of the normal, which is smooth
# 2 pi times the integral of c^2 P_l(c) over 0 to 1: the filter of a squared clamped cosine, to POWER_ORDER
SQUARED_FILTER = 2 * np.pi * np.array([1 / 3, 1 / 4, 2 / 15, 1 / 24, 0])
NEGATIVE = 1e-9  # of the largest eigenvalue: what is below is no rounding
DISTRIBUTIONS = ("sphere", "frontal", "natural")
EXPECTED = (
    f"one of {', '.join(map(repr, DISTRIBUTIONS))}, a Light or several, coefficients (k,) of the density of lamps, "
    "a covariance (k, k) of light coefficients, or LightStatistics"
)


@dataclass(frozen=True, eq=False)
class LightStatistics:
    r"""Mean and covariance of the harmonic coefficients of random light, and the mean square irradiance.

    Parameters
    ----------
    mean
        (169,) mean coefficients <L_lm>, to order 12.
    covariance
        (169, 169) of the coefficients about their mean.
    power
        (25,) harmonic coefficients, to order 4, of the mean square <E(n)^2> of the exact irradiance, with all degrees
        of the light.
    """

    mean: Array
    covariance: Array
    power: Array

    @property
    def moment(self) -> Array:
        """Second moment of the coefficients, the mean of their products, (169, 169)."""
        return self.covariance + np.outer(self.mean, self.mean)

    def variation(self, order: int, centered: bool) -> Array:
        """Return the covariance up to an order, or if not centered the second moment, (k, k)."""
        size = count(order)
        return (self.covariance if centered else self.moment)[:size, :size]

    def tail(self, order: int, centered: bool) -> Array:
        """Return harmonic coefficients (25,) of what the degrees above an order add to the variance of E(n)."""
        return _tail(self, order, centered)


@lru_cache
def _tail(statistics: LightStatistics, order: int, centered: bool) -> Array:
    """Return the same, kept for the statistics that were asked last."""
    mean = statistics.mean if centered else np.zeros_like(statistics.mean)
    size = count(order)
    known = np.zeros_like(statistics.covariance)
    known[:size, :size] = statistics.variation(order, centered)
    return np.asarray(statistics.power - _square(np.outer(mean, mean) + known))


Lights = str | Light | Sequence[Light | str] | ArrayLike | LightStatistics


def light_statistics(lights: Lights) -> LightStatistics:
    r"""Return the statistics of light that is drawn from a distribution.

    Of lamps of strength 1 in directions of density q

    .. math:: <L_{lm}> = q_{lm}, \quad <L_{lm} L_{l'm'}> = \int q \, Y_{lm} Y_{l'm'} \, dw, \quad
              <E(n)^2> = \int q \max(n \cdot w, 0)^2 \, dw

    For the whole sphere the second moment is the identity over 4 pi (Ramamoorthi, Analytic PCA Construction for
    Theoretical Analysis of Lighting Variability in Images of a Lambertian Object, 2002).

    Parameters
    ----------
    lights
        "sphere": one lamp of strength 1, from anywhere alike; "frontal": from anywhere in front, z > 0; "natural":
        the environments of `lights.natural`. A Light or several, such as `EnvironmentMap`: each of them equally often,
        coloured ones as luminance; a published name is one. An array (k,): one lamp of strength 1, from directions of
        a density with these harmonic coefficients, scaled to an integral of 1. An array (k, k): the covariance of
        light coefficients, of mean 0. `LightStatistics` stay as they are.

    Raises
    ------
    HarmonicFaceError
        Anything else; a density without lamps or negative in places, a covariance that is not symmetric or negative.

    Examples
    --------
    >>> float((4 * np.pi * light_statistics("sphere").moment[4, 4]).round(6))
    1.0
    """
    if isinstance(lights, LightStatistics):
        return lights
    if isinstance(lights, str) and lights in DISTRIBUTIONS:
        return _named(lights)
    if isinstance(lights, (Light, str)):
        return _of_lights([lights])
    if isinstance(lights, (list, tuple)) and lights and all(isinstance(one, (Light, str)) for one in lights):
        return _of_lights(lights)
    try:
        numbers = _validate.finite(lights, "lights")  # type: ignore[arg-type]
    except HarmonicFaceError:
        raise HarmonicFaceError(f"lights: expected {EXPECTED}, got {_validate.describe(lights)}") from None
    if numbers.ndim == 1 and numbers.size:
        return _of_density(numbers.astype(np.float64))
    if numbers.ndim == 2 and numbers.shape[0] == numbers.shape[1] and numbers.size:
        return _of_covariance(numbers.astype(np.float64))
    raise HarmonicFaceError(f"lights: expected {EXPECTED}, got {_validate.describe(numbers)}")


@lru_cache
def _named(name: str) -> LightStatistics:
    """Return the statistics of a distribution by its name."""
    if name == "natural":
        mean, covariance = natural_statistics()
        return LightStatistics(mean, covariance, _square(covariance + np.outer(mean, mean)))
    if name == "sphere":
        density, covariance = np.zeros(count(HIGHEST_ORDER)), np.eye(count(HIGHEST_ORDER)) / (4 * np.pi)
        density[0], covariance[0, 0] = 1 / np.sqrt(4 * np.pi), 0
        return LightStatistics(density, covariance, _lamp_power(density))
    z, weights = roots_legendre(HIGHEST_ORDER + 1)
    front = SphereGrid((z + 1) / 2, weights / 2 * 2 * np.pi / (2 * HIGHEST_ORDER + 1), 2 * HIGHEST_ORDER + 1)
    harmonics = real_harmonics(front.directions, HIGHEST_ORDER)
    weighted = harmonics * (front.weights / (2 * np.pi))
    density = weighted.sum(axis=1)
    return LightStatistics(density, weighted @ harmonics.T - np.outer(density, density), _lamp_power(density))


def _of_density(density: Array) -> LightStatistics:
    """Return the statistics of lamps whose density has these harmonic coefficients."""
    order = order_of(len(density))
    if density[0] <= 0:
        raise HarmonicFaceError(
            f"lights: expected a density with an integral above 0, got {density[0]:.4g} in degree 0"
        )
    density = density / (density[0] * np.sqrt(4 * np.pi))
    grid = sphere_grid(HIGHEST_ORDER + (order + 1) // 2)
    harmonics = real_harmonics(grid.directions, HIGHEST_ORDER)
    moment = (harmonics * (grid.weights * synthesize(density, grid).ravel())) @ harmonics.T
    if _least_eigenvalue(moment) < -NEGATIVE:
        raise HarmonicFaceError("lights: expected a density of at least 0, got one that is negative in some directions")
    mean = np.zeros(count(HIGHEST_ORDER))
    mean[: len(density)] = density[: len(mean)]
    return LightStatistics(mean, moment - np.outer(mean, mean), _lamp_power(mean))


def _of_covariance(covariance: Array) -> LightStatistics:
    """Return the statistics of light of mean 0."""
    size = len(covariance)
    order_of(size)
    largest = np.abs(covariance).max()
    if not np.allclose(covariance, covariance.T, rtol=0, atol=NEGATIVE * largest):
        raise HarmonicFaceError("lights: expected a symmetric covariance, got one that differs from its transpose")
    if _least_eigenvalue(covariance) < -NEGATIVE:
        raise HarmonicFaceError("lights: expected a covariance without negative eigenvalues, got one with some")
    most = count(HIGHEST_ORDER)
    padded = np.zeros((max(size, most),) * 2)
    padded[:size, :size] = covariance
    return LightStatistics(np.zeros(most), padded[:most, :most], _square(padded[:most, :most]))


def _of_lights(lights: Sequence[Light | str]) -> LightStatistics:
    """Return the statistics of lights of which each comes equally often."""
    found = [as_light(one).coefficients(HIGHEST_ORDER).astype(np.float64) for one in lights]
    grey = np.stack([luminance(one) if one.ndim == 2 else one for one in found])
    mean = grey.mean(axis=0)
    from_mean = grey - mean
    return LightStatistics(mean, from_mean.T @ from_mean / len(grey), _square(grey.T @ grey / len(grey)))


def _lamp_power(density: Array) -> Array:
    """Return the harmonics of the mean square irradiance of one lamp of strength 1, (25,)."""
    weights = np.repeat(SQUARED_FILTER, 2 * np.arange(POWER_ORDER + 1) + 1)
    return np.asarray(weights * density[: len(weights)])


def _square(moment: Array) -> Array:
    """Return the harmonics, (25,), of <E(n)^2> by the second moment of light coefficients."""
    if not moment.any():
        return np.zeros(count(POWER_ORDER))
    grid, filtered = _reflected()
    return project(np.einsum("in,in->n", filtered, moment @ filtered), POWER_ORDER, grid)


@lru_cache
def _reflected() -> tuple[SphereGrid, Array]:
    """Return a grid of normals, and A_l Y_lm on it, (169, n); exact for squares and degrees up to POWER_ORDER."""
    grid = sphere_grid(HIGHEST_ORDER + POWER_ORDER // 2)
    return grid, lambertian_weights(HIGHEST_ORDER)[:, None] * real_harmonics(grid.directions, HIGHEST_ORDER)


def _least_eigenvalue(matrix: Array) -> float:
    """Return the smallest eigenvalue over the largest in size."""
    values = np.linalg.eigvalsh(matrix)
    return float(values[0] / max(np.abs(values).max(), np.finfo(np.float64).tiny))
