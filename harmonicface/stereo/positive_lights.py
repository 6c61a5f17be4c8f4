"""Positive lights: the radiance of sky cells behind each photograph, nowhere negative, and the albedo with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from harmonicface._validate import Floats

RIDGE = 1e-6  # of the mean square of a cell's shades: cells that nothing tells apart share the light
BRIGHT_ENOUGH = 1e-3  # of the best lit cell: cells behind the surface have no radiance
DARKEST = 1e-3  # albedo, of its mean

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PositiveLights:
    """Lights and albedo that explain photographs of a known shape.

    Parameters
    ----------
    radiance
        (n, cells) of at least 0.
    albedo
        (p,) above 0, in units of the photographs over the irradiance.
    irradiance
        (n, p): photographs are about `albedo * irradiance`.
    active
        (n, cells) booleans, cells whose radiance is above 0.
    """

    radiance: Doubles
    albedo: Doubles
    irradiance: Doubles
    active: Mask


def positive_lights(
    photographs: Floats,
    shades: Floats,
    albedo: Floats,
    weights: Floats | None = None,
    active: Mask | None = None,
    rounds: int = 1,
) -> PositiveLights:
    r"""Fit the radiance of sky cells to photographs, and the albedo to the light, turn by turn.

    .. math:: \min_{L \ge 0} \sum_x \rho_x^2 (I_x / \rho_x - (L S)_x)^2, \qquad
              \rho_x = \frac{\sum_i w_{ix} I_{ix} (L S)_{ix}}{\sum_i w_{ix} (L S)_{ix}^2}

    Parameters
    ----------
    photographs
        (n, p) intensities.
    shades
        (cells, p) irradiance of each pixel per radiance of a cell.
    albedo
        (p,) to start from.
    weights
        (n, p) trust for the albedo, all 1 by default.
    active
        Which radiances are above 0, if that is known: then there is nothing to search for, and the fit is smooth in
        the shades.
    rounds
        How often lights and albedo are fitted.
    """
    scale = np.sqrt(np.einsum("cp,cp->c", shades, shades, dtype=np.float64) / shades.shape[1])
    known = scale > BRIGHT_ENOUGH * scale.max()
    unit = shades[known].astype(np.float64) / scale[known, None]
    trusted = photographs if weights is None else weights * photographs
    chosen = None if active is None else active[:, known]
    for _ in range(rounds):
        lit = unit * albedo
        gram = lit @ lit.T
        gram[np.diag_indices_from(gram)] += RIDGE * np.trace(gram) / len(gram)
        right = photographs @ lit.T
        found = _searched(gram, right) if chosen is None else _solved(gram, right, chosen)
        irradiance = found @ unit
        power = np.einsum("np,np->p", irradiance, irradiance if weights is None else weights * irradiance)
        albedo = np.einsum("np,np->p", trusted, irradiance) / np.maximum(power, 1e-12 * (power.max() or 1.0))
        albedo = np.maximum(albedo, DARKEST * abs(albedo.mean()) or DARKEST)
    radiance = np.zeros((len(photographs), len(shades)))
    radiance[:, known] = found / scale[known]
    return PositiveLights(radiance, albedo.astype(np.float64), irradiance, radiance > 0)


def _searched(gram: Doubles, right: Doubles) -> Doubles:
    """Solve each photograph's normal equations with radiances of at least 0 (Lawson & Hanson 1974)."""
    factor = np.linalg.cholesky(gram).T
    targets = np.linalg.solve(factor.T, right.T).T
    return np.stack([nnls(factor, target, maxiter=30 * len(gram))[0] for target in targets])


def _solved(gram: Doubles, right: Doubles, active: Mask) -> Doubles:
    """Solve each photograph's normal equations for the chosen radiances alone."""
    found = np.zeros(right.shape)
    for row, target, some in zip(found, right, active, strict=True):
        index = np.flatnonzero(some)
        row[index] = np.linalg.solve(gram[np.ix_(index, index)], target[index])
    return found
