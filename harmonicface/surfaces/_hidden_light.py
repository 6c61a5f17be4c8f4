"""Hidden light: the harmonics of clamped cosines between two elevations, integrated in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees, modes

Doubles = NDArray[np.float64]

VERTICAL = 1e12  # a slope whose angle is a right one but for 1e-12, and whose square is still a number
BLOCK = 1 << 11  # pixels times azimuths of one matrix product: its factors stay in the cache
ROUNDING = 1e-12  # of coefficients that are 0


@dataclass(frozen=True, eq=False)
class Group:
    """Harmonics whose integrals are sums of the same waves.

    Of the 4 d + 2 products of a wave with n_h or n_z, the harmonics with even l and even m need a quarter, those
    with odd l and even m another, and so on.
    """

    harmonics: NDArray[np.intp]  # (g,) where they are stored
    of_horizontal: NDArray[np.intp]  # which waves are needed times n_h
    of_vertical: NDArray[np.intp]  # and which times n_z
    coefficients: Doubles  # (g, c) of the former and the latter


@dataclass(frozen=True, eq=False)
class HiddenLight:
    """What there is between a tangent plane and a horizon, for the harmonics up to an order."""

    order: int
    groups: tuple[Group, ...]

    @classmethod
    def of(cls, order: int) -> HiddenLight:
        """Group the harmonics up to an order by what they need."""
        integrals = antiderivatives(order)
        kind = 2 * (degrees(order) % 2) + modes(order) % 2
        groups = []
        for each in np.unique(kind):
            harmonics = np.flatnonzero(kind == each)
            horizontal, vertical = integrals[:, harmonics]
            first, second = (np.flatnonzero((np.abs(part) > ROUNDING).any(axis=0)) for part in (horizontal, vertical))
            coefficients = np.concatenate([horizontal[:, first], vertical[:, second]], axis=1)
            groups.append(Group(harmonics, first, second, coefficients))
        return cls(order, tuple(groups))

    def take_away(self, result: Floats, normals: Floats, slopes: Doubles, azimuths: Doubles, width: float) -> None:
        """Subtract from (k, p) what horizons of some slopes (a, p) hide in sectors of some width about azimuths."""
        m = modes(self.order)[:, None]
        across = width * np.where(m < 0, np.sin(-m * azimuths), np.cos(m * azimuths))
        matrices = [
            (across[group.harmonics, None, :] * group.coefficients[:, :, None]).reshape(len(group.harmonics), -1)
            for group in self.groups
        ]
        towards = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
        size = max(1, BLOCK // len(azimuths))
        for first in range(0, slopes.shape[1], size):
            pixels = slice(first, first + size)
            normal = normals[pixels].astype(np.float64)
            horizontal, vertical = towards @ normal[:, :2].T, normal[:, 2]
            lower, upper = hidden_range(horizontal, vertical, slopes[:, pixels])
            between = waves(upper, self.order + 2)
            between -= waves(lower, self.order + 2)
            for group, matrix in zip(self.groups, matrices, strict=True):
                parts = np.empty((group.coefficients.shape[1], *horizontal.shape))
                split = len(group.of_horizontal)
                for part, wave in zip(parts[:split], group.of_horizontal, strict=True):
                    np.multiply(between[wave], horizontal, out=part)
                for part, wave in zip(parts[split:], group.of_vertical, strict=True):
                    np.multiply(between[wave], vertical, out=part)
                result[group.harmonics, pixels] -= matrix @ parts.reshape(matrix.shape[1], -1)


def antiderivatives(order: int) -> Doubles:
    r"""Return the antiderivatives of Y_lm(e) cos^2 e and Y_lm(e) sin e cos e as sums of waves, (2, k, 2 d + 1).

    Y_lm(e) is the harmonic of mode |m| at (cos e, 0, sin e), a trigonometric polynomial of degree l. The waves are e,
    sin e, ..., sin d e, cos e, ..., cos d e with d = order + 2.
    """
    degree = order + 2
    samples = 2 * degree + 1
    e = 2 * np.pi * np.arange(samples) / samples
    cosine, sine = np.cos(e), np.sin(e)
    l, m = degrees(order), np.abs(modes(order))  # noqa: E741
    harmonics = real_harmonics(np.stack([cosine, np.zeros(samples), sine], axis=1), order)[l * (l + 1) + m]
    sums = np.fft.rfft(np.stack([harmonics * cosine**2, harmonics * sine * cosine])) / samples
    k = np.arange(1, degree + 1)
    return np.concatenate([sums[..., :1].real, 2 * sums[..., 1:].real / k, 2 * sums[..., 1:].imag / k], axis=-1)


def hidden_range(horizontal: Doubles, vertical: Floats, slopes: Doubles) -> tuple[Doubles, Doubles]:
    """Return the slopes between which a horizon hides light in front of the tangent plane, two arrays (a, n).

    Where the normal points away from the camera, the tangent plane bounds the light from above.
    """
    steepness = horizontal / np.maximum(np.abs(vertical), 1 / VERTICAL**2)
    np.clip(steepness, -VERTICAL, VERTICAL, out=steepness)
    up = vertical > 0
    lower = np.where(up, -steepness, -VERTICAL)
    upper = np.minimum(slopes, np.where(up, VERTICAL, steepness))
    return lower, np.maximum(lower, upper, out=upper)


def waves(slopes: Doubles, degree: int) -> NDArray[Any]:
    """Return e, sin e, ..., sin d e, cos e, ..., cos d e of the angles with some tangents, (2 d + 1, ...)."""
    result = np.empty((2 * degree + 1, *slopes.shape))
    np.arctan(slopes, out=result[0])
    sines, cosines = result[1 : degree + 1], result[degree + 1 :]
    np.multiply(slopes, slopes, out=cosines[0])
    cosines[0] += 1
    np.divide(1, np.sqrt(cosines[0], out=cosines[0]), out=cosines[0])
    np.multiply(slopes, cosines[0], out=sines[0])
    twice = 2 * cosines[0]
    for several, zeroth in ((sines, 0.0), (cosines, 1.0)):
        for k in range(1, degree):
            np.multiply(several[k - 1], twice, out=several[k])
            several[k] -= several[k - 2] if k > 1 else zeroth
    return result
