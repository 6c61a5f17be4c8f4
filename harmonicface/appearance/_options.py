"""Options of pictures: how far harmonics of matte surfaces are worth their time, and what casts shadows."""

from __future__ import annotations

import numpy as np

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count
from harmonicface.lighting.light import HarmonicLight, Light, SumOfLights

HIGHEST_ORDER = 200  # where the clamped cosine lets 3e-6 of the mean light through; 40,401 harmonics


def checked_order(order: int) -> int:
    """Return an order of at least 0 up to which a matte surface has light to reflect.

    Raises
    ------
    HarmonicFaceError
        Another number.
    """
    count(order)
    if order > HIGHEST_ORDER:
        raise HarmonicFaceError(
            f"order: expected at most {HIGHEST_ORDER}, beyond which a matte surface reflects less than 3e-6, "
            f"got {order:.6g}"
        )
    return int(order)


def needed_order(light: Light, order: int) -> int:
    """Return the order, or that of the light where it is lower: its higher coefficients are 0."""
    count(order)
    known = _order_of(light)
    return checked_order(order) if known is None else min(known, int(order))


def _order_of(light: Light) -> int | None:
    """Return the order of a light of harmonics alone, None of any other."""
    if isinstance(light, HarmonicLight):
        return light.order
    orders = [_order_of(part) for part in light.parts] if isinstance(light, SumOfLights) else [None]
    return None if None in orders else max(each for each in orders if each is not None)


def with_shadows(shadows: bool, bounces: int) -> bool:
    """Tell whether there are cast shadows: bounces imply them.

    Raises
    ------
    HarmonicFaceError
        Shadows that are neither true nor false, bounces that are not a count.
    """
    if not isinstance(shadows, (bool, np.bool_)):
        raise HarmonicFaceError(f"shadows: expected True or False, got {_validate.describe(shadows)}")
    return _validate.at_least(bounces, 0, "bounces") > 0 or bool(shadows)
