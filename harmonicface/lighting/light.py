"""Light from far away: anything with an exact irradiance and with harmonic coefficients."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, order_of
from harmonicface.reflectance.filters import lambertian_weights


class Light(ABC):
    """Distant light L(w), a function of direction alone; grey, or one value a colour.

    Lights add: `sun + sky` is a Light. They scale: `0.5 * sun` is a Light.
    """

    @property
    @abstractmethod
    def channels(self) -> int:
        """1 for grey light, 3 for colour."""

    @abstractmethod
    def irradiance(self, normals: ArrayLike) -> Floats:
        r"""Return E(n) = \int L(w) max(n.w, 0) dw, exactly.

        Parameters
        ----------
        normals
            (..., 3) unit vectors.

        Returns
        -------
        array
            (...) irradiance, or (..., 3) under coloured light; a unit directional light seen frontally gives 1.

        Raises
        ------
        HarmonicFaceError
            Normals that are not finite unit vectors.
        """

    @abstractmethod
    def coefficients(self, order: int = 2) -> Floats:
        r"""Return L_lm = \int L(w) Y_lm(w) dw, ((order + 1)^2,), or (..., 3) for coloured light."""

    @abstractmethod
    def __mul__(self, factor: float) -> Light: ...

    def __rmul__(self, factor: float) -> Light:
        return self * factor

    def __add__(self, other: Light) -> Light:
        return SumOfLights((self, other)) if isinstance(other, Light) else NotImplemented


@dataclass(frozen=True, eq=False)
class HarmonicLight(Light):
    """Light given by its harmonic coefficients; its irradiance is that of these coefficients and no others.

    A truncated series may be negative in places, and so may its irradiance.

    Parameters
    ----------
    values
        ((order + 1)^2,) or ((order + 1)^2, 3) coefficients L_lm of the radiance.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> HarmonicLight([1.0, 0.0, 0.5, 0.0]).irradiance([[0.0, 0.0, 1.0]]).round(4)
    array([1.3979])
    """

    values: Floats

    def __post_init__(self) -> None:
        values = _validate.finite(self.values, "coefficients")
        if values.ndim not in (1, 2) or (values.ndim == 2 and values.shape[1] != 3):
            raise HarmonicFaceError(f"coefficients: expected shape (k,) or (k, 3), got {values.shape}")
        order_of(len(values))
        object.__setattr__(self, "values", values)

    @property
    def order(self) -> int:
        """The highest degree that it has a coefficient for."""
        return order_of(len(self.values))

    @property
    def channels(self) -> int:
        return 1 if self.values.ndim == 1 else 3

    def irradiance(self, normals: ArrayLike) -> Floats:
        harmonics = real_harmonics(normals, self.order)
        weighted = (lambertian_weights(self.order) * self.values.T).T.astype(harmonics.dtype)
        return np.asarray(np.tensordot(harmonics, weighted, (0, 0)))

    def coefficients(self, order: int = 2) -> Floats:
        result = np.zeros((count(order), *self.values.shape[1:]), self.values.dtype)
        shared = min(len(result), len(self.values))
        result[:shared] = self.values[:shared]
        return result

    def __mul__(self, factor: float) -> HarmonicLight:
        return HarmonicLight(self.values * factor)


@dataclass(frozen=True, eq=False)
class SumOfLights(Light):
    """Several lights at once."""

    parts: tuple[Light, ...]

    @property
    def channels(self) -> int:
        return max(part.channels for part in self.parts)

    def irradiance(self, normals: ArrayLike) -> Floats:
        return self._total([part.irradiance(normals) for part in self.parts])

    def coefficients(self, order: int = 2) -> Floats:
        return self._total([part.coefficients(order) for part in self.parts])

    def _total(self, terms: list[Floats]) -> Floats:
        """Add what the parts give; grey light adds to each colour."""
        coloured = self.channels == 3
        spread = [
            term[..., None] if coloured and part.channels == 1 else term
            for part, term in zip(self.parts, terms, strict=True)
        ]
        return np.asarray(sum(spread[1:], start=spread[0]))

    def __mul__(self, factor: float) -> SumOfLights:
        return SumOfLights(tuple(part * factor for part in self.parts))
