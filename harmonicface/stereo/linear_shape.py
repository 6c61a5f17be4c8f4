"""Linear shape: which linear map of the leading factors gives the normals that explain the photographs, shadows too."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.integration import integrate_normals
from harmonicface.stereo.positive_lights import PositiveLights, positive_lights
from harmonicface.stereo.sky_cells import Singles, cell_shades, cell_visibility

STEP = 3e-3  # of the map's size: by how much an entry is changed to see what it does
DAMPING = 1e-2  # of Levenberg and Marquardt, to start with
TRIALS = 6  # of a step, each more damped
SETTLED = 3e-3  # relative decrease of the cost by which the search ends
ROBUST_FROM = 2  # rounds: before, what does not fit is still the shape's fault
TAIL = 3.0  # standard deviations of a photograph's residuals beyond which they count less
TONES = 0.3  # a factor of albedo, as logarithm, beyond which it is a feature of its own
ROUNDS = 3  # of lights and albedo for one shape

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Explained:
    """Photographs explained by a shape: the cost, lights and albedo, visibility, and what is left."""

    cost: float
    lights: PositiveLights
    visibility: Singles | None
    rest: Doubles


@dataclass(eq=False)
class LinearShape:
    r"""The search for A with normals along `A' f`, f the leading factors of a pixel.

    .. math:: E(A) = \min_{L \ge 0, \rho} \sum_{ix} w_{ix} (I_{ix} - \rho_x \sum_c L_{ic} S_{cx}(n, V))^2
              + n \sum_x \alpha^2 t(\log\rho_x)^2 + n \sum_x \beta_x^2 |n_x - \bar n_x|^2

    with n = A' f / |A' f| and V what the depth that integrates these normals leaves of the sky. So few numbers stand
    for the shape that the photographs cannot be explained by an unsteady surface; what would remain open (a bas-relief,
    Belhumeur, Kriegman & Yuille 1999; more without integrability, Basri, Jacobs & Kemelmacher 2007) is told by shadows,
    by light being positive, weakly by albedo (t: an arctan) and, of a face, by the mean face, n-bar.

    Parameters
    ----------
    photographs
        (n, p) intensities, of like size from one to the other.
    factors
        (k, p) right factors of the photographs.
    mask
        (h, w) booleans with p pixels.
    shadows
        Whether the depth casts them.
    evenness
        alpha, the weight of an even albedo.
    expected
        (p, 3) unit normals that are expected, or None.
    trust
        beta, (p,) weight of each of them.
    """

    photographs: Doubles
    factors: Doubles
    mask: Mask
    shadows: bool = True
    evenness: float = 0.0
    expected: Doubles | None = None
    trust: Doubles | None = None
    weights: Floats = field(init=False)
    albedo: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.weights = np.ones_like(self.photographs)
        self.albedo = np.asarray(self.photographs.mean(axis=0), np.float64)

    def normals(self, linear: Doubles) -> Doubles:
        """Return the unit normals of a map (k, 3) at all pixels, (p, 3)."""
        return unit(self.factors.T @ linear)

    def explain(self, linear: Doubles) -> Explained:
        """Return the lights and the albedo that explain the photographs by the normals of a map, and the cost."""
        normals = self.normals(linear)
        visibility = cell_visibility(self._depth(normals), self.mask) if self.shadows else None
        shades = cell_shades(normals, visibility)
        lights = positive_lights(self.photographs, shades, self.albedo, self.weights, rounds=ROUNDS)
        rest = self.photographs - lights.albedo * lights.irradiance
        expected = self._expectations(normals, lights.albedo)
        cost = np.einsum("np,np,np->", self.weights, rest, rest) + expected @ expected
        return Explained(float(cost), lights, visibility, rest)

    def search(self, linear: Doubles, rounds: int) -> tuple[Doubles, list[float]]:
        """Search from a map by damped Gauss-Newton steps; return the best, and the costs on the way, none larger.

        Each round's weights are its own (a photograph's by its residuals, an observation's by how far off it is), so
        that only costs of the same round compare; of each round the first two numbers are returned.
        """
        costs: list[float] = []
        damping = DAMPING
        found = self.explain(linear)
        for number in range(rounds):
            self._reweight(found.rest, number >= ROBUST_FROM)
            self.albedo = found.lights.albedo
            before = self.explain(linear)
            target, slope = self._linearized(linear, before)
            normal, gradient = slope.T @ slope, slope.T @ target
            diagonal = np.diag(normal) + 1e-6 * np.trace(normal)
            after = before
            step: Doubles = 0 * linear
            for _ in range(TRIALS):
                step = np.asarray(-np.linalg.solve(normal + damping * np.diag(diagonal), gradient), np.float64)
                step = step.reshape(linear.shape)
                after = self.explain(linear + step)
                if after.cost < before.cost:
                    break
                damping = 6 * max(damping, 1e-4)
            else:
                break
            while (longer := self.explain(linear + 2 * step)).cost < after.cost:
                step, after = 2 * step, longer
            linear, found = linear + step, after
            damping /= 5
            costs += [before.cost, after.cost]
            if number > ROBUST_FROM and after.cost > (1 - SETTLED) * before.cost:
                break
        return linear, costs

    def _linearized(self, linear: Doubles, at: Explained) -> tuple[Doubles, Doubles]:
        """Return all residuals at a map, and their derivatives by its entries, by differences."""
        active, size = at.lights.active, STEP * float(np.linalg.norm(linear))
        target = self._residuals(linear, active)
        slope = np.empty((target.size, linear.size))
        for entry in range(linear.size):
            change = np.zeros(linear.size)
            change[entry] = size
            slope[:, entry] = (self._residuals(linear + change.reshape(linear.shape), active) - target) / size
        return target, slope

    def _residuals(self, linear: Doubles, active: Mask) -> Doubles:
        """Return what the sum of squares is of, with the same cells lit."""
        normals = self.normals(linear)
        visibility = cell_visibility(self._depth(normals), self.mask) if self.shadows else None
        shades = cell_shades(normals, visibility)
        lights = positive_lights(self.photographs, shades, self.albedo, self.weights, active)
        rest = np.sqrt(self.weights) * (self.photographs - lights.albedo * lights.irradiance)
        return np.concatenate([rest.ravel(), self._expectations(normals, lights.albedo)])

    def _expectations(self, normals: Doubles, albedo: Doubles) -> Doubles:
        """Return how far albedo and normals are from what is expected of them."""
        found, scale = [], np.sqrt(len(self.photographs))
        if self.evenness:
            tones = np.log(albedo)
            found.append(self.evenness * scale * TONES * np.arctan((tones - np.median(tones)) / TONES))
        if self.expected is not None and self.trust is not None:
            found.append((scale * self.trust[:, None] * (normals - self.expected)).ravel())
        return np.concatenate(found) if found else np.zeros(0)

    def _reweight(self, rest: Doubles, robust: bool) -> None:
        """Weigh each photograph by what is left of it, and what stands out of it less."""
        spread = 1.4826 * np.median(np.abs(rest), axis=1, keepdims=True)
        usual = float(np.median(spread)) or 1.0
        spread = np.maximum(spread, usual / 2)
        self.weights = (usual / spread) ** 2 * np.ones_like(rest)
        if robust:
            self.weights /= 1 + (rest / (TAIL * spread)) ** 2

    def _depth(self, normals: Doubles) -> Doubles:
        grid = np.zeros((*self.mask.shape, 3))
        grid[self.mask] = normals
        return integrate_normals(away_from_behind(grid, self.mask), self.mask)


def away_from_behind(grid: Doubles, mask: Mask) -> Doubles:
    """Turn normals that point straight away from the camera toward it: they have no slope."""
    behind = mask & (grid[..., 2] < 0) & (np.linalg.norm(grid[..., :2], axis=2) < 1e-3)
    grid[behind] = 0, 0, 1
    return grid


def unit(vectors: Floats) -> Doubles:
    """Return vectors (p, 3) at length 1; those without any face the camera."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    upright = np.array([0.0, 0.0, 1.0])
    return np.where(length > 0, vectors / np.where(length > 0, length, 1.0), upright)
