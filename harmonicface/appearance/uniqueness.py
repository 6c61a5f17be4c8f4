"""Whether a non-negative light is the only one that gives its irradiance, and how far another one may be from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import csr_array, hstack, identity
from scipy.spatial import KDTree

from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import Light, SumOfLights
from harmonicface.lighting.sources import DirectionalLights

Array = NDArray[np.float64]

SAME = 1e-7  # radians within which two directions are one
NOTHING = 1e-9  # of the light: what a linear program leaves of a zero
FLAT = 1e-7  # smallest singular value of unit directions that count as spanning space


@dataclass(frozen=True, eq=False)
class Uniqueness:
    """What irradiance at all normals tells of a non-negative light.

    Parameters
    ----------
    unique
        True if no other non-negative light gives the same irradiance.
    reason
        Why, in words.
    share
        The largest part of the light that another one may have at the opposite directions, 0 to 1, attained by
        `alternative`.
    bound
        No light with the same irradiance differs by more. Equal to `share` where no two sources are opposite.
    alternative
        A different light with the same irradiance; None if there is none.
    """

    unique: bool
    reason: str
    share: float
    bound: float
    alternative: DirectionalLights | None


def light_uniqueness(light: Light) -> Uniqueness:
    r"""Tell whether a non-negative light is determined by its irradiance, and how large invisible changes may be.

    What irradiance does not show are the odd degrees above 1 (Ramamoorthi & Hanrahan, On the relationship between
    radiance and irradiance, 2001, theorem 2). Such a change is odd and without linear moments, and the light must
    stay non-negative:

    .. math:: \Delta L(-w) = -\Delta L(w), \quad \int \Delta L(w) \, w \, dw = 0, \quad -L(w) \le \Delta L(w) \le L(-w)

    (section 5.B, lemma 1). So light t_j moves from w_j to its opposite, and the lamps that lose weight must balance:
    sum t_j w_j = 0. Hence a light is unique exactly if no such balance exists: always for one lamp, for two, for
    three linearly independent ones, and inside an open hemisphere. Corollary 3 of the paper asks only for a
    "nondegenerate arrangement" of three; three lamps at 120 degrees in a plane are not unique. Four lamps at the
    corners of a tetrahedron are not: the opposite tetrahedron gives the same irradiance. The largest change is found
    by a linear program.

    Parameters
    ----------
    light
        Lamps, an environment map whose pixels have opposite ones (a latlong one has), or a sum of them; coloured
        light is added up over its channels. A map's pixels are taken as lamps at their centres: 32 x 64 of them take
        a fraction of a second.

    Returns
    -------
    Uniqueness
        The answer, its reason, the bound, and another light if there is one.

    Raises
    ------
    HarmonicFaceError
        A light that is not made of directions, or a map whose pixels have no opposite ones.

    Examples
    --------
    >>> from harmonicface.lighting import lights
    >>> light_uniqueness(lights.directional([1, 2, 3])).unique
    True
    """
    directions, strengths = _pooled(*_lamps(light))
    if not len(strengths):
        return Uniqueness(True, "there is no light: nothing can be moved", 0.0, 0.0, None)
    pairs, here, there = _opposites(directions, strengths)
    moved, most = _largest_change(pairs, here, there)
    total = strengths.sum()
    share, bound = float(np.abs(moved).sum() / total), float(most / total)
    if bound <= NOTHING:
        return Uniqueness(True, _why_unique(directions, here, there), 0.0, 0.0, None)
    reason = f"{100 * share:.3g} % of the light may as well come from the opposite directions"
    return Uniqueness(False, reason, share, bound, _other(pairs, here - moved, there + moved))


def _lamps(light: Light) -> tuple[Array, Array]:
    """Return directions (n, 3) and strengths (n,) of a light that is made of them."""
    if isinstance(light, SumOfLights):
        parts = [_lamps(part) for part in light.parts]
        return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])
    if not isinstance(light, (DirectionalLights, EnvironmentMap)):
        got = type(light).__name__
        raise HarmonicFaceError(f"light: expected lamps, an environment map or a sum of them, got {got}")
    towards, strengths = light.directions.reshape(-1, 3).astype(np.float64), np.asarray(light.strengths, np.float64)
    if (
        isinstance(light, EnvironmentMap)
        and np.isinf(KDTree(towards).query(-towards, distance_upper_bound=SAME)[0]).any()
    ):
        expected = "a map whose pixels have opposite ones (latlong with an even number of columns, cube)"
        raise HarmonicFaceError(f"light: expected {expected}, got {light.layout} of shape {light.shape}")
    return towards, strengths.reshape(len(towards), -1).sum(axis=1)


def _pooled(directions: Array, strengths: Array) -> tuple[Array, Array]:
    """Add up lamps of one direction and leave out those that do not shine."""
    directions, strengths = directions[strengths > 0], strengths[strengths > 0]
    if not len(strengths):
        return directions, strengths
    first = np.arange(len(strengths))
    for i, j in sorted(KDTree(directions).query_pairs(SAME)):
        first[j] = first[i]
    return directions[np.unique(first)], np.bincount(first, strengths)[np.unique(first)].astype(np.float64)


def _opposites(directions: Array, strengths: Array) -> tuple[Array, Array, Array]:
    """Return one direction of each opposite pair, its strength, and that of the other one."""
    distance, other = KDTree(directions).query(-directions, distance_upper_bound=SAME)
    paired = np.isfinite(distance)
    first = ~paired | (np.arange(len(directions)) < other)
    there = np.zeros(len(directions))
    there[paired] = strengths[other[paired]]
    return directions[first], strengths[first], there[first]


def _largest_change(pairs: Array, here: Array, there: Array) -> tuple[Array, float]:
    """Return what moves from each direction to its opposite (negative: back), and a bound on the sum.

    Maximizing the sum of |t_j| over -there <= t <= here is no linear program where t_j may have either sign; its
    concave hull is one, and bounds it. Its solution differs from what it stands for in at most three pairs.
    """
    count, total = len(pairs), here.sum() + there.sum()
    gain = np.concatenate([here, there]) / total
    balance = np.concatenate([pairs * here[:, None], -pairs * there[:, None]]).T / total
    one = identity(count, format="csr")
    hull = _program(gain, balance, np.zeros(2 * count), np.ones(2 * count), hstack([one, one], format="csr"))
    moved = here * hull[:count] - there * hull[count:]
    if np.abs(moved).sum() <= NOTHING * total:
        moved = _some_change(pairs, here, there)
    if np.abs(moved).sum() <= NOTHING * total:
        return np.zeros(count), 0.0
    better = _program(np.sign(moved), pairs.T / total, -there, here)
    moved = max(
        _balanced(moved, pairs, here, there), _balanced(better, pairs, here, there), key=lambda t: np.abs(t).sum()
    )
    return moved, max(float(gain @ hull * total), float(np.abs(moved).sum()))


def _some_change(pairs: Array, here: Array, there: Array) -> Array:
    """Return any change at all, or zeros if there is none.

    Either some lamp without an opposite takes part, or the pairs of lamps are linearly dependent among themselves.
    """
    total = here.sum() + there.sum()
    moved = _program((there == 0).astype(float), pairs.T / total, -there, here)
    if moved[there == 0].sum() > NOTHING * total:
        return moved
    both = np.flatnonzero(there > 0)
    moved = np.zeros(len(pairs))
    values, right = np.linalg.svd(pairs[both].T)[1:]
    if len(both) > int((values > FLAT).sum()):
        ends = np.minimum(here, there)[both] / np.maximum(np.abs(right[-1]), 1e-300)
        moved[both] = right[-1] * ends.min()
    return moved


def _program(gain: Array, balance: Array, low: Array, high: Array, limits: csr_array | None = None) -> Array:
    """Maximize a linear gain within bounds under three balances, and under limits of 1."""
    found = linprog(
        -gain,
        A_ub=limits,
        b_ub=None if limits is None else np.ones(limits.shape[0]),
        A_eq=csr_array(balance),
        b_eq=np.zeros(3),
        bounds=np.stack([low, high], axis=1),
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if found.x is None:  # no change at all is feasible, so only numbers far apart can do this
        raise HarmonicFaceError(f"light: expected strengths that a linear program can balance, got: {found.message}")
    return np.asarray(found.x)


def _balanced(moved: Array, pairs: Array, here: Array, there: Array) -> Array:
    """Take the program's rounding out of the balance, as far as the ranges allow."""
    for _ in range(3):
        room = np.where((moved > 0) | (there > 0), np.minimum(here - moved, moved + there), 0.0)
        room = np.maximum(room, 0) + 1e-3 * np.where(moved != 0, np.abs(moved), 0)
        weighted = pairs * room[:, None]
        moved = moved - weighted @ np.linalg.pinv(pairs.T @ weighted) @ (pairs.T @ moved)
        moved = np.clip(moved, -there, here)
    return np.asarray(moved)


def _why_unique(directions: Array, here: Array, there: Array) -> str:
    """Say which corollary makes the light unique."""
    if len(directions) <= 2:
        return "one source" if len(directions) == 1 else "two sources"
    if not there.any() and _in_open_hemisphere(directions):
        three = len(directions) == 3 and np.linalg.svd(directions, compute_uv=False)[-1] > FLAT
        return "three sources with linearly independent directions" if three else "all light inside one open hemisphere"
    return "no sources balance each other"


def _in_open_hemisphere(directions: Array) -> bool:
    """Tell whether some direction has a positive cosine with all of them."""
    found = linprog(
        [0, 0, 0, -1],
        A_ub=np.concatenate([-directions, np.ones((len(directions), 1))], axis=1),
        b_ub=np.zeros(len(directions)),
        bounds=[(-1, 1)] * 3 + [(None, 1)],
        method="highs",
    )
    return bool(found.x[3] > NOTHING)


def _other(pairs: Array, here: Array, there: Array) -> DirectionalLights:
    """Return the lamps of a light that is given on pairs of opposite directions."""
    directions = np.concatenate([pairs, -pairs])
    strengths = np.maximum(np.concatenate([here, there]), 0)
    return DirectionalLights(directions[strengths > 0], strengths[strengths > 0])
