"""Robust photometric stereo under known lamps: shadows left out, highlights explained, pixel by pixel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.calibrated import lit_least_squares
from harmonicface.stereo.glossy import (
    SHARES,
    Lamps,
    before_the_camera,
    products,
    shading,
    shares_of,
    tangents,
)
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.least_squares import scaled_normals

FEWEST = 8  # observations of a pixel: four shares, two angles of the normal, and two to tell the noise by
MIDDLE = (0.3, 0.7)  # ranks among a pixel's observations that neither a shadow nor a highlight reaches
DARKEST = 0.15  # of a pixel's observations are not asked: most of the shadows are among them
SHADOWED = 0.5  # of what is predicted: an observation below is a shadow
OUTLYING = 1.5  # deviations of the residual where an observation has lost half of its weight
RELATIVE = 1e-4  # of a pixel's brightness: residuals below are rounding
ROUNDS = 6
LONGEST = 0.1  # radians a round
NEAR = float(np.cos(np.radians(15)))  # between lamps whose residuals are alike where the mixture is not the truth
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
    problem = _Problem.of(asked, mine, bright.astype(np.float32))
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
        problem = _Problem.of(seen[:, few], directions, bright[:, few] * trust[:, None])
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
    free = used > 3
    noise = np.where(free, residual * np.sqrt(used / np.where(free, used - 3, 1)), np.inf)
    if free.any():
        noise[~free] = np.median(noise[free])
    albedo = np.linalg.norm(scaled, axis=1)
    known = (albedo > 0) & np.isfinite(gain) & np.isfinite(noise)
    error = np.full(len(scaled), np.inf)
    error[known] = np.degrees(np.arctan(noise[known] * gain[known] * np.sqrt(2 / 3) / albedo[known]))
    return error


@dataclass(eq=False)
class _Fit:
    """A mixture at one normal a pixel: pictures (k, n, p), shares (k, p), residuals and weights (n, p)."""

    normals: Doubles
    pictures: NDArray[np.float32]
    shares: Doubles
    rest: Floats
    weights: Floats
    gram: Doubles

    def take(self, better: Mask, other: _Fit) -> None:
        """Become the other fit in some pixels."""
        self.normals[better] = other.normals[better]
        self.pictures[..., better] = other.pictures[..., better]
        self.shares[:, better] = other.shares[:, better]
        self.rest[:, better] = other.rest[:, better]
        self.gram[..., better] = other.gram[..., better]


@dataclass(frozen=True, eq=False)
class _Problem:
    """Observations scaled to a mean of 1, and how much each is asked."""

    seen: NDArray[np.float32]
    scale: Doubles
    asked: NDArray[np.float32]
    lamps: Lamps
    near: NDArray[np.float32]

    @classmethod
    def of(cls, seen: Floats, directions: Doubles, asked: Floats) -> _Problem:
        scale = np.abs(seen).mean(axis=0, dtype=np.float64)
        scale[scale == 0] = 1
        near = directions @ directions.T > NEAR
        return cls(
            (seen / scale).astype(np.float32),
            scale,
            asked.astype(np.float32),
            Lamps.of(directions),
            near.astype(np.float32),
        )

    def fit(self, normals: Doubles, weights: Floats, start: Doubles | None = None) -> _Fit:
        """Return the best mixture at given normals and weights."""
        pictures = shading(normals, self.lamps)
        gram, right = products(pictures, weights, self.seen)
        shares = shares_of(gram, right, start)
        return _Fit(normals, pictures, shares, self._rest(pictures, shares), weights, gram)

    def reweigh(self, fit: _Fit) -> Doubles:
        """Weigh the observations by the residuals of a fit, solve for its shares again, return the deviations."""
        predicted = self.seen - fit.rest
        lit = (self.asked > 0) & (self.seen > SHADOWED * predicted)
        lit = np.where(lit.sum(axis=0) >= FEWEST - 2, lit, self.asked > 0)
        count = lit.sum(axis=0)
        size = np.abs(fit.rest)
        order = np.sort(np.where(lit, size, np.inf), axis=0)
        median = order[np.maximum(count - 1, 0) // 2, np.arange(order.shape[1])]
        deviation = 1.48 * median + RELATIVE
        fit.weights = np.where(lit, self.asked / (1 + (size / (OUTLYING * deviation)) ** 2), np.float32(0))
        fit.gram, right = products(fit.pictures, fit.weights, self.seen)
        fit.shares = shares_of(fit.gram, right, fit.shares)
        fit.rest = self._rest(fit.pictures, fit.shares)
        return np.asarray(deviation, np.float64)

    def best_of(self, starts: list[Doubles]) -> Doubles:
        """Return, pixel by pixel, the start whose mixture leaves the observations explained best."""
        rests, deviations = [], []
        for start in starts:
            fit = self.fit(start, self.asked)
            for _ in range(3):
                deviation = self.reweigh(fit)
            rests.append(fit.rest)
            deviations.append(deviation)
        scale = OUTLYING * np.min(deviations, axis=0) + 0.003
        costs = [np.einsum("np,np->p", self.asked, np.log1p((rest / scale) ** 2)) for rest in rests]
        return np.where((costs[1] < costs[0])[:, None], starts[1], starts[0])

    def refined(self, normals: Doubles) -> tuple[Doubles, Doubles, Doubles, Mask]:
        """Return normals after Gauss-Newton steps, the residual, the standard error in degrees, what was kept."""
        fit = self.fit(normals.copy(), self.asked)
        caution = np.full(len(normals), 1e-2)
        for _ in range(ROUNDS):
            self.reweigh(fit)
            curvature, slope, across = self._curvature(fit)
            trace = np.trace(curvature)
            damped = curvature + (caution * trace + 1e-12) * np.eye(2)[:, :, None]
            step = _solve_two(damped, slope)
            step *= np.minimum(1, LONGEST / np.maximum(np.hypot(*step), 1e-12))
            moved = before_the_camera(fit.normals + step[0][:, None] * across[0] + step[1][:, None] * across[1])
            tried = self.fit(moved, fit.weights, fit.shares)
            better = _cost(tried) < _cost(fit)
            fit.take(better, tried)
            caution = np.where(better, 0.3 * caution, 5 * caution)
        self.reweigh(fit)
        total = fit.weights.sum(axis=0, dtype=np.float64)
        square = _cost(fit) / np.where(total > 0, total, 1.0)
        kept = fit.weights > 0.1 * self.asked
        return fit.normals, np.sqrt(square) * self.scale, self._error(fit, square, kept.sum(axis=0)), kept

    def _error(self, fit: _Fit, square: Doubles, count: NDArray[np.int64]) -> Doubles:
        """Return the standard error of normals in degrees, larger where residuals of lamps that are near are alike."""
        curvature, _, _ = self._curvature(fit)
        determinant = curvature[0, 0] * curvature[1, 1] - curvature[0, 1] ** 2
        known = determinant > 1e-9 * np.trace(curvature) ** 2
        noise = square * count / np.maximum(count - SHARES - 2, 1)
        apart = np.trace(curvature) / np.where(known, determinant, 1.0)
        rest = fit.rest * np.sqrt(fit.weights)
        together = np.einsum("np,np->p", rest, self.near @ rest)
        alone = np.einsum("np,np->p", rest, rest)
        alike = np.maximum(together / np.where(alone > 0, alone, 1.0), 1)
        error = np.full(len(count), np.inf)
        error[known] = np.degrees(np.arctan(np.sqrt((noise * alike * apart)[known])))
        return error

    def _rest(self, pictures: Floats, shares: Doubles) -> NDArray[np.float32]:
        """Return what a mixture leaves of the observations."""
        rest = self.seen.copy()
        for picture, share in zip(pictures, shares.astype(np.float32), strict=True):
            rest -= picture * share
        return rest

    def _curvature(self, fit: _Fit) -> tuple[Doubles, Doubles, tuple[Doubles, Doubles]]:
        """Return half the second derivative of the sum in the normal, shares free, the first, and the directions."""
        across = tangents(fit.normals)
        slopes = [self._slope(fit, direction) for direction in across]
        mixed = np.stack(
            [[np.einsum("np,np,np->p", fit.weights, picture, s) for s in slopes] for picture in fit.pictures]
        ).astype(np.float64)
        own = np.stack([[np.einsum("np,np,np->p", fit.weights, s, t) for t in slopes] for s in slopes])
        slope = np.stack([np.einsum("np,np,np->p", fit.weights, s, fit.rest) for s in slopes]).astype(np.float64)
        active = fit.shares > 1e-9 * fit.shares.max(axis=0)
        gram = np.moveaxis(fit.gram * active[:, None] * active[None], 2, 0) + np.eye(SHARES) * ~active.T[:, None]
        mixed = np.moveaxis(mixed * active[:, None], 2, 0)
        freed = np.moveaxis(np.swapaxes(mixed, 1, 2) @ np.linalg.solve(gram, mixed), 0, 2)
        return own.astype(np.float64) - freed, slope, across

    def _slope(self, fit: _Fit, direction: Doubles, size: float = 1e-2) -> NDArray[np.float32]:
        """Return how fast what the mixture shows changes when the normals turn, (n, p)."""
        change = np.zeros_like(self.seen)
        for sign in (0.5, -0.5):
            turned = fit.normals + sign * size * direction
            turned /= np.linalg.norm(turned, axis=1, keepdims=True)
            for picture, share in zip(shading(turned, self.lamps), fit.shares.astype(np.float32), strict=True):
                change += np.float32(2 * sign / size) * picture * share
        return change


def _cost(fit: _Fit) -> Doubles:
    """Return the weighted sum of squares."""
    return np.asarray(np.einsum("np,np,np->p", fit.weights, fit.rest, fit.rest), np.float64)


def _solve_two(matrix: Doubles, right: Doubles) -> Doubles:
    """Solve 2 x 2 systems, (2, 2, p) and (2, p)."""
    (a, b), (_, d) = matrix
    determinant = a * d - b * b
    inverse = np.divide(1, determinant, out=np.zeros_like(determinant), where=determinant > 0)
    return np.stack([(d * right[0] - b * right[1]) * inverse, (a * right[1] - b * right[0]) * inverse])
