"""Second order: the transformation that makes nine factors of photographs the harmonics of one field of normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.stereo.linear_shape import unit

SETTLED = 1e-7  # relative decrease of the cost by which the search ends
NEWTON = 4  # steps of a pixel toward the normal whose harmonics are nearest

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HarmonicTransformation:
    """Nine factors turned into the harmonics of a field of normals.

    Parameters
    ----------
    matrix
        (9, k): `matrix @ factors` is about albedo times the nine harmonics of the normals.
    scaled
        (p, 3) albedo times normal.
    cost
        What is left, each step's sum of squares; none is larger than the one before.
    """

    matrix: Doubles
    scaled: Doubles
    cost: list[float]


def harmonic_transformation(right: Floats, start: Floats, rounds: int = 50) -> HarmonicTransformation:
    r"""Find the transformation that makes factors of photographs the harmonics of one unit field.

    .. math:: \min_{T, \rho, n} \sum_x |\rho_x Y(n_x) - T f_x|^2

    by projecting in turn: T is a least-squares problem for given normals; for given T each pixel's normal is where
    `Y(n) . T f` is largest, found by Newton steps on the sphere, and its albedo follows, `rho = Y(n) . T f / |Y|^2`
    with `|Y|^2 = 9 / (4 pi)` everywhere (Basri, Jacobs & Kemelmacher 2007, section 4.2, take the first rows of T and
    leave the others). No step makes the sum larger. What the condition cannot tell remains as it starts: a rotation,
    and the boosts of the Lorentz group, under which harmonics of any order mix among themselves.

    Parameters
    ----------
    right
        (k, p) factors of photographs, k of at least 9, with orthogonal rows.
    start
        (p, 3) scaled normals to start from.
    rounds
        Of projections, at most; at least 1.

    Raises
    ------
    HarmonicFaceError
        Shapes that do not fit, fewer than nine factors, no rounds, numbers that are not finite.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> normals = unit(rng.normal(size=(500, 3)) + [0, 0, 2])
    >>> mixed = rng.normal(size=(9, 9)) @ real_harmonics(normals, 2)
    >>> factors = np.linalg.svd(mixed, full_matrices=False)[2]
    >>> found = harmonic_transformation(factors, normals)
    >>> bool(found.cost[-1] < 1e-12), bool(np.allclose(unit(found.scaled), normals, atol=1e-5))
    (True, True)
    """
    factors = _validate.finite(right, "right").astype(np.float64)
    scaled = _validate.finite(start, "start").astype(np.float64)
    if factors.ndim != 2 or len(factors) < 9 or scaled.shape != (factors.shape[1], 3):
        raise HarmonicFaceError(
            f"right: expected shape (k, p), k of at least 9, with a start of (p, 3), got {factors.shape} with "
            f"{scaled.shape}"
        )
    number = _validate.at_least(rounds, 1, "rounds")
    normals, albedo = unit(scaled), np.linalg.norm(scaled, axis=1)
    power = albedo @ albedo
    inverse = np.linalg.pinv(factors.T)
    matrix, cost = np.zeros((9, len(factors))), list[float]()
    for _ in range(number):
        matrix = (albedo * real_harmonics(normals, 2)) @ inverse.T
        wanted = matrix @ factors
        better = _towards(normals, wanted)
        harmonics = real_harmonics(better, 2)
        level = np.einsum("kp,kp->p", harmonics, wanted) * (4 * np.pi / 9)
        normals, albedo = better, np.maximum(level, 0.0)
        rest = albedo * harmonics - wanted
        # the scale of all together is free: it is kept, so that the sum cannot shrink by shrinking everything
        scale = float(np.sqrt(power / max(albedo @ albedo, 1e-300)))
        albedo, matrix = albedo * scale, matrix * scale
        cost.append(float(np.einsum("kp,kp->", rest, rest)) * scale**2)
        if len(cost) > 1 and cost[-2] - cost[-1] < SETTLED * cost[-2]:
            break
    return HarmonicTransformation(matrix, albedo[:, None] * normals, cost)


def _towards(normals: Doubles, wanted: Doubles) -> Doubles:
    """Move each normal uphill to where its harmonics agree best with the nine wanted numbers."""
    linear, form = _quadratic(wanted)
    value = _value(linear, form, normals)
    found = normals
    for _ in range(NEWTON):
        slope = linear + 2 * np.einsum("pij,pj->pi", form, found)
        # on the sphere the stationary points of a quadratic are where the slope is along the normal
        along = np.einsum("pi,pi->p", slope, found)
        lift = np.linalg.norm(form, axis=(1, 2)) * 2 + np.abs(along)
        tried = unit(found * lift[:, None] + slope)
        better = _value(linear, form, tried) >= value
        found = np.where(better[:, None], tried, found)
        value = _value(linear, form, found)
    return found


def _quadratic(wanted: Doubles) -> tuple[Doubles, Doubles]:
    """Return what `wanted . Y(n)` is as `constant + linear . n + n' form n`, without the constant."""
    c1, c2, c3, c5 = np.sqrt(np.array([3 / 4, 15 / 4, 5 / 16, 15 / 16]) / np.pi)
    linear = c1 * wanted[[3, 1, 2]].T
    form = np.zeros((wanted.shape[1], 3, 3))
    form[:, 0, 1] = form[:, 1, 0] = c2 / 2 * wanted[4]
    form[:, 1, 2] = form[:, 2, 1] = c2 / 2 * wanted[5]
    form[:, 0, 2] = form[:, 2, 0] = c2 / 2 * wanted[7]
    form[:, 2, 2] = 3 * c3 * wanted[6]
    form[:, 0, 0], form[:, 1, 1] = c5 * wanted[8], -c5 * wanted[8]
    return linear, form


def _value(linear: Doubles, form: Doubles, normals: Doubles) -> Doubles:
    """Return the quadratic at normals, (p,)."""
    return np.asarray(
        np.einsum("pi,pi->p", linear, normals) + np.einsum("pi,pij,pj->p", normals, form, normals, optimize=True)
    )
