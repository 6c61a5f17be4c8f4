"""Stereo under known general light: each photograph's light is a sky, a room or a lamp, given by its harmonics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count
from harmonicface.lighting.as_light import LightLike, as_light
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.stereo.glossy import tangents
from harmonicface.stereo.in_blocks import Pixels

FEWEST = 3  # photographs: albedo, and two angles of the normal
ORDERS = (1, 2)
DIRECTIONS = 200  # of the half sphere before the camera from which a search begins: 10 degrees apart
ROUNDS = 15
SETTLED = 1e-9  # radians
LONGEST = 0.2  # radians a round
TURN = 1e-4  # radians, for differences
ALIKE = 1e-8  # of the largest singular value: lights that differ by less are the same one
CHUNK = 1 << 14  # pixels at a time

Doubles = NDArray[np.float64]


def light_coefficients(lights: ArrayLike | Sequence[LightLike], order: int = 2) -> Doubles:
    """Return the harmonic coefficients of each photograph's light, (n, (order + 1)^2), grey.

    Parameters
    ----------
    lights
        One for each photograph: an array (n, k) of coefficients with k of 4 or 9 and more, or a list of whatever
        `as_light` takes: a `Light`, an `EnvironmentMap`, a published name, coefficients, a direction. Of coloured light
        the mean of the colours is taken, as of coloured photographs.
    order
        1 or 2.

    Raises
    ------
    HarmonicFaceError
        Another order, coefficients of a lower one, something that is no light, NaN.

    Examples
    --------
    >>> light_coefficients([[0, 0, 1], "grace"], order=1).round(3)
    array([[ 0.282,  0.   ,  0.489,  0.   ],
           [ 0.59 ,  0.447, -0.263, -0.113]])
    """
    if order not in ORDERS:
        raise HarmonicFaceError(f"order: expected 1 or 2, got {_validate.describe(order)}")
    size = count(order)
    if isinstance(lights, np.ndarray):
        rows = _validate.finite(lights, "lights").astype(np.float64)
        if rows.ndim != 2 or rows.shape[1] < size:
            raise HarmonicFaceError(
                f"lights: expected {size} coefficients or more for each photograph, got shape {rows.shape}"
            )
        return rows[:, :size]
    found = []
    for light in lights if isinstance(lights, Sequence) and not isinstance(lights, str) else [lights]:
        values = np.asarray(as_light(light).coefficients(order), np.float64)
        found.append(values if values.ndim == 1 else values.mean(axis=1))
    return np.array(found).reshape(-1, size)


def general_light_normals(
    observations: Floats,
    lights: ArrayLike | Sequence[LightLike],
    order: int = 2,
    saturation: float = np.inf,
    usable: NDArray[np.bool_] | None = None,
) -> Pixels:
    r"""Find normals and albedo of matte pixels under known light of any kind.

    With the light's coefficients L and the Lambertian filter A (Basri & Jacobs 2003; Basri, Jacobs & Kemelmacher,
    Photometric Stereo with General, Unknown Lighting, 2007), of order 1 or 2,

    .. math:: \min_{\rho, n} \sum_i \Bigl( I_i - \rho \sum_{lm} A_l L_{i,lm} Y_{lm}(n) \Bigr)^2, \quad |n| = 1

    The best of 200 directions is the start of Gauss-Newton steps on the sphere, none of which raises the sum; the
    albedo is solved for at each. Shadows, interreflections and gloss are not modelled. Order 1 keeps 4 coefficients and
    leaves a quarter of the light of a lamp unexplained; it is of use where no more is known of the lights.

    Parameters
    ----------
    observations
        (n, p) linear grey intensities.
    lights
        One a photograph (see `light_coefficients`).
    order
        1 or 2.
    saturation
        Observations that reach it are left out.
    usable
        (n, p) booleans, false for other observations to leave out.

    Returns
    -------
    Pixels
        `confidence` is the standard error of the normal in degrees if what is left is noise, infinite where fewer than
        three observations are used or they leave a direction of turning open.

    Raises
    ------
    HarmonicFaceError
        Fewer than three photographs, lights of another count, lights that are all alike but for their brightness or
        span fewer than three dimensions, what `light_coefficients` refuses.

    Examples
    --------
    >>> generator = np.random.default_rng(0)
    >>> lights = generator.normal(size=(6, 9)) + [6, 0, 0, 0, 0, 0, 0, 0, 0]
    >>> normal = np.array([0.48, 0.6, 0.64])
    >>> images = 0.5 * (lights * lambertian_weights(2)) @ real_harmonics(normal[None], 2)  # (6, 1)
    >>> general_light_normals(images, lights).scaled.round(4)
    array([[0.24, 0.3 , 0.32]])
    """
    coefficients = light_coefficients(lights, order)
    images = len(observations)
    if images < FEWEST:
        raise HarmonicFaceError(f"images: expected at least {FEWEST}, got {images}")
    if len(coefficients) != images:
        raise HarmonicFaceError(f"lights: expected one a photograph, {images}, got {len(coefficients)}")
    weighted = coefficients * lambertian_weights(order)
    values = np.linalg.svd(weighted, compute_uv=False)
    if values[FEWEST - 1] <= ALIKE * values[0]:
        rank = int((values > ALIKE * values[0]).sum())
        raise HarmonicFaceError(f"lights: expected at least {FEWEST} that are no mixtures of the others, got {rank}")
    parts = []
    for start in range(0, observations.shape[1], CHUNK):
        part = observations[:, start : start + CHUNK].astype(np.float64)
        trusted = part < saturation
        if usable is not None:
            trusted &= usable[:, start : start + CHUNK]
        parts.append(_solve(part, weighted, trusted.astype(np.float64), order))
    return Pixels(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _solve(seen: Doubles, weighted: Doubles, trust: Doubles, order: int) -> tuple[NDArray[Any], ...]:
    """Solve (n, p) observations: what `Pixels` holds."""
    normals = _start(seen, weighted, trust, order)
    shaded, cost = _shaded(normals, seen, weighted, trust, order)
    caution = np.full(len(normals), 1e-3)
    curvature = np.zeros((2, 2, len(normals)))
    for _ in range(ROUNDS):
        across = tangents(normals)
        curvature, slope = _curvature(normals, across, shaded, seen, weighted, trust, order)
        damped = curvature + (caution * np.trace(curvature) + 1e-30) * np.eye(2)[:, :, None]
        step = np.linalg.solve(np.moveaxis(damped, 2, 0), slope.T[..., None])[..., 0].T
        length = np.hypot(*step)
        step *= np.minimum(1, LONGEST / np.maximum(length, 1e-30))
        moved = normals + step[0][:, None] * across[0] + step[1][:, None] * across[1]
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
        shown, lower = _shaded(moved, seen, weighted, trust, order)
        better = lower < cost
        normals[better], shaded[:, better], cost[better] = moved[better], shown[:, better], lower[better]
        caution = np.where(better, 0.1 * caution, 10 * caution)
        if (length[better] < SETTLED).all():
            break
    curvature, _ = _curvature(normals, tangents(normals), shaded, seen, weighted, trust, order)
    used = trust.sum(axis=0).astype(np.int64)
    noise = cost / np.maximum(used - FEWEST, 1)
    if (used > FEWEST).any():
        noise = np.where(used > FEWEST, noise, np.median(noise[used > FEWEST]))
    determinant = curvature[0, 0] * curvature[1, 1] - curvature[0, 1] ** 2
    trace = np.trace(curvature)
    albedo = _albedo(shaded, seen, trust)
    known = (determinant > ALIKE * trace**2) & (used >= FEWEST) & (albedo > 0)
    known &= (used > FEWEST).any()
    error = np.full(len(normals), np.inf)
    error[known] = np.degrees(np.arctan(np.sqrt(noise[known] * trace[known] / determinant[known])))
    residual = np.sqrt(cost / np.maximum(used, 1))
    return normals * albedo[:, None], residual, error, used


def _start(seen: Doubles, weighted: Doubles, trust: Doubles, order: int) -> Doubles:
    """Return the best of some directions before the camera."""
    index = np.arange(DIRECTIONS)
    height, turn = 1 - (index + 0.5) / DIRECTIONS, index * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    tried = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
    shades = weighted @ real_harmonics(tried, order)
    along = np.maximum(shades.T @ (trust * seen), 0)
    square = (shades.T**2) @ trust
    return np.asarray(tried[np.argmax(along**2 / np.maximum(square, 1e-300), axis=0)])


def _shaded(normals: Doubles, seen: Doubles, weighted: Doubles, trust: Doubles, order: int) -> tuple[Doubles, Doubles]:
    """Return the irradiance at each normal in each photograph, and the sum of squares that the best albedo leaves."""
    shades = weighted @ real_harmonics(normals, order)
    rest = seen - shades * _albedo(shades, seen, trust)
    return shades, np.einsum("np,np,np->p", trust, rest, rest)


def _albedo(shades: Doubles, seen: Doubles, trust: Doubles) -> Doubles:
    """Return the albedo, of at least 0, that explains observations best."""
    square = np.einsum("np,np,np->p", trust, shades, shades)
    along = np.einsum("np,np,np->p", trust, shades, seen)
    return np.asarray(np.maximum(np.divide(along, square, out=np.zeros_like(along), where=square > 0), 0))


def _curvature(
    normals: Doubles,
    across: tuple[Doubles, Doubles],
    shades: Doubles,
    seen: Doubles,
    weighted: Doubles,
    trust: Doubles,
    order: int,
) -> tuple[Doubles, Doubles]:
    """Return half the second derivative of the sum in the normal, albedo free, (2, 2, p), and its descent (2, p)."""
    albedo = _albedo(shades, seen, trust)
    rest = seen - shades * albedo
    square = np.einsum("np,np,np->p", trust, shades, shades)
    slopes = []
    for direction in across:
        ahead, behind = (weighted @ real_harmonics(_turned(normals, s * TURN * direction), order) for s in (0.5, -0.5))
        slope = albedo * (ahead - behind) / TURN
        along = np.einsum("np,np,np->p", trust, shades, slope)
        slopes.append(slope - shades * np.divide(along, square, out=np.zeros_like(along), where=square > 0))
    curvature = np.array([[np.einsum("np,np,np->p", trust, s, t) for t in slopes] for s in slopes])
    return curvature, np.array([np.einsum("np,np,np->p", trust, s, rest) for s in slopes])


def _turned(normals: Doubles, change: Doubles) -> Doubles:
    """Return unit normals that were moved a little."""
    moved = normals + change
    return np.asarray(moved / np.linalg.norm(moved, axis=1, keepdims=True))
