"""Inverse lighting with one to three lamps: their directions and strengths from one photograph."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import nnls

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance._inverse_problem import Pixels, photographed
from harmonicface.appearance.nonnegative_light import fibonacci_sphere, nonnegative_strengths
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

MOST = 3
GRID = 150  # directions of the first search: 17 degrees apart
SEARCHED = 3000  # pixels of the search; the refinement sees all
RADII = (20.0, 8.0)  # degrees within which lamps of the grid may stand for one
BEAM = 3  # of the best arrangements of n lamps are continued with one lamp more
ROUNDS = 60
EXACT = 1e-20  # of the photograph's energy: what is below is rounding, and no further lamp is looked for
SPANNED = 1e-7  # smallest over largest singular value at which normals still determine a direction


@dataclass(frozen=True, eq=False)
class SparseLight:
    """A few lamps that explain a photograph.

    Parameters
    ----------
    light
        The lamps, strongest first.
    std_degrees
        (n,) root mean square error of each direction in degrees that the noise causes; infinite where the lit normals
        do not determine it.
    residual
        Root mean square of photograph minus picture, one number, or three of a colour photograph.
    """

    light: DirectionalLights
    std_degrees: Floats
    residual: Floats


def sparse_light(
    photo: ArrayLike,
    surface: Surface,
    count: int | None = None,
    *,
    mask: ArrayLike | None = None,
    noise: float | None = None,
    saturation: float = np.inf,
) -> SparseLight:
    r"""Find one to three distant lamps from one photograph of a matte Surface.

    .. math:: \min_{b_1 \dots b_n} \sum_x \Big( I(x) - \rho(x) \sum_i \max(n(x) \cdot b_i, 0) \Big)^2,
              \quad b_i = s_i w_i

    Non-negative lamps on a grid start the search. Then, with the normals that each lamp lights held fixed, the
    problem is linear in the b_i; solving it and finding the lit normals again alternate until nothing changes, which
    is exact where the photograph is. One or two lamps, and three whose directions are linearly independent, are the
    only non-negative light that gives their irradiance (Ramamoorthi & Hanrahan, On the relationship between radiance
    and irradiance, 2001, corollaries 2 and 3; the third needs linear independence, not distinctness).

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities.
    surface
        Its normals and albedo. Cast shadows are not modelled.
    count
        1, 2 or 3 lamps at most; None for as many as the Bayesian information criterion finds worth their parameters.
    mask
        (h, w) booleans, the pixels to use; all of the Surface by default.
    noise
        Standard deviation of a pixel, for `std_degrees`. By default it is taken from the residual.
    saturation
        Pixels at or above it, in any channel, are left out.

    Returns
    -------
    SparseLight
        Directions, strengths, and how sure the directions are.

    Raises
    ------
    HarmonicFaceError
        A count that is not 1, 2 or 3; a photo of another shape, without light, or with NaN in the mask; no pixel
        left, no albedo, a bad noise.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> person = hf.synthetic_person(0, 32)
    >>> found = sparse_light(hf.render(person, hf.lights.directional([0.6, 0.0, 0.8])), person, 1)
    >>> found.light.directions.round(4) + 0.0
    array([[0.6, 0. , 0.8]])
    """
    if count is not None and _validate.at_least(count, 1, "count") > MOST:
        raise HarmonicFaceError(f"count: expected 1, 2 or 3 lamps, got {count}")
    number = isinstance(noise, (int, float, np.integer, np.floating)) and not isinstance(noise, bool)
    if noise is not None and not (number and np.isfinite(noise) and noise >= 0):
        raise HarmonicFaceError(f"noise: expected a finite number of at least 0, got {_validate.describe(noise)}")
    pixels = photographed(photo, surface, mask, saturation)
    scaled, image = _one_channel(pixels)
    few = np.random.default_rng(0).permutation(len(image))[:SEARCHED]  # evenly; the seed decides only which
    starts: list[Array] = [np.zeros((0, 3))]
    likely = _candidates(scaled[few], image[few])
    best: list[tuple[float, Array]] = []
    for _ in range(count or MOST):
        starts = _longer(scaled[few], image[few], starts, likely)
        best.append(min((_refined(scaled, image, start) for start in starts), key=lambda found: found[0]))
        if best[-1][0] <= EXACT * (image @ image):
            break
    squares, vectors = best[-1] if count else min(best, key=lambda found: _criterion(found[0], found[1], len(image)))
    if not len(vectors):
        raise HarmonicFaceError("photo: expected light that some lamp explains, got a picture best explained by none")
    vectors = vectors[np.argsort(-np.linalg.norm(vectors, axis=1))]
    freedom = max(len(image) - vectors.size, 1)
    sigma = float(np.sqrt(squares / freedom)) if noise is None else float(noise)
    return _result(pixels, vectors, _errors(scaled, vectors, sigma))


def _one_channel(pixels: Pixels) -> tuple[Array, Array]:
    """Return (p, 3) normals times albedo and (p,) intensities, in which colours are added with their due weight."""
    albedo = np.stack(pixels.albedos, axis=1)  # (p, 1) or (p, 3)
    reflecting = (albedo > 0).all(axis=1)
    albedo = np.broadcast_to(albedo[reflecting], pixels.intensities[reflecting].shape)
    weight = 1 / np.linalg.norm(1 / albedo, axis=1)
    image = weight * (pixels.intensities[reflecting] / albedo).sum(axis=1)
    return weight[:, None] * pixels.normals[reflecting], image


def _longer(scaled: Array, image: Array, starts: list[Array], likely: list[Array]) -> list[Array]:
    """Return the best arrangements with one lamp more: a likely one, or one that what is left asks for."""
    found: list[tuple[float, Array]] = []
    for start in starts:
        rest = image - np.maximum(scaled @ start.T, 0).sum(axis=1)
        candidates = likely + (_candidates(scaled, rest) if len(start) else [])
        found += [_refined(scaled, image, np.vstack([start, candidate])) for candidate in candidates]
    found.sort(key=lambda each: each[0])
    return [vectors for _, vectors in found if len(vectors) > len(starts[0])][:BEAM] or starts


def _candidates(scaled: Array, image: Array) -> list[Array]:
    """Return lamps worth a try: non-negative ones on a grid, near ones taken together."""
    towards = fibonacci_sphere(GRID)
    length = np.linalg.norm(scaled, axis=1)
    lit = length > 0
    pixels = Pixels(scaled[lit] / length[lit, None], image[lit, None], [length[lit]])
    strengths = nonnegative_strengths(pixels, towards)[0][:, 0]
    found: list[Array] = []
    for radius in RADII:
        left = strengths.copy()
        for _ in range(MOST):
            if left.max() > 0:
                near = towards @ towards[left.argmax()] > np.cos(np.radians(radius))
                found.append(left[near] @ towards[near])
                left[near] = 0
    return found


def _refined(scaled: Array, image: Array, vectors: Array) -> tuple[float, Array]:
    """Return the sum of squares and the lamps where alternating lit normals and least squares ends."""
    squares = _squares(scaled, image, vectors)
    if not len(vectors):
        return squares, vectors
    for _ in range(ROUNDS):
        step = np.linalg.lstsq(_pictures(scaled, vectors), image)[0].reshape(-1, 3) - vectors
        for shorter in (1.0, 0.5, 0.2, 0.05):
            trial = vectors + shorter * step
            if (reached := _squares(scaled, image, trial)) < squares:
                break
        else:
            break
        settled = reached > squares * (1 - 1e-12)
        vectors, squares = trial, reached
        if settled:
            break
    return squares, vectors[np.linalg.norm(vectors, axis=1) > 0]


def _pictures(scaled: Array, vectors: Array) -> Array:
    """Return (p, 3n): albedo times normal where lamp i lights it, so that the photograph is this times the vectors."""
    lit = scaled @ vectors.T > 0
    return (lit[:, :, None] * scaled[:, None, :]).reshape(len(scaled), -1)


def _squares(scaled: Array, image: Array, vectors: Array) -> float:
    """Return the sum of squares that lamps leave."""
    return float(((image - np.maximum(scaled @ vectors.T, 0).sum(axis=1)) ** 2).sum())


def _criterion(squares: float, vectors: Array, pixels: int) -> float:
    """Return the Bayesian information criterion; a fit to rounding beats all."""
    return pixels * float(np.log(max(squares, 1e-300) / pixels)) + vectors.size * float(np.log(pixels))


def _errors(scaled: Array, vectors: Array, sigma: float) -> Array:
    """Return the root mean square angle in degrees that the noise turns each lamp by."""
    values, right = np.linalg.svd(_pictures(scaled, vectors), full_matrices=False)[1:]
    if len(values) < vectors.size or values[-1] <= SPANNED * values[0]:
        return np.full(len(vectors), np.inf)
    covariance = sigma**2 * (right.T / values**2) @ right
    errors = []
    for i, vector in enumerate(vectors):
        length = np.linalg.norm(vector)
        block = covariance[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
        along = vector @ block @ vector / length**2
        errors.append(np.degrees(np.sqrt(max(np.trace(block) - along, 0)) / length))
    return np.array(errors)


def _result(pixels: Pixels, vectors: Array, errors: Array) -> SparseLight:
    """Give each lamp its strength in each channel."""
    towards = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    shading = np.maximum(pixels.normals @ towards.T, 0)
    strengths, residuals = [], []
    for channel, image in enumerate(pixels.intensities.T):
        albedo = pixels.albedos[channel if len(pixels.albedos) == 3 else 0]
        strength, misfit = nnls(albedo[:, None] * shading, image)
        strengths.append(strength)
        residuals.append(misfit / np.sqrt(len(image)))
    if len(strengths) == 1:
        return SparseLight(DirectionalLights(towards, strengths[0]), errors, np.asarray(residuals[0]))
    return SparseLight(DirectionalLights(towards, np.stack(strengths, axis=1)), errors, np.array(residuals))
