"""Lamps in one plane: two factors explain what is lit, and a third one would be made of shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.lamps.matte_refinement import Refined

Doubles = NDArray[np.float64]

FEWEST = 6  # photographs, for two factors to leave something over
SAMPLE = 3000  # pixels
ROUNDS = 25
WORSE = (
    1.8  # residual of two factors over that of three: renderings of lamps in a plane stay below 1.4, others above 2.9
)


def check_plane(observations: Floats, found: Refined, weights: Floats) -> None:
    """Refuse photographs that two factors explain as well as three: attached shadows alone made the third.

    Both residuals are medians over the observations that count, after reweighting with a Cauchy loss.

    Parameters
    ----------
    observations
        (n, p) intensities.
    found
        Three factors of them.
    weights
        (n, p) of at least 0: which observations count.

    Raises
    ------
    HarmonicFaceError
        Lamps in one plane, or normals in one (a cylinder).
    """
    if len(observations) < FEWEST:
        return
    chosen = np.linspace(0, observations.shape[1] - 1, min(SAMPLE, observations.shape[1])).astype(int)
    seen, trust = observations[:, chosen].astype(np.float64), weights[:, chosen].astype(np.float64)
    least = 1e-6 * float(np.abs(seen).mean())
    three = max(float(np.median(np.abs(seen - found.lights @ found.scaled[chosen].T)[trust > 0])), least)
    two = _residual_of_two(seen, trust, least)
    if two < WORSE * three:
        raise HarmonicFaceError(
            "images: expected unknown lamps from directions that span space on a surface curved both ways, got"
            f" photographs that two factors explain nearly as well as three (residual {two / three:.2f} times as"
            f" large, at least {WORSE:g}): lamps in one plane, or a cylinder"
        )


def _residual_of_two(seen: Doubles, trust: Doubles, least: float) -> float:
    """Return the median residual of the best two factors, found in turn under a Cauchy loss."""
    lights = np.linalg.svd(seen, full_matrices=False)[0][:, :2]
    weights, middle = trust, least
    for _ in range(ROUNDS):
        scaled = _fitted(lights, weights, seen)
        lights = np.linalg.qr(_fitted(scaled, weights.T, seen.T))[0]
        rest = np.abs(seen - lights @ _fitted(lights, weights, seen).T)
        middle = max(float(np.median(rest[trust > 0])), least)
        weights = trust / (1 + (rest / (1.4826 * middle)) ** 2)
    return middle


def _fitted(known: Doubles, weights: Doubles, seen: Doubles) -> Doubles:
    """Return the (p, 2) factors that explain (n, p) numbers best by known (n, 2) ones, by weighted least squares."""
    first, second = known.T
    xx, xy, yy = (first * first) @ weights, (first * second) @ weights, (second * second) @ weights
    x, y = known.T @ (weights * seen)
    determinant = xx * yy - xy * xy + 1e-9 * (xx + yy) ** 2 + 1e-300
    return np.stack([(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant], axis=1)
