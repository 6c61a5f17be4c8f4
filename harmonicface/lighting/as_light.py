"""Whatever a person calls a light, as a Light."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.light import HarmonicLight, Light, SumOfLights
from harmonicface.lighting.published import TABLE, published
from harmonicface.lighting.sources import DirectionalLights

LightLike = Light | str | ArrayLike | Sequence[Any]
EXPECTED = (
    "a Light, a published name, coefficients (k,) or (k, 3), a direction (3,), or a list of lights and directions"
)


def as_light(value: LightLike) -> Light:
    """Return what was given as a Light.

    Parameters
    ----------
    value
        A `Light` stays as it is. A name is one of the `published` lights. An array of shape (k,) or (k, 3) with
        k = 1, 4, 9, 16 ... holds harmonic coefficients of the radiance; three numbers are the direction to a lamp of
        strength 1. A list or tuple of any of `Light`, name, and direction is their sum; since four or nine rows of
        three numbers might mean either, coefficients in colour have to come as an array, and so many directions as
        `DirectionalLights` or as arrays.

    Returns
    -------
    Light
        With an exact irradiance and with coefficients.

    Raises
    ------
    HarmonicFaceError
        Anything else: another name, a shape that is none of these, an empty list, NaN, a direction of zero length.

    Examples
    --------
    >>> as_light("grace").channels
    3
    >>> as_light([0, 0, 2]).irradiance([[0.0, 0.6, 0.8]])
    array([0.8])
    >>> as_light(["grace", [0, 0, 1]]).irradiance([[0.0, 0.0, 1.0]]).round(2)
    array([[1.27, 1.16, 1.13]])
    """
    if isinstance(value, (Light, str)):
        return _named_or_light(value)
    if isinstance(value, (list, tuple)) and any(not _is_number(item) for item in value):
        return _sum(value)
    numbers = _numbers(value)
    if numbers.shape == (3,):
        return _lamp(numbers)
    if numbers.size and numbers.shape[1:] in ((), (3,)) and numbers.ndim:
        return HarmonicLight(numbers)
    raise HarmonicFaceError(f"light: expected {EXPECTED}, got {_validate.describe(numbers)}")


def _named_or_light(value: Light | str) -> Light:
    """Return a light by its published name; a Light is one."""
    if isinstance(value, Light):
        return value
    if value not in TABLE:
        names = ", ".join(map(repr, TABLE))
        raise HarmonicFaceError(f"light: expected one of {names} (EnvironmentMap.load reads a file), got {value!r}")
    return published(value)


def _sum(items: Sequence[Any]) -> Light:
    """Return several lights as one."""
    if len(items) > 1 and math.isqrt(len(items)) ** 2 == len(items) and all(_is_plain_row(item) for item in items):
        raise HarmonicFaceError(
            f"light: expected an array of coefficients or a list of DirectionalLights, got {len(items)} rows of three "
            "numbers, which may be either"
        )
    lights = [_named_or_light(item) if isinstance(item, (Light, str)) else _lamp(_numbers(item)) for item in items]
    return lights[0] if len(lights) == 1 else SumOfLights(tuple(lights))


def _lamp(direction: _validate.Floats) -> DirectionalLights:
    """Return a lamp of strength 1 in a direction."""
    if direction.shape != (3,):
        got = _validate.describe(direction)
        raise HarmonicFaceError(f"light: expected lights, names and directions (3,) in a list, got {got}")
    return DirectionalLights(direction[None], np.ones(1))


def _numbers(value: object) -> _validate.Floats:
    """Return numbers as an array, or say all that a light may be."""
    try:
        return _validate.finite(value, "light")  # type: ignore[arg-type]
    except HarmonicFaceError as error:
        if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
            raise  # NaN among numbers
        raise HarmonicFaceError(f"light: expected {EXPECTED}, got {_validate.describe(value)}") from error


def _is_number(value: object) -> bool:
    """Tell a real number from everything else."""
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _is_plain_row(value: object) -> bool:
    """Tell three bare numbers from a light and from an array."""
    return isinstance(value, (list, tuple)) and len(value) == 3 and all(map(_is_number, value))
