"""Light model: how many numbers a photograph's light needs, 3, 4 or 9, by the noise of the photographs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.factors import Factors, leading_factors
from harmonicface.stereo.result import Model

MODELS: dict[Model, int] = {"linear3": 3, "ambient4": 4, "harmonic9": 9}
EXPLAINED = 1.3  # times the noise: a residual that is noise, and a little more
BLACK = 0.02  # of a photograph's white, its 99th percentile: what is darker has no light
BLACK_SHARE = 0.03  # of the observations: shadows of lamps are black (6 to 20 %), those under a sky are not (below 1 %)
MOST_FACTORS = 12  # what is beyond them is noise or sharp shadows
SPARE = 3  # photographs more than a model has numbers: fewer can be explained by it whatever they show

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class LightModel:
    """The smallest light model that explains some photographs.

    Parameters
    ----------
    model
        "linear3" (distant lamps), "ambient4" (first order) or "harmonic9" (second order).
    reason
        One sentence, why this and no smaller one.
    noise
        Standard deviation of the photographs' noise.
    residuals
        Root mean square that the models leave, by name, of those that the number of photographs allows.
    """

    model: Model
    reason: str
    noise: float
    residuals: dict[Model, float]


def choose_light_model(pixels: Floats, mask: Mask, noise: float | None = None) -> LightModel:
    """Choose the smallest model of light that explains photographs to their noise.

    The factors of n photographs of a matte surface are 3 under distant lamps without shadows (Shashua 1997), 4 with
    ambient light or under any light to first order, 9 to second order (Basri & Jacobs 2003). The residual of the best
    approximation by so many factors is compared with the noise, which shows where neighbouring pixels differ more
    than any surface does. Where none explains them, as with cast shadows, it is lamps if 3 % of all observations
    are black, otherwise the largest model for which there are photographs.

    The names are those of `appearance.choose.choose_model`, and so is the rule, the cheapest that meets a tolerance. Of
    a known Surface it predicts the errors; here the Surface is what is asked for, the errors are measured, and the
    tolerance is the noise.

    Parameters
    ----------
    pixels
        (n, p) intensities of the masked pixels, n of at least 3.
    mask
        (h, w) booleans with p pixels.
    noise
        Standard deviation of the photographs' noise, where it is known.

    Raises
    ------
    HarmonicFaceError
        Another shape, fewer than 3 photographs, noise that is not above 0, NaN.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> lamps, scaled_normals = rng.uniform(0.2, 1, (8, 3)), rng.uniform(0.2, 1, (3, 400))
    >>> photographs = lamps @ scaled_normals + 0.01 * rng.normal(size=(8, 400))
    >>> choose_light_model(photographs, np.ones((20, 20), bool)).model
    'linear3'
    """
    observations = _validate.floats(pixels, "pixels")
    if observations.ndim != 2 or len(observations) < 3 or observations.shape[1] != mask.sum():
        raise HarmonicFaceError(
            f"pixels: expected at least 3 photographs of the {mask.sum()} pixels of the mask, "
            f"got {_validate.describe(observations)}"
        )
    factors = leading_factors(observations, min(len(observations), MOST_FACTORS))
    spread = photograph_noise(observations, factors, mask) if noise is None else _validate.positive(noise, "noise")
    allowed = [name for name, size in MODELS.items() if size == 3 or len(observations) >= size + SPARE]
    residuals = {name: factors.residual(MODELS[name]) for name in allowed}
    for name in allowed:
        size = MODELS[name]
        share = np.sqrt(max(len(observations) - size, 0) / len(observations))  # of the noise that no factor takes
        if residuals[name] <= EXPLAINED * spread * share + 1e-12 * factors.singular_values[0]:
            reason = f"{size} numbers a light leave {residuals[name]:.2g}, the noise is {spread:.2g}"
            smaller = [f"{MODELS[other]} leave {residuals[other]:.2g}" for other in allowed[: allowed.index(name)]]
            return LightModel(name, ", ".join([reason, *smaller]), spread, residuals)
    white = np.percentile(np.abs(observations), 99, axis=1, keepdims=True)
    black = float((np.abs(observations) < BLACK * white).mean())
    if black > BLACK_SHARE:
        reason = f"{black:.0%} of the observations are black, as shadows of lamps are and those under a sky are not"
        return LightModel("linear3", reason, spread, residuals)
    name = allowed[-1]
    left = ", ".join(f"{MODELS[other]} numbers leave {residuals[other]:.2g}" for other in allowed)
    reason = f"no model explains the photographs to their noise of {spread:.2g} ({left}), as with cast shadows"
    if name != "harmonic9":
        reason += f"; more than {MODELS[name]} numbers a light need more than {len(observations)} photographs"
    return LightModel(name, reason, spread, residuals)


def photograph_noise(pixels: Floats, factors: Factors, mask: Mask) -> float:
    """Return the standard deviation of noise that is not alike in neighbouring pixels.

    What the leading factors leave is noise and what the surface does sharply; second differences along rows, of
    which the median counts, keep the noise alone.
    """
    grid = np.zeros(mask.shape)
    inside = mask[:, 1:-1] & mask[:, :-2] & mask[:, 2:]
    if not inside.any() or factors.right is None:
        return factors.residual(factors.rank)
    used = min(factors.rank, max(len(pixels) // 2, 1))  # more would take too much of the noise with them
    spreads = []
    for photograph, amounts in zip(pixels, factors.left[:, :used], strict=True):
        grid[mask] = photograph - amounts @ factors.right[:used]
        second = (grid[:, :-2] - 2 * grid[:, 1:-1] + grid[:, 2:])[inside]
        spreads.append(float(np.median(np.abs(second))) / (0.6745 * np.sqrt(6)))
    lost = np.sqrt(len(pixels) / max(len(pixels) - used, 1))  # noise that the factors took with them
    return float(np.sqrt(np.mean(np.square(spreads))) * lost)
