"""Which degrees of the light, or of the material, a reflection tells, and how well."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of
from harmonicface.reflectance._arguments import filter_values, numbers
from harmonicface.reflectance.spectra import degree_power

NOTHING = 1e-12  # of the largest factor: what rounding leaves of an exact zero


@dataclass(frozen=True, eq=False)
class Recoverability:
    """What a reflection tells of an unknown, degree by degree; `str` gives a table.

    Attributes
    ----------
    unknown
        "lighting" or "reflectance".
    factors
        (order + 1,) what each degree of the unknown is multiplied by on its way into the reflection.
    gains
        (order + 1,) by how much more than at degree 0 noise is amplified when that is undone; infinite where the
        factor is 0.
    errors
        (order + 1,) standard deviation of a recovered coefficient, as a fraction of its expected size.
    tolerance
        The error up to which a coefficient counts as recovered.
    """

    unknown: str
    factors: NDArray[np.float64]
    gains: NDArray[np.float64]
    errors: NDArray[np.float64]
    tolerance: float

    @property
    def verdicts(self) -> tuple[str, ...]:
        """For each degree "recoverable", "ill-conditioned" (noise prevails) or "lost" (no trace in the reflection)."""
        return tuple(
            "lost" if math.isinf(gain) else "recoverable" if error <= self.tolerance else "ill-conditioned"
            for gain, error in zip(self.gains, self.errors, strict=True)
        )

    @property
    def recoverable(self) -> tuple[int, ...]:
        """The degrees that the reflection tells."""
        return self._with("recoverable")

    @property
    def ill_conditioned(self) -> tuple[int, ...]:
        """The degrees that drown in the noise."""
        return self._with("ill-conditioned")

    @property
    def lost(self) -> tuple[int, ...]:
        """The degrees that no noise-free reflection could tell."""
        return self._with("lost")

    @property
    def condition(self) -> float:
        """The largest gain over the smallest, among the recoverable degrees; infinite without any."""
        kept = self.gains[list(self.recoverable)]
        return float(kept.max() / kept.min()) if kept.size else math.inf

    def _with(self, verdict: str) -> tuple[int, ...]:
        """Return the degrees of one verdict."""
        return tuple(degree for degree, given in enumerate(self.verdicts) if given == verdict)

    def __str__(self) -> str:
        lines = [f"{self.unknown:>11}   factor       gain    error  verdict"]
        rows = zip(self.factors, self.gains, self.errors, self.verdicts, strict=True)
        for degree, (factor, gain, error, verdict) in enumerate(rows):
            percent = "     inf" if math.isinf(error) else f"{100 * error:7.1f}%"
            lines.append(f"  degree {degree:2d} {factor:9.4f} {gain:10.4g} {percent}  {verdict}")
        return "\n".join([*lines, f"condition over the recoverable degrees: {self.condition:.4g}"])


def recoverable_lighting(
    filter_: ArrayLike, noise: float, spectrum: ArrayLike | None = None, tolerance: float = 0.5
) -> Recoverability:
    r"""Report which degrees of an unknown light an object of a known material shows, and how well.

    .. math:: L_{lm} = B_{lm} / f_l, \quad \text{error} = \frac{\text{noise} \, f_0}{|f_l| \, s_l}

    (Ramamoorthi & Hanrahan 2004, equation 59 and section 5.1.2.) All directions of the normal are seen; what one view
    hides is another matter. A matte sphere loses every odd degree above 1 and, with 2 % noise and the light of one
    lamp, tells degrees 0 to 2 well and 4 to 48 %.

    Parameters
    ----------
    filter_
        (order + 1,) numbers f_l of the material, or (order + 1, ...) numbers Lambda_l rho_lpq of a general one, real or
        complex: each p and q tells L_lm, so their squares add up to the squared factor.
    noise
        Standard deviation of each B_lm, as a fraction of the reflection's own degree 0.
    spectrum
        (order + 1,) expected size s_l of a light's coefficient at each degree, relative to L_00. 1 if not given: the
        white spectrum of a single lamp; natural light falls about as 1 / l, and less of it can be recovered.
    tolerance
        The relative error up to which a coefficient counts as recovered.

    Raises
    ------
    HarmonicFaceError
        A filter without degree 0, a spectrum of another length or not above 0, noise or tolerance not above 0.

    Examples
    --------
    >>> from harmonicface.reflectance.filters import lambertian_filter
    >>> report = recoverable_lighting(lambertian_filter(6), noise=0.02)
    >>> report.recoverable, report.ill_conditioned, report.lost
    ((0, 1, 2, 4), (6,), (3, 5))
    >>> print(report)
       lighting   factor       gain    error  verdict
      degree  0    3.1416          1     2.0%  recoverable
      degree  1    2.0944        1.5     3.0%  recoverable
      degree  2    0.7854          4     8.0%  recoverable
      degree  3    0.0000        inf      inf  lost
      degree  4   -0.1309         24    48.0%  recoverable
      degree  5    0.0000        inf      inf  lost
      degree  6    0.0491         64   128.0%  ill-conditioned
    condition over the recoverable degrees: 24
    """
    values = numbers(filter_, "filter")
    if values.ndim == 0 or values.size == 0:
        raise HarmonicFaceError(f"filter: expected numbers for each degree, got {_validate.describe(values)}")
    factors = values if values.ndim == 1 and values.dtype.kind != "c" else _lengths(values)
    return _report("lighting", np.asarray(factors, np.float64), noise, spectrum, tolerance)


def recoverable_reflectance(
    light: ArrayLike, noise: float, spectrum: ArrayLike | None = None, tolerance: float = 0.5
) -> Recoverability:
    r"""Report which degrees of an unknown material's filter a known light shows, and how well.

    .. math:: f_l = \frac{\sum_m B_{lm} L_{lm}}{\sum_m L_{lm}^2}, \quad
              \text{error} = \frac{\text{noise} \, |L_{00}|}{s_l \sqrt{\sum_m L_{lm}^2}}

    (Ramamoorthi & Hanrahan 2004, equation 58 and section 5.1.2, over all m by least squares.) A single lamp tells
    every degree, the higher the better; uniform light only degree 0: there a mirror looks like chalk. The same holds
    for each rho_lpq of a general material.

    Parameters
    ----------
    light
        ((order + 1)^2,) coefficients L_lm.
    noise
        Standard deviation of each B_lm, as a fraction of L_00 (of the light in a mirror at degree 0).
    spectrum
        (order + 1,) expected size s_l of the filter at each degree. 1 if not given: a mirror's.
    tolerance
        The relative error up to which a degree counts as recovered.

    Raises
    ------
    HarmonicFaceError
        Light without degree 0, not of (order + 1)^2 numbers, a spectrum of another length or not above 0, noise or
        tolerance not above 0.

    Examples
    --------
    >>> from harmonicface.reflectance.spectra import directional_spectrum, uniform_spectrum
    >>> recoverable_reflectance(directional_spectrum([0, 0, 1], 4), noise=0.02).recoverable
    (0, 1, 2, 3, 4)
    >>> recoverable_reflectance(uniform_spectrum(4), noise=0.02).lost
    (1, 2, 3, 4)
    """
    values = _validate.finite(light, "light")
    if values.ndim != 1:
        raise HarmonicFaceError(f"light: expected coefficients of shape (k,), got {_validate.describe(values)}")
    order_of(len(values))
    return _report("reflectance", np.sqrt(degree_power(values)), noise, spectrum, tolerance)


def _lengths(values: NDArray[Any]) -> NDArray[np.float64]:
    """Return the Euclidean length of what each degree holds."""
    return np.asarray(np.linalg.norm(values.reshape(len(values), -1), axis=1), np.float64)


def _report(
    unknown: str, factors: NDArray[np.float64], noise: float, spectrum: ArrayLike | None, tolerance: float
) -> Recoverability:
    """Compare each degree's factor with degree 0's, and its noise with its expected size."""
    sizes = np.ones(len(factors)) if spectrum is None else filter_values(spectrum, "spectrum")
    if len(sizes) != len(factors) or (sizes <= 0).any():
        raise HarmonicFaceError(f"spectrum: expected {len(factors)} numbers above 0, got {_validate.describe(sizes)}")
    strengths = np.abs(factors)
    seen = strengths > NOTHING * strengths.max()
    if not seen[0]:
        raise HarmonicFaceError(f"{unknown}: expected a degree 0 that is not nothing, got {factors[0]:g}")
    gains = np.full(len(factors), np.inf)
    np.divide(strengths[0], strengths, out=gains, where=seen)
    level, limit = _validate.positive(noise, "noise"), _validate.positive(tolerance, "tolerance")
    return Recoverability(unknown, factors, gains, np.asarray(level * gains / sizes, np.float64), limit)
