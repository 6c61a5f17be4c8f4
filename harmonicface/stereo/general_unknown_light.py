"""General unknown light: normals, albedo and lights from photographs alone, under any distant light with shadows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.stereo.factors import Factors, leading_factors
from harmonicface.stereo.integration import integrate_normals
from harmonicface.stereo.light_model import MODELS, SPARE, LightModel, choose_light_model
from harmonicface.stereo.linear_shape import LinearShape, unit
from harmonicface.stereo.lorentz import first_order_normals
from harmonicface.stereo.mean_face import mean_face_normals, place_mean_face
from harmonicface.stereo.pixel_refinement import refine
from harmonicface.stereo.result import Ambiguity, Model
from harmonicface.stereo.rim import outward_slant
from harmonicface.stereo.silhouette import balloon_normals
from harmonicface.stereo.sky_cells import SOLID_ANGLE, Singles, cell_directions, cell_shades, cell_visibility

COARSE = 1100  # pixels in which the gauge is searched: a map of 27 numbers needs no more
FINE = 60_000  # pixels that are refined each for itself; more keep what the map of the factors gives them
BRIGHT = 99.0  # percentile of a photograph that counts as white: how photographs are exposed
FEWEST = 100  # pixels, for shadows and integrability to tell anything
SEARCH, SEARCH_AFAR = 8, 16  # rounds from the mean face, and from a balloon
EVENNESS = 0.05  # weight of even albedo; these two were chosen on one scanned head
FACE_TRUST = 0.06  # weight of the mean face's normals
DIMENSIONS = 3  # in which light has to vary
CLEARLY = 3.0  # times what noise would give: what counts as a variation
CHOICES = ("auto", "ambient4", "harmonic9")

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class GeneralLightStereo:
    """Normals, albedo and lights from photographs under unknown light.

    Parameters
    ----------
    scaled
        (p, 3) albedo times normal; only their ratios from pixel to pixel are known.
    lights
        (n, 4) or (n, 9) harmonic coefficients of radiance.
    depth
        (h, w) in pixels, NaN outside the mask.
    residual
        (p,) root mean square of photograph minus model.
    confidence
        (p,) standard error of the normal in degrees under these lights; what the whole shape may be off by is in
        `ambiguity`.
    model, model_reason, ambiguity
        As in `StereoResult`.
    noise
        Standard deviation of the photographs' noise.
    factors
        All singular values, gap and condition.
    cost
        Of the refinement, before it and after each round; none larger than the one before.
    """

    scaled: Doubles
    lights: Doubles
    depth: Doubles
    residual: Doubles
    confidence: Doubles
    model: Model
    model_reason: str
    ambiguity: Ambiguity
    noise: float
    factors: Factors
    cost: list[float]


def general_light_stereo(
    pixels: ArrayLike, mask: ArrayLike, *, model: str = "auto", face: bool = False, shadows: bool = True
) -> GeneralLightStereo:
    r"""Find normals, albedo and lights from photographs under unknown distant light of any kind.

    1. The photographs' leading factors, 4 or 9 (Basri, Jacobs & Kemelmacher, Photometric stereo with general, unknown
       lighting, 2007), are a linear map away from albedo times normal.
    2. A first map makes them resemble a balloon behind the mask, or the mean face, or is found in closed form from the
       null cone and integrability where there are four factors and no shadows.
    3. The map is searched by which the photographs are explained best under lights that are nowhere negative, past the
       shadows that the integrated depth casts (`LinearShape`), at reduced resolution.
    4. Normals, albedo and lights are refined together, each pixel for itself (`refine`).

    Parameters
    ----------
    pixels
        (n, p) linear intensities of the masked pixels, row-major; n of at least 7 for "ambient4" and 12 for
        "harmonic9".
    mask
        (h, w) booleans with p pixels, at least 100.
    model
        "ambient4" (four factors), "harmonic9" (nine), or "auto": as `choose_light_model` says, where distant lamps
        count as "ambient4".
    face
        Whether it is a face from the front, more or less upright: the mean face then tells where to start, and draws
        the result toward it where photographs tell little.
    shadows
        Whether the surface's relief casts shadows in the photographs.

    Returns
    -------
    GeneralLightStereo
        In the design's axes; albedo and lights to a common factor.

    Raises
    ------
    HarmonicFaceError
        Shapes that do not fit, too few photographs or pixels, a black photograph, NaN, another model; light that
        varies in fewer than three dimensions (one light repeated, lights in a plane, a planar surface); nothing that
        resembles a face where one was promised.
    """
    observations, inside = _checked(pixels, mask)
    if model not in CHOICES:
        raise HarmonicFaceError(f"model: expected one of {', '.join(CHOICES)}, got {model!r}")
    exposure = np.percentile(observations, BRIGHT, axis=1)
    if not exposure.min() > 1e-6 * exposure.max():
        raise HarmonicFaceError(f"pixels: expected light in each photograph, got photograph {exposure.argmin()} black")
    even = observations / exposure[:, None]
    chosen = choose_light_model(even, inside)
    name, reason = _model(model, chosen, len(even))
    factors = leading_factors(even, MODELS[name])
    _require_three_dimensions(factors, chosen.noise)
    right = np.asarray(factors.right, np.float64) * np.sqrt(factors.pixels)
    side = max(1, int(np.sqrt(inside.sum() / COARSE)))
    small = reduced_mask(inside, side)
    if small.sum() < FEWEST / 2:
        side, small = 1, inside
    photographs, coarse = reduced(even, inside, side, small), reduced(right, inside, side, small)
    search, linear, misfit = _start(photographs, coarse, small, name, face, shadows)
    linear, _ = search.search(linear, SEARCH if face else SEARCH_AFAR)
    found = search.explain(linear)
    scaled = right.T @ linear
    return _finished(
        even, exposure, inside, scaled, found.lights.radiance, shadows, name, reason, chosen, factors, misfit
    )


def _finished(
    even: Doubles,
    exposure: Doubles,
    mask: Mask,
    scaled: Doubles,
    radiance: Doubles,
    shadows: bool,
    name: Model,
    reason: str,
    chosen: LightModel,
    factors: Factors,
    misfit: float | None,
) -> GeneralLightStereo:
    """Refine all pixels, integrate them, and say what it is worth."""
    depth = _depth(scaled, mask)
    rounds = 2 if len(scaled) <= FINE else 0
    visibility = cell_visibility(depth, mask) if shadows and rounds else None
    refined = refine(
        even, unit(scaled) * _albedo(even, unit(scaled), radiance, visibility), radiance, visibility, rounds
    )
    harmonics = real_harmonics(cell_directions(), 1 if name == "ambient4" else 2)
    lights = refined.radiance @ harmonics.T * SOLID_ANGLE * exposure[:, None]
    if rounds:
        depth = _depth(refined.scaled, mask)
    brightness = float(np.sqrt((exposure**2).mean()))
    return GeneralLightStereo(
        refined.scaled,
        lights,
        depth,
        refined.residual * brightness,
        refined.deviation,
        name,
        reason,
        _ambiguity(misfit, shadows),
        chosen.noise * brightness,
        factors,
        refined.cost,
    )


def _albedo(photographs: Doubles, normals: Doubles, radiance: Doubles, visibility: Singles | None) -> Doubles:
    """Return the albedo (p, 1) that explains the photographs best for given normals and lights."""
    irradiance = radiance @ cell_shades(normals, visibility)
    power = np.einsum("np,np->p", irradiance, irradiance)
    albedo = np.einsum("np,np->p", photographs, irradiance) / np.maximum(power, 1e-12 * power.max())
    return np.asarray(np.maximum(albedo, 1e-3 * albedo.mean())[:, None])


def _start(
    photographs: Doubles, factors: Doubles, mask: Mask, name: Model, face: bool, shadows: bool
) -> tuple[LinearShape, Doubles, float | None]:
    """Return the search, the map that it starts from, and how well the mean face fits."""
    tone = photographs.mean(axis=0)
    search = LinearShape(photographs, factors, mask, shadows, EVENNESS)
    if face:
        place = place_mean_face(factors, tone, mask)
        normals, known = mean_face_normals(mask, place)
        linear = _fitted(factors[:, known], tone[known, None] * normals[known])
        expected = unit(factors.T @ linear)
        search = replace(search, expected=expected, trust=np.asarray(FACE_TRUST * known))
        return search, linear, place.misfit
    linear = np.zeros((len(factors), 3))
    wanted = tone[:, None] * balloon_normals(mask)
    linear[:4] = _fitted(factors[:4], wanted)
    if name == "ambient4" and not shadows:
        scaled = first_order_normals(factors, mask)
        bulging = scaled * ([1, 1, 1] if outward_slant(scaled, mask) > 0 else [-1, -1, 1])
        exact = _fitted(factors, bulging)
        if search.explain(exact).cost < search.explain(linear).cost:
            linear = exact
    return search, linear, None


def _fitted(factors: Doubles, wanted: Doubles) -> Doubles:
    """Return the map (k, 3) of factors (k, p) that comes nearest to vectors (p, 3)."""
    return np.asarray(np.linalg.lstsq(factors.T, wanted, rcond=None)[0], np.float64)


def reduced_mask(mask: Mask, side: int) -> Mask:
    """Return which squares of `side` pixels lie in the mask whole."""
    height, width = (size // side for size in mask.shape)
    return np.asarray(
        mask[: height * side, : width * side].reshape(height, side, width, side).all(axis=(1, 3)), np.bool_
    )


def reduced(rows: Floats, mask: Mask, side: int, small: Mask) -> Doubles:
    """Return the means of rows (k, p) over the squares of a reduced mask."""
    height, width = small.shape
    grid = np.zeros(mask.shape)
    found = np.empty((len(rows), int(small.sum())))
    for row, target in zip(rows, found, strict=True):
        grid[mask] = row
        blocks = grid[: height * side, : width * side].reshape(height, side, width, side)
        target[:] = blocks.mean(axis=(1, 3))[small]
    return found


def _depth(scaled: Doubles, mask: Mask) -> Doubles:
    grid = np.zeros((*mask.shape, 3))
    grid[mask] = unit(scaled)
    behind = mask & (grid[..., 2] < 0) & (np.linalg.norm(grid[..., :2], axis=2) < 1e-3)
    grid[behind] = 0, 0, 1
    return integrate_normals(grid, mask)


def _model(asked: str, chosen: LightModel, count: int) -> tuple[Model, str]:
    """Return the model and why."""
    if asked == "auto":
        if chosen.model == "linear3":
            return "ambient4", f"{chosen.reason}; distant lamps are taken as light of first order here"
        return chosen.model, chosen.reason
    name: Model = "ambient4" if asked == "ambient4" else "harmonic9"
    if count < MODELS[name] + SPARE:
        raise HarmonicFaceError(f"pixels: expected at least {MODELS[name] + SPARE} photographs for {name}, got {count}")
    return name, "asked for"


def _require_three_dimensions(factors: Factors, noise: float) -> None:
    """Refuse photographs that vary in one or two ways only."""
    found = factors.above_noise(max(CLEARLY * noise, 1e-6 * factors.residual(0)))
    if found < DIMENSIONS:
        raise HarmonicFaceError(
            f"pixels: expected photographs that vary in at least {DIMENSIONS} ways, got {found} above the noise of"
            f" {noise:.2g}: one light repeated, lights in a plane, or a planar surface do not tell normals"
        )


def _ambiguity(misfit: float | None, shadows: bool) -> Ambiguity:
    """Say what remains open."""
    if misfit is not None:
        reason = (
            f"the mean face (its shading explained but for {misfit:.0%}) and shadows hold the relief, to about"
            " an eighth of its height"
        )
        return Ambiguity("bas-relief", reason, _relief(0.12, 0.04))
    by = "shadows, light that is nowhere negative and" if shadows else "light that is nowhere negative and"
    reason = f"{by} even albedo hold the relief, to about a quarter of its height: a face or known light would say more"
    return Ambiguity("bas-relief", reason, _relief(0.25, 0.12))


def _relief(height: float, tilt: float) -> dict[str, float]:
    found = {"mu": 0.0, "nu": 0.0, "lambda": 1.0}
    return {**found, "mu_std": tilt, "nu_std": tilt, "lambda_std": height}


def _checked(pixels: ArrayLike, mask: ArrayLike) -> tuple[Doubles, Mask]:
    observations = _validate.floats(pixels, "pixels").astype(np.float64)
    inside = np.asarray(mask)
    if inside.ndim != 2:
        raise HarmonicFaceError(f"mask: expected shape (h, w), got {_validate.describe(inside)}")
    inside = _validate.mask(inside, "mask", (inside.shape[0], inside.shape[1]))
    if observations.ndim != 2 or observations.shape[1] != inside.sum():
        raise HarmonicFaceError(
            f"pixels: expected shape (n, {inside.sum()}) as in the mask, got {_validate.describe(observations)}"
        )
    if len(observations) < MODELS["ambient4"] + SPARE:
        raise HarmonicFaceError(
            f"pixels: expected at least {MODELS['ambient4'] + SPARE} photographs under unknown general light,"
            f" got {len(observations)}"
        )
    if observations.shape[1] < FEWEST:
        raise HarmonicFaceError(f"mask: expected at least {FEWEST} pixels, got {observations.shape[1]}")
    return _validate.finite(observations, "pixels").astype(np.float64), inside
