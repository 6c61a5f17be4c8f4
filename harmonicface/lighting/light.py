"""Light from far away: anything with an exact irradiance and with harmonic coefficients."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, index, order_of
from harmonicface.harmonics.rotation import rotate
from harmonicface.reflectance.filters import lambertian_weights

BRIGHTEST = 1e30  # far beyond any light, and its sums over millions of pixels are within float32


class Light(ABC):
    """Distant light L(w), a function of direction alone; grey, or one value a colour.

    Lights add: `sun + sky` is a Light. They scale: `0.5 * sun` is a Light, and `[1, 0.9, 0.7] * sun` a tinted one.
    """

    __array_ufunc__: ClassVar[None] = None  # an array times a light is a light, not an array of lights

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
    def rotated(self, rotation: Any) -> Light:
        """Return the whole light turned: what came from w comes from R w, and E'(R n) = E(n).

        Parameters
        ----------
        rotation
            One scipy `Rotation`, or a 3 x 3 rotation matrix R.

        Raises
        ------
        HarmonicFaceError
            Something that is no rotation.
        """

    @abstractmethod
    def __mul__(self, factor: ArrayLike) -> Light: ...

    def __rmul__(self, factor: ArrayLike) -> Light:
        return self * factor

    def __add__(self, other: Light) -> Light:
        return SumOfLights((self, other)) if isinstance(other, Light) else NotImplemented

    def __radd__(self, other: int) -> Light:
        return self if other == 0 else NotImplemented  # sum() starts from 0


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
        A count that is not a square number, NaN or infinity, a coefficient beyond 1e35 in size.

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
        require_at_most(
            1e5 * BRIGHTEST, np.abs(values), "coefficients"
        )  # those of a map that bright, and of sums of them
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
        result = no_coefficients(order, self.values.shape[1:]).astype(self.values.dtype, copy=False)
        shared = min(len(result), len(self.values))
        result[:shared] = self.values[:shared]
        return result

    def rotated(self, rotation: Any) -> HarmonicLight:
        return HarmonicLight(rotate(self.values, rotation))

    def with_coefficient(self, degree: int, mode: int, value: ArrayLike) -> HarmonicLight:
        """Return the light with another L_lm; a degree above its order extends it.

        L_1-1 is how much brighter it is above than below: below zero it lights a face from below (Ramamoorthi &
        Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, section 3.3).

        Parameters
        ----------
        degree, mode
            l and m, from -l to l.
        value
            One number, or three for coloured light.

        Raises
        ------
        HarmonicFaceError
            No such mode, a value that is not finite, three values for grey light.

        Examples
        --------
        >>> HarmonicLight([1.0, 0.4, 0.0, 0.0]).with_coefficient(1, -1, -0.4).values
        array([ 1. , -0.4,  0. ,  0. ])
        """
        place = index(degree, mode)
        values = self.coefficients(max(self.order, degree)).copy()
        values[place] = self._a_colour(value, "value")
        return HarmonicLight(values)

    def with_linear_term(self, direction: ArrayLike, strength: ArrayLike) -> HarmonicLight:
        r"""Return the light with radiance s d.w added: brighter toward d, darker away from it.

        Its harmonics are sqrt(4 pi / 3) s (d_y, d_z, d_x), and it adds 2 pi / 3 s d.n to the irradiance: E of a
        surface that faces d grows by 2.09 s. "Light it from below" is `light.with_linear_term([0, -1, 0], s)`.

        Parameters
        ----------
        direction
            (3,) d, of any length above 0.
        strength
            The radiance s added toward d, one number or three for coloured light.

        Raises
        ------
        HarmonicFaceError
            A direction of zero length, a strength that is not finite, three strengths for grey light.

        Examples
        --------
        >>> HarmonicLight([1.0]).with_linear_term([0, -1, 0], 0.5).values.round(4) + 0.0
        array([ 1.    , -1.0233,  0.    ,  0.    ])
        """
        towards = _validate.directions(direction, "direction")
        if towards.shape != (3,):
            raise HarmonicFaceError(f"direction: expected one of shape (3,), got {towards.shape}")
        colours = self._a_colour(strength, "strength")
        values = self.coefficients(max(self.order, 1)).copy()
        require_at_most(1e5 * BRIGHTEST, np.abs(colours), "strength")
        values[1:4] += math.sqrt(4 * math.pi / 3) * np.multiply.outer(towards[[1, 2, 0]], colours)
        return HarmonicLight(values)

    def __mul__(self, factor: ArrayLike) -> HarmonicLight:
        return HarmonicLight(scaled(self.values, factor, self.channels == 3))

    def _a_colour(self, value: ArrayLike, name: str) -> Floats:
        """Return one number for grey light, three for coloured; one number is the same for all colours."""
        number, shape = _validate.finite(value, name), self.values.shape[1:]
        if number.shape not in ((), shape):
            expected = "one number" if shape == () else "one number or three"
            raise HarmonicFaceError(f"{name}: expected {expected}, got {_validate.describe(number)}")
        return np.broadcast_to(number, shape)


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

    def rotated(self, rotation: Any) -> SumOfLights:
        return SumOfLights(tuple(part.rotated(rotation) for part in self.parts))

    def __mul__(self, factor: ArrayLike) -> SumOfLights:
        return SumOfLights(tuple(part * factor for part in self.parts))


def scaled(values: Floats, factor: ArrayLike, coloured: bool) -> Floats:
    """Return values times one factor, or times three: one a colour, by which grey values, (...), become (..., 3).

    Raises
    ------
    HarmonicFaceError
        A factor that is not finite, or neither one number nor three.
    """
    number = _validate.finite(factor, "factor")
    if number.shape not in ((), (3,)):
        raise HarmonicFaceError(f"factor: expected one number or three, got {_validate.describe(number)}")
    with np.errstate(over="ignore", invalid="ignore"):  # each light refuses what is not finite
        exact = number.astype(values.dtype)
        return np.asarray(values * exact if coloured or number.ndim == 0 else np.multiply.outer(values, exact))


def require_at_most(largest: float, values: Floats, name: str) -> None:
    """Raise HarmonicFaceError if one of some numbers is larger."""
    if values.max(initial=0) > largest:
        raise HarmonicFaceError(f"{name}: expected at most {largest:.3g}, got {values.max():.4g}")


def no_coefficients(order: int, colours: tuple[int, ...]) -> NDArray[np.float64]:
    """Return coefficients of darkness, ((order + 1)^2,) or (..., 3), to be filled; as many as the memory holds."""
    shape = (count(order), *colours)
    _memory.require(8 * math.prod(shape), f"coefficients up to order {order}")
    return np.zeros(shape)
