"""Robust photometric stereo under known lamps: shadows left out, highlights explained, pixel by pixel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.known.calibrated import lit_least_squares
from harmonicface.stereo.known.glossy import Lamps, before_the_camera, shading
from harmonicface.stereo.known.least_squares import noise_of, scaled_normals
from harmonicface.stereo.known.mixtures import FEWEST, Mixtures

MIDDLE = (0.3, 0.7)  # ranks among a pixel's observations that neither a shadow nor a highlight reaches
DARKEST = 0.15  # of a pixel's observations are not asked: most of the shadows are among them
DIM = 0.1  # of the median brightness: photographs under dimmer lamps weigh less, their noise is magnified
CHUNK = 1 << 17  # observations at a time: what is computed of them stays in the processor's cache

Mask = NDArray[np.bool_]
Doubles = NDArray[np.float64]


def robust_normals(
    observations: Floats,
    lights: Floats,
    saturation: float = np.inf,
    usable: Mask | None = None,
    tell: Callable[[int, int], None] = lambda *_: None,
) -> Pixels:
    r"""Find normals and albedo of glossy, partly shadowed pixels under known distant lamps.

    A pixel's observations, divided by the lamps' brightness, are those of a mixture of a matte surface and three
    lobes of microfacets (`shading`), with shares c of at least 0:

    .. math:: \min_{n, c \ge 0} \sum_i w_i \Bigl( I_i - \sum_k c_k f_k(n, l_i) \Bigr)^2

    The weights leave out the darkest 15 % of a pixel's observations and those that show less than half of what the
    mixture predicts (shadows, attached or cast), and let Cauchy's function of the residual over its median judge the
    rest. Two starts are tried and the one that explains more is taken: least squares over the observations of middle
    rank, from 0.3 to 0.7, which neither shadows nor highlights reach (after Shi, Tan, Matsushita & Ikeuchi,
    Bi-Polynomial Modeling of Low-Frequency Reflectances, 2014, which trims both ends too), and over those that are lit
    (`calibrated_stereo`). From there on the normal follows by Gauss-Newton steps across which the shares are solved for
    (variable projection), and no step is taken that raises the sum. Mixing known lobes was shown to be worth more than
    free polynomials by Hui & Sankaranarayanan, Shape and Spatially-Varying Reflectance Estimation from Virtual
    Exemplars, 2017.

    A pixel with fewer than 8 observations that can be used is solved as matte from those in which it is lit.
    Interreflections are not modelled, nor are lamps behind the surface that shine through it.

    Parameters
    ----------
    observations
        (n, p) linear grey intensities.
    lights
        (n, 3) directions to the lamps times their brightness, none of length 0, spanning space.
    saturation
        Observations that reach it are left out.
    usable
        (n, p) booleans, false for other observations to leave out.
    tell
        Is told how many pixels are done, of how many.

    Returns
    -------
    Pixels
        `scaled` is the normal times the albedo of the matte surface that explains the observations of middle rank
        best at that normal. `confidence` is the normal's standard error in degrees where the mixture is the truth,
        from the residual and the curvature of the sum with the shares free. Where a pixel was solved as matte and its
        lit observations do not determine it: infinity. `used` counts observations that kept a tenth of their weight.

    Examples
    --------
    >>> lamps = np.array([[np.sin(a), np.cos(a), 1.2] for a in np.arange(12.0)])
    >>> lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    >>> normal = np.array([[0.48, 0.0, 0.8772685]])
    >>> seen = 0.5 * shading(normal, Lamps.of(lamps))[0] + 0.2 * shading(normal, Lamps.of(lamps))[2]
    >>> found = robust_normals(seen, lamps)
    >>> (found.scaled / np.linalg.norm(found.scaled)).round(2) + 0.0
    array([[0.48, 0.  , 0.88]])
    """
    brightness = np.linalg.norm(lights, axis=1)
    directions, pixels = lights / brightness[:, None], observations.shape[1]
    trust = np.minimum((brightness / (DIM * np.median(brightness))) ** 2, 1)
    step = max(CHUNK // len(lights), 1)
    parts = []
    for start in range(0, pixels, step):
        part = observations[:, start : start + step]
        allowed = part < saturation
        if usable is not None:
            allowed &= usable[:, start : start + step]
        seen = part / brightness[:, None].astype(part.dtype)
        parts.append(_solve(seen, directions, allowed, trust))
        tell(min(start + step, pixels), pixels)
    return Pixels(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def unexplained(observations: Floats, lights: Floats, kept: Mask, usable: Mask | None = None) -> NDArray[np.float32]:
    """Return what the mixtures that explain the kept photographs leave of all, over each pixel's mean brightness.

    Parameters
    ----------
    observations
        (n, p) linear grey intensities.
    lights
        (n, 3) directions to the lamps times their brightness.
    kept
        (n,) booleans, the photographs that the mixtures are fitted to: at least 8.
    usable
        (n, p) booleans, false for observations that the mixtures are not fitted to.

    Returns
    -------
    array
        (n, p) float32.
    """
    brightness = np.linalg.norm(lights, axis=1)
    directions = lights / brightness[:, None]
    seen = observations.astype(np.float64) / brightness[:, None]
    asked, mine = seen[kept], directions[kept]
    allowed = np.ones(asked.shape, bool) if usable is None else usable[kept]
    middle, bright = _ranks(asked, allowed)
    problem = Mixtures.of(asked, mine, bright.astype(np.float32))
    starts = lit_least_squares(asked, mine, allowed)[0], _middle_normals(asked, mine, middle)
    fit = problem.fit(problem.refined(problem.best_of([before_the_camera(b) for b in starts]))[0], problem.asked)
    for _ in range(3):
        problem.reweigh(fit)
    rest: NDArray[np.float32] = (seen / problem.scale).astype(np.float32)
    for picture, share in zip(shading(fit.normals, Lamps.of(directions)), fit.shares, strict=True):
        rest -= picture * share.astype(np.float32)
    return rest


def _solve(seen: Floats, directions: Doubles, allowed: Mask, trust: Doubles) -> tuple[NDArray[Any], ...]:
    """Solve (n, p) observations under lamps of brightness 1: what `Pixels` holds."""
    exact = seen.astype(np.float64)
    scaled, residual, used, determined = lit_least_squares(exact, directions, allowed)
    error = matte_error(scaled, directions, residual, used)
    error[~determined] = np.inf
    middle, bright = _ranks(exact, allowed)
    glossy = (bright.sum(axis=0) >= FEWEST) & (exact.max(axis=0) > 0)
    if glossy.any():
        few = np.flatnonzero(glossy)
        starts = scaled[few], _middle_normals(exact[:, few], directions, middle[:, few])
        problem = Mixtures.of(seen[:, few], directions, bright[:, few] * trust[:, None])
        normals = problem.best_of([before_the_camera(start) for start in starts])
        normals, residual[few], error[few], kept = problem.refined(normals)
        used[few] = kept.sum(axis=0)
        scaled[few] = normals * _albedo(exact[:, few], directions, kept & middle[:, few], normals)[:, None]
    return scaled, residual, error, used


def _ranks(seen: Floats, allowed: Mask) -> tuple[Mask, Mask]:
    """Return which observations have a middle rank in their pixel, and which are not among its darkest."""
    count = allowed.sum(axis=0)
    order = np.sort(np.where(allowed, seen, np.inf), axis=0)
    columns, last = np.arange(seen.shape[1]), np.maximum(count - 1, 0)

    def at(rank: float, up: bool) -> Floats:
        place = np.ceil(rank * last - 1e-9) if up else np.floor(rank * last + 1e-9)
        return np.asarray(order[place.astype(np.intp), columns])

    middle = allowed & (seen >= at(MIDDLE[0], True)) & (seen <= at(MIDDLE[1], False))
    return middle, allowed & (seen >= at(DARKEST, True))


def _middle_normals(seen: Doubles, directions: Doubles, middle: Mask) -> Doubles:
    """Return least squares over observations of middle rank, with a trace of all where those do not span space."""
    return scaled_normals(seen, directions, middle + 1e-6)[0]


def _albedo(seen: Doubles, directions: Doubles, middle: Mask, normals: Doubles) -> Doubles:
    """Return by what a matte surface of these normals is to be multiplied to show the observations of middle rank."""
    matte = np.maximum(directions @ normals.T, 0) * middle
    square = np.einsum("np,np->p", matte, matte)
    whole = np.einsum("np,np->p", seen, matte)
    rough = np.abs(seen).mean(axis=0)  # of a normal that the lamps of middle rank do not reach
    return np.asarray(np.where((square > 0) & (whole > 0), whole / np.where(square > 0, square, 1.0), rough))


def matte_error(scaled: Doubles, directions: Doubles, residual: Doubles, used: NDArray[Any]) -> Doubles:
    """Return the standard error in degrees of normals by least squares over the lamps before the surface."""
    gain = scaled_normals(np.zeros((len(directions), len(scaled))), directions, directions @ scaled.T > 0)[1]
    noise = noise_of(residual, used)
    albedo = np.linalg.norm(scaled, axis=1)
    known = (albedo > 0) & np.isfinite(gain) & np.isfinite(noise)
    error = np.full(len(scaled), np.inf)
    error[known] = np.degrees(np.arctan(noise[known] * gain[known] * np.sqrt(2 / 3) / albedo[known]))
    return error
