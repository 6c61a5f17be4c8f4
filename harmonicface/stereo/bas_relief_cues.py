"""What resolves the bas-relief ambiguity: evidence on tilt and relief, each with its standard error, pooled by them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from harmonicface._validate import Floats
from harmonicface.stereo.bas_relief import bas_relief, relief_of_equal_lamps

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

# All of these were chosen on renderings of heads and made-up shapes, matte and glossy, with cast shadows.
DISTANCES = (0.01, 0.1)  # between neighbours that may have the same albedo, over the root of the mask's area
ALBEDO_SCALE = 0.03  # of the Cauchy loss on logarithms of albedo: beyond lies the edge of a patch
PAIRS, REGIONS = 8000, 5
ALBEDO_BIAS, ALBEDO_ERROR = 0.08, (0.08, 0.08, 0.12)  # a coat brightens what faces the camera: relief comes out deep
OBSERVATIONS, BRIGHTEST = 30_000, 0.01  # of them those that stand out most from the matte model
GLOSS_BIAS, GLOSS_ERROR = -0.07, (0.05, 0.05, 0.08)  # a lobe is not centred on the bisector: relief comes out flat
SHARP, DULLING = -3.5, 1.5  # a score from which highlights are clear, and how fast their error grows above it
EQUAL = 0.1  # of brightness: lamps that can be made as equal as that are equal
LEAST_EQUAL = 10  # lamps: fewer may be made equal by chance
LAMPS_ERROR = 0.05  # of a surface that is not matte, whatever the lamps
USUAL, USUAL_ERROR = (0.0, 0.0, 0.3), (0.2, 0.2, 0.25)  # tilt and relief of things that are seen whole, from the front
FARTHEST = 1.5  # of any parameter, from the upright frame

Cost = Callable[[Doubles], float]


@dataclass(frozen=True, eq=False)
class Cue:
    """Evidence on a bas-relief transformation of an upright frame.

    Parameters
    ----------
    name
        What it is from.
    relief
        (3,) mu, nu and the logarithm of the stretch.
    deviations
        (3,) their standard errors, with what it is known to be wrong by on surfaces that are not matte.
    """

    name: str
    relief: Doubles
    deviations: Doubles


def matrix_of(relief: Doubles) -> Doubles:
    """Return the bas-relief matrix of (mu, nu, logarithm of the stretch)."""
    return bas_relief(relief[0], relief[1], float(np.exp(relief[2])))


def pooled(cues: Sequence[Cue]) -> Cue:
    """Return the mean of cues by the inverse squares of their errors; errors grow where the cues contradict each other.

    Examples
    --------
    >>> one, two = Cue("one", np.zeros(3), np.ones(3)), Cue("two", np.full(3, 0.3), np.full(3, 0.5))
    >>> pooled([one, two]).relief.round(2), pooled([one, two]).deviations.round(2)
    (array([0.24, 0.24, 0.24]), array([0.45, 0.45, 0.45]))
    """
    values = np.stack([cue.relief for cue in cues])
    precision = np.stack([cue.deviations**-2.0 for cue in cues])
    mean = (precision * values).sum(axis=0) / precision.sum(axis=0)
    contradiction = (precision * (values - mean) ** 2).sum(axis=0) / max(len(cues) - 1, 1)
    deviations = np.sqrt(np.maximum(contradiction, 1.0) / precision.sum(axis=0))
    return Cue(", ".join(cue.name for cue in cues), mean, deviations)


def usual() -> Cue:
    """Return what is known of anything: it is seen from the front, and neither flat nor long."""
    return Cue("the usual relief", np.array(USUAL), np.array(USUAL_ERROR))


def equal_albedo(scaled: Doubles, mask: Mask, seed: int = 0) -> Cue:
    r"""Return the relief in which neighbours have the same albedo most often.

    :math:`\sum \rho(\log |G b_p| - \log |G b_q|)` over pairs of pixels p and q, with a Cauchy loss. Where albedo does
    not change, b stands still along itself exactly where a lamp straight before the surface shows its maximum: these
    are the diffuse maxima of Papadhimitri & Favaro (A closed-form, consistent and robust solution to uncalibrated
    photometric stereo via local diffuse reflectance maxima, 2014), from all pixels instead of some.

    Parameters
    ----------
    scaled
        (p, 3) scaled normals in an upright frame.
    mask
        (h, w) booleans.
    seed
        Of the pairs.
    """
    first, second, region = _neighbours(mask, seed)
    lengths = np.linalg.norm(scaled, axis=1)
    black = lengths < 1e-6 * np.median(lengths)
    kept = ~(black[first] | black[second])
    first, second, region = first[kept], second[kept], region[kept]

    def cost_of(chosen: NDArray[np.bool_]) -> Cost:
        one, other = scaled[first[chosen]], scaled[second[chosen]]

        def cost(relief: Doubles) -> float:
            frame = matrix_of(relief).T
            squares = [np.einsum("pk,pk->p", b, b) for b in (one @ frame, other @ frame)]
            ratio = np.log(squares[0] / squares[1]) / 2
            return float(np.log1p((ratio / ALBEDO_SCALE) ** 2).mean())

        return cost

    best = _least(cost_of(np.ones(len(first), bool)), np.array(USUAL))
    others = np.stack([_least(cost_of(region != left_out), best, (0.0,)) for left_out in np.unique(region)])
    count = len(others)
    jackknife = (count - 1) / count * ((others - others.mean(axis=0)) ** 2).sum(axis=0)
    deviations = np.sqrt(jackknife + np.square(ALBEDO_ERROR))
    return Cue("equal albedo of neighbours", best - np.array([0, 0, ALBEDO_BIAS]), deviations)


def highlights(observations: Floats, lights: Doubles, scaled: Doubles, start: Doubles, seed: int = 0) -> Cue:
    """Return the relief in which highlights are where normals bisect the directions to the lamp and the camera.

    Of all lit observations those that exceed the matte model most should have the least angles between normal and
    bisector (Drbohlav & Sara, Specularities reduce ambiguity of uncalibrated photometric stereo, 2002): the score is
    the mean logarithm of the share of observations with a smaller angle, plus 1. It is 0 by chance and about -4 on
    glossy things; the error grows accordingly.

    Parameters
    ----------
    observations
        (n, p) intensities.
    lights, scaled
        (n, 3) and (p, 3) in an upright frame.
    start
        (3,) relief from which the search starts.
    seed
        Of the sample of pixels.
    """
    random = np.random.default_rng(seed)
    chosen = random.permutation(len(scaled))[: max(OBSERVATIONS // len(lights), 1)]
    normals = scaled[chosen]
    matte = lights @ normals.T
    seen = observations[:, chosen]
    lit = (matte > 0.15 * np.median(matte)) & (seen > 0.5 * matte)
    lamp, pixel = np.nonzero(lit)
    excess = (seen - matte)[lit]
    if len(excess) < 1 / BRIGHTEST:
        return Cue("highlights", start, np.full(3, 1e3))

    def score(relief: Doubles) -> float:
        frame = matrix_of(relief)
        turned = normals @ frame.T
        turned /= np.linalg.norm(turned, axis=1)[:, None] + 1e-300
        towards = lights @ np.linalg.inv(frame)
        brightness = np.linalg.norm(towards, axis=1) + 1e-300
        bisectors = towards / brightness[:, None] + [0, 0, 1]
        bisectors /= np.linalg.norm(bisectors, axis=1)[:, None] + 1e-300
        cosines = (bisectors @ turned.T)[lamp, pixel]
        shine = excess / brightness[lamp]
        rank = int(len(shine) * (1 - BRIGHTEST))
        brightest = cosines[shine >= np.partition(shine, rank)[rank]]
        smaller = 1 - np.searchsorted(np.sort(cosines), brightest) / len(cosines)
        return float(np.log(smaller).mean()) + 1

    best = _least(score, start, (0.0,))
    doubt = float(np.exp(min(DULLING * max(score(best) - SHARP, 0.0), 20.0)))
    return Cue("highlights", best - np.array([0, 0, GLOSS_BIAS]), doubt * np.array(GLOSS_ERROR))


def equal_lamps(lights: Doubles) -> Cue | None:
    """Return the relief in which lamps are equally bright, if there is one: equal by chance they would hardly be."""
    cue = known_lamps(lights)
    brightness = np.linalg.norm(lights @ np.linalg.inv(matrix_of(cue.relief)), axis=1)
    spread = 1.4826 * np.median(np.abs(np.log(brightness / np.median(brightness))))
    return cue if len(lights) >= LEAST_EQUAL and spread < EQUAL else None


def known_lamps(lights: Doubles) -> Cue:
    """Return the relief in which lamps that are known to be equally bright are."""
    frame, deviations = relief_of_equal_lamps(lights)
    upright = frame / frame[2, 2]
    relief = np.array([-upright[0, 2], -upright[1, 2], np.log(upright[0, 0])])
    return Cue("equal lamps", relief, deviations + LAMPS_ERROR)


def _neighbours(mask: Mask, seed: int) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of pixels by index, and the region of the mask in which each pair lies."""
    random = np.random.default_rng(seed)
    index = np.full(mask.shape, -1)
    index[mask] = np.arange(mask.sum())
    rows, columns = np.nonzero(mask)
    first = random.integers(0, len(rows), PAIRS)
    size = np.sqrt(len(rows))
    distance = np.maximum(size * np.exp(random.uniform(np.log(DISTANCES[0]), np.log(DISTANCES[1]), PAIRS)), 1.0)
    angle = random.uniform(0, 2 * np.pi, PAIRS)
    down = np.clip(np.round(rows[first] + distance * np.sin(angle)).astype(int), 0, mask.shape[0] - 1)
    right = np.clip(np.round(columns[first] + distance * np.cos(angle)).astype(int), 0, mask.shape[1] - 1)
    second = index[down, right]
    kept = (second >= 0) & (second != first)
    first, second = first[kept], second[kept]
    around = np.arctan2(rows[first] - rows.mean(), columns[first] - columns.mean())
    return first, second, np.floor((around + np.pi) / (2 * np.pi) * REGIONS * 0.999999).astype(np.intp)


def _least(cost: Cost, start: Doubles, stretches: tuple[float, ...] = (-0.5, 0.0, 0.5)) -> Doubles:
    """Return the relief of least cost, within bounds, from starts of some stretches."""
    best, least = start, np.inf
    for stretch in stretches:
        middle = start + np.array([0, 0, stretch])
        simplex = middle + np.vstack([np.zeros(3), np.diag([0.15, 0.15, 0.2])])
        options = {"initial_simplex": simplex, "xatol": 2e-3, "fatol": 1e-6, "maxiter": 200}
        bounds = [(-FARTHEST, FARTHEST)] * 3
        found = minimize(cost, middle, method="Nelder-Mead", bounds=bounds, options=options)
        if found.fun < least:
            best, least = found.x, found.fun
    return np.asarray(best)
