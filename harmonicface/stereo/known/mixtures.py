"""Mixtures of matte and gloss fitted to the pixels' observations: shares, normals, and how sure the normals are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.known.glossy import SHARES, Lamps, before_the_camera, products, shading, shares_of, tangents

FEWEST = 8  # observations of a pixel: four shares, two angles of the normal, and two to tell the noise by
SHADOWED = 0.5  # of what is predicted: an observation below is a shadow
OUTLYING = 1.5  # deviations of the residual where an observation has lost half of its weight
RELATIVE = 1e-4  # of a pixel's brightness: residuals below are rounding
ROUNDS = 6
LONGEST = 0.1  # radians a round
NEAR = float(np.cos(np.radians(15)))  # between lamps whose residuals are alike where the mixture is not the truth

Mask = NDArray[np.bool_]
Doubles = NDArray[np.float64]


@dataclass(eq=False)
class Fit:
    """The best mixtures at one normal a pixel.

    Parameters
    ----------
    normals
        (p, 3) unit vectors.
    pictures
        (k, n, p) what each share shows (`shading`).
    shares
        (k, p) of at least 0.
    rest
        (n, p) observations less mixtures.
    weights
        (n, p) of the sum of squares.
    gram
        (k, k, p) products of the pictures.
    """

    normals: Doubles
    pictures: NDArray[np.float32]
    shares: Doubles
    rest: Floats
    weights: Floats
    gram: Doubles

    def take(self, better: Mask, other: Fit) -> None:
        """Become the other fit in some pixels."""
        self.normals[better] = other.normals[better]
        self.pictures[..., better] = other.pictures[..., better]
        self.shares[:, better] = other.shares[:, better]
        self.rest[:, better] = other.rest[:, better]
        self.gram[..., better] = other.gram[..., better]


@dataclass(frozen=True, eq=False)
class Mixtures:
    """Observations of p pixels under n lamps, and the mixtures that explain them.

    Parameters
    ----------
    seen
        (n, p) observations over the pixel's scale.
    scale
        (p,) the pixels' mean brightness.
    asked
        (n, p) weights of at least 0: how much each observation is asked.
    lamps
        Where the lamps are.
    near
        (n, n) ones for lamps whose residuals are alike where the mixture is not the truth, each near itself.
    """

    seen: NDArray[np.float32]
    scale: Doubles
    asked: NDArray[np.float32]
    lamps: Lamps
    near: NDArray[np.float32]

    @classmethod
    def of(cls, seen: Floats, directions: Doubles, asked: Floats) -> Mixtures:
        """Return observations (n, p) under lamps of brightness 1 in (n, 3) directions, with (n, p) weights."""
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

    def fit(self, normals: Doubles, weights: Floats, start: Doubles | None = None) -> Fit:
        """Return the best mixture at given normals and weights."""
        pictures = shading(normals, self.lamps)
        gram, right = products(pictures, weights, self.seen)
        shares = shares_of(gram, right, start)
        return Fit(normals, pictures, shares, self._rest(pictures, shares), weights, gram)

    def reweigh(self, fit: Fit) -> Doubles:
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

    def _error(self, fit: Fit, square: Doubles, count: NDArray[np.int64]) -> Doubles:
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

    def _curvature(self, fit: Fit) -> tuple[Doubles, Doubles, tuple[Doubles, Doubles]]:
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

    def _slope(self, fit: Fit, direction: Doubles, size: float = 1e-2) -> NDArray[np.float32]:
        """Return how fast what the mixture shows changes when the normals turn, (n, p)."""
        change = np.zeros_like(self.seen)
        for sign in (0.5, -0.5):
            turned = fit.normals + sign * size * direction
            turned /= np.linalg.norm(turned, axis=1, keepdims=True)
            for picture, share in zip(shading(turned, self.lamps), fit.shares.astype(np.float32), strict=True):
                change += np.float32(2 * sign / size) * picture * share
        return change


def _cost(fit: Fit) -> Doubles:
    """Return the weighted sum of squares."""
    return np.asarray(np.einsum("np,np,np->p", fit.weights, fit.rest, fit.rest), np.float64)


def _solve_two(matrix: Doubles, right: Doubles) -> Doubles:
    """Solve 2 x 2 systems, (2, 2, p) and (2, p)."""
    (a, b), (_, d) = matrix
    determinant = a * d - b * b
    inverse = np.divide(1, determinant, out=np.zeros_like(determinant), where=determinant > 0)
    return np.stack([(d * right[0] - b * right[1]) * inverse, (a * right[1] - b * right[0]) * inverse])
