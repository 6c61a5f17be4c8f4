"""Rows of the stability table: horizons before a step."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.stability.row import CONSTANT, Answers, Measured, Rows, named, rounded, unit
from harmonicface.surfaces.horizon import horizons

SIDE = 24


def of_horizons() -> Answers:
    """Return a function for each row."""
    rows: Rows = {}
    for factor in (1e-12, 1e12, 1e-100, 1e100):
        rows[f"a step times {factor:.0e}"] = partial(_before_a_step, factor, factor)
    rows["a step upon a height of 1e+08"] = partial(_before_a_step, ground=1e8)
    for height in (1e-12, 1e12):
        rows[f"a step of {height:.0e} pixels"] = partial(_before_a_step, height)
    rows["a step of 1e-310 (subnormal)"] = partial(_before_a_step, 1e-310, 1e-310)
    rows["one pixel"] = lambda: rounded(horizons(np.ones((1, 1)), None, 1.0, [0.0]), [[-np.pi / 2]])
    rows["an empty mask"] = partial(_before_a_step, mask=np.zeros((1, SIDE), bool))
    rows["infinite depth in the mask"] = partial(_before_a_step, np.inf)
    return named("horizons", rows)


def _before_a_step(
    height: float = 1.0, size: float = 1.0, ground: float = 0.0, mask: NDArray[np.bool_] | None = None
) -> Measured:
    """Compare the horizons before a step with arctan(height / distance); a high ground takes digits from both."""
    depth = np.where(np.arange(SIDE)[None] >= SIDE // 2, ground + height, ground)
    distance = size * (SIDE // 2 - np.arange(SIDE // 2)).astype(np.longdouble)
    found = horizons(depth, mask, size, [0.0])[0, : SIDE // 2]
    right = np.arctan2(np.longdouble(height), distance)
    condition = max(1.0, ground / height)
    least = rounded(found, right, condition)
    if height >= 1e-300:
        return least
    return Measured(least.error, CONSTANT * condition * unit(height), condition, "heights are subnormal")
