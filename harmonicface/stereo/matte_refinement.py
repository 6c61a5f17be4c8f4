"""Refinement of normals, albedo and lamps together: a robust cost that each round lowers, in the frame of its start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.hayakawa import lights_of
from harmonicface.stereo.least_squares import scaled_normals

Doubles = NDArray[np.float64]

ROUNDS = 30
SETTLED = 1e-4  # of the cost, by which a round still lowers it
SAMPLE = 8000  # pixels that tell the lights
LEAST_RESIDUAL = 1e-4  # of the mean intensity: the scale of the loss for photographs without noise


@dataclass(frozen=True, eq=False)
class Refined:
    """Lights and scaled normals, and what they cost before and after.

    Parameters
    ----------
    lights
        (n, 3), in the frame of the start.
    scaled
        (p, 3).
    costs
        The cost at the start and after each round, on the pixels that told the lights; it never rises.
    """

    lights: Doubles
    scaled: Doubles
    costs: list[float]


def refined(observations: Floats, lights: Doubles, scaled: Doubles, weights: Floats) -> Refined:
    r"""Lower the cost of photographs of a matte surface over its normals, its albedo and the lamps.

    .. math:: E(l, b) = \sum_{ip} w_{ip} \, \sigma^2 \log\left(1 + (I_{ip} - l_i \cdot b_p)^2 / \sigma^2\right)

    with Cauchy's loss, so that what remains of shadows and highlights among the observations counts little. By
    reweighted least squares over b and l in turn: the loss lies under the parabola that touches it, so no step can
    raise E, and a round that does by rounding is taken back. E does not see a matrix between l and b; it is fixed
    by keeping the frame of the start: after all rounds l is turned back to it by linear least squares.

    Parameters
    ----------
    observations
        (n, p) intensities.
    lights, scaled
        (n, 3) and (p, 3), the start.
    weights
        (n, p) of at least 0: which observations count.

    Examples
    --------
    >>> random = np.random.default_rng(0)
    >>> lights, scaled = random.uniform(0.2, 1, (9, 3)), random.uniform(0.2, 1, (40, 3))
    >>> images = lights @ scaled.T
    >>> found = refined(images, lights * random.uniform(0.98, 1.02, (9, 1)), scaled, np.ones_like(images))
    >>> found.costs[-1] < 1e-3 * found.costs[0]
    True
    """
    chosen = slice(None) if len(scaled) <= SAMPLE else np.linspace(0, len(scaled) - 1, SAMPLE).astype(int)
    seen, trust = observations[:, chosen].astype(np.float64), weights[:, chosen].astype(np.float64)
    known = trust > 0
    rest = np.abs(seen - lights @ scaled[chosen].T)[known]
    scale = max(1.4826 * float(np.median(rest)), LEAST_RESIDUAL * float(np.abs(seen).mean()))

    def cost(lamps: Doubles, normals: Doubles) -> float:
        return float((trust * np.log1p(((seen - lamps @ normals.T) / scale) ** 2)).sum() * scale**2)

    def reweighted(lamps: Doubles, normals: Doubles) -> Doubles:
        return np.asarray(trust / (1 + ((seen - lamps @ normals.T) / scale) ** 2))

    lamps, normals = lights, scaled[chosen]
    costs = [cost(lamps, normals)]
    for _ in range(ROUNDS):
        again = scaled_normals(seen, lamps, reweighted(lamps, normals))[0]
        moved = lights_of(seen, again, reweighted(lamps, again))
        now = cost(moved, again)
        if not now < costs[-1]:
            break
        lamps, normals = moved, again
        costs.append(now)
        if costs[-2] - now < SETTLED * now:
            break
    if len(costs) == 1:
        return Refined(lights, scaled, costs)
    lamps = lamps @ np.linalg.lstsq(lamps, lights, rcond=None)[0]
    found = scaled
    for _ in range(3):
        rest = (observations - lamps @ found.T) / scale
        found = scaled_normals(observations, lamps, weights / (1 + rest**2))[0]
    return Refined(lamps, found, costs)
