"""Rows of the stability table: photometric stereo, from lamps that are known, and factors where they are not."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import DTypeLike

from harmonicface._validate import Floats
from harmonicface.bench.stability import exact, exact_harmonics
from harmonicface.bench.stability.row import (
    CONSTANT,
    SURE,
    Answers,
    Measured,
    Refused,
    Rows,
    if_honest,
    named,
    rounded,
    unit,
)
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.stereo.known.general_light import SETTLED, general_light_normals
from harmonicface.stereo.known.least_squares import plain_least_squares, scaled_normals
from harmonicface.stereo.lamps.hayakawa import linear_factors

COUNT, PIXELS = 10, 30


def of_known_lights() -> Answers:
    """Return a function for each row with known lights."""
    return {
        **named("scaled_normals", _of_normal_equations()),
        **named("plain_least_squares", _of_pseudo_inverse()),
        **named("calibrated_stereo", _of_photographs()),
        **named("general_light_normals", _of_general_light()),
    }


def of_unknown_lights() -> Answers:
    """Return a function for each row with unknown lights."""
    rows: Rows = {"any lamps": partial(_factored, _lamps())}
    for factor in (1e-12, 1e12, 1e-100, 1e100):
        rows[f"times {factor:.0e}"] = partial(_factored, _lamps(), factor)
    rows["float32"] = partial(_factored, _lamps(), dtype=np.float32)
    rows["every photo twice"] = partial(_factored, np.repeat(_lamps()[::2], 2, axis=0))
    rows["lamps within 1e-05 of a plane"] = partial(_factored, _flat(1e-5))
    rows["lamps in a plane"] = partial(_factored, _flat(0.0))
    rows["one lamp for all photos"] = partial(_factored, np.repeat(_lamps()[:1], COUNT, axis=0))
    rows["black photos"] = partial(_factored, _lamps(), 0.0)
    rows["two photos"] = partial(_factored, _lamps()[:2])
    return named("linear_factors", rows)


def _lamps() -> Floats:
    """Return lamps before the surface, (n, 3)."""
    vectors = np.random.default_rng(0).uniform(-0.6, 0.6, (COUNT, 3))
    vectors[:, 2] = 1
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _flat(distance: float) -> Floats:
    """Return lamps that are so near to a plane; those of distance 0 are exactly in it."""
    lamps = np.round(_lamps() * 64) / 64
    lamps[:, 1] = lamps[:, 0] + distance * _lamps()[:, 1]
    return lamps


def _scaled() -> Floats:
    """Return albedo times normals that all those lamps light, (p, 3)."""
    vectors = np.random.default_rng(1).uniform(-0.3, 0.3, (PIXELS, 3))
    vectors[:, 2] = 1
    return np.asarray(0.7 * vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _seen(lamps: Floats, factor: float = 1.0, dtype: DTypeLike = np.float64) -> Floats:
    """Return photographs (n, p) of matte pixels that are lit by all lamps."""
    exactly = np.longdouble(factor) * (lamps.astype(np.longdouble) @ _scaled().T.astype(np.longdouble))
    return exactly.astype(dtype)


def _of_normal_equations() -> Rows:
    lamps, axes = _lamps(), np.array([[0.0, 0, 1], [0.6, 0, 0.8], [0, 0.6, 0.8]])
    rows: Rows = {"lamps along the axes": partial(_solved, np.eye(3)), "any lamps": partial(_solved, lamps)}
    for distance in (1e-2, 1e-4, 1e-8):
        rows[f"lamps within {distance:.0e} of a plane"] = partial(_solved, _flat(distance))
    for factor in (1e-12, 1e12, 1e-300):
        rows[f"times {factor:.0e}"] = partial(_solved, lamps, factor)
    rows["times 1e-310 (subnormal)"] = partial(_solved, lamps, 1e-310)
    for brightness in (1e-12, 1e12, 1e-60, 1e60):
        rows[f"lamps times {brightness:.0e}"] = partial(_solved, brightness * lamps)
    rows["float32"] = partial(_solved, lamps, dtype=np.float32)
    some = np.zeros((COUNT, PIXELS))
    some[[1, 4, 7]] = 1
    rows["three of ten photos to be used"] = partial(_solved, lamps, weights=some)
    rows["lamps in a plane"] = partial(_solved, _flat(0.0))
    rows["one lamp for all photos"] = partial(_solved, np.repeat(lamps[:1], COUNT, axis=0))
    rows["one of three lamps 1e-12"] = partial(_solved, axes * [[1.0], [1.0], [1e-12]])
    rows["no photo to be used"] = partial(_solved, lamps, weights=0 * some)
    return rows


def _solved(
    lamps: Floats, factor: float = 1.0, weights: Floats | None = None, dtype: DTypeLike = np.float64
) -> Measured | Refused:
    """Compare with least squares in fractions; the gain reports the condition of the normal equations."""
    seen = _seen(lamps, factor, dtype)
    found, gain = scaled_normals(seen, lamps, weights)
    if np.isinf(gain).all():
        return Refused("noise gain: infinite")
    if np.isinf(gain).any():
        return Measured(np.inf, 0.0, None, "some pixels undetermined")
    used = slice(None) if weights is None else weights[:, 0] > 0
    right = np.stack([exact.longs(exact.least_squares(lamps[used], column[used])) for column in seen.T])
    condition = len(lamps[used]) * float(gain.max()) ** 2
    note = "condition reported: n times the square of the noise gain"
    return if_honest(rounded(found, right, condition, dtype, note), exact.condition_of(lamps[used]) ** 2)


def _of_pseudo_inverse() -> Rows:
    lamps = _lamps()
    rows: Rows = {"any lamps": partial(_inverted, lamps)}
    for distance in (1e-4, 1e-8, 1e-12):
        rows[f"lamps within {distance:.0e} of a plane"] = partial(_inverted, _flat(distance))
    for factor in (1e-12, 1e12):
        rows[f"times {factor:.0e}"] = partial(_inverted, lamps, factor)
        rows[f"lamps times {factor:.0e}"] = partial(_inverted, factor * lamps)
    one = np.ones((COUNT, 1))
    one[3] = 1e-12
    rows["one of ten lamps 1e-12"] = partial(_inverted, one * lamps)
    rows["float32"] = partial(_inverted, lamps, dtype=np.float32)
    rows["lamps in a plane"] = partial(_inverted, _flat(0.0))
    rows["one lamp for all photos"] = partial(_inverted, np.repeat(lamps[:1], COUNT, axis=0))
    return rows


def _inverted(lamps: Floats, factor: float = 1.0, dtype: DTypeLike = np.float64) -> Measured:
    """Compare with least squares in fractions, of least norm where the lamps leave a choice."""
    seen = _seen(lamps, factor, dtype)
    right = np.stack([exact.longs(exact.least_squares(lamps, column)) for column in seen.T])
    condition = exact.condition_of(lamps)
    return rounded(plain_least_squares(seen, lamps), right, condition, dtype, "condition of the lamps")


def _of_photographs() -> Rows:
    lamps = _lamps()
    rows: Rows = {"any lamps": partial(_photographed, lamps)}
    for factor in (1e-12, 1e12, 1e-30, 1e30):
        rows[f"times {factor:.0e}"] = partial(_photographed, lamps, factor)
    rows["float32"] = partial(_photographed, lamps, dtype=np.float32)
    rows["shadows"] = partial(_photographed, lamps, hidden=3)
    rows["one pixel"] = partial(_photographed, lamps, pixels=1)
    rows["lamps within 1e-04 of a plane"] = partial(_photographed, _flat(1e-4))
    rows["lamps in a plane"] = partial(_photographed, _flat(0.0))
    rows["black photos"] = partial(_photographed, lamps, 0.0)
    rows["an empty mask"] = partial(_photographed, lamps, mask=np.zeros((1, PIXELS), bool))
    rows["NaN"] = partial(_photographed, lamps, np.nan)
    return rows


def _photographed(
    lamps: Floats,
    factor: float = 1.0,
    dtype: DTypeLike = np.float64,
    hidden: int = 0,
    pixels: int = PIXELS,
    mask: Floats | None = None,
) -> Measured | Refused:
    """Compare the float32 surface with least squares in fractions over the photographs in which a pixel is lit."""
    seen = _seen(lamps, factor, dtype)[:, :pixels]
    seen[:hidden] = 0
    found = calibrated_stereo(seen[:, None], lamps, mask, saturation=np.inf)
    if not found.determined.any():
        return Refused("determined: nowhere")
    if factor == 0:
        return Measured(float(found.surface.albedo.max()), 0.0, None, "the albedo")
    right = np.stack([exact.longs(exact.least_squares(lamps[hidden:], column[hidden:])) for column in seen.T])
    ours = found.surface.normals[0] * found.surface.albedo[0, :, None].astype(np.longdouble)
    gain = float(scaled_normals(np.zeros((len(lamps) - hidden, 1)), lamps[hidden:])[1][0])
    condition = (len(lamps) - hidden) * gain**2
    size = float(np.abs(right).max())
    error = float(np.abs(ours - right).max() / size)
    allowed = CONSTANT * (unit(size, np.float32) + condition * unit(size, dtype))
    return Measured(error, allowed, condition, "condition: n times the square of the noise gain; the result is float32")


def _of_general_light() -> Rows:
    rows: Rows = {"any lights": partial(_under_skies)}
    for factor in (1e-12, 1e12):
        rows[f"times {factor:.0e}"] = partial(_under_skies, factor)
    rows["one light for all photos"] = partial(_under_skies, alike=True)
    return rows


def _under_skies(factor: float = 1.0, alike: bool = False) -> Measured:
    """Compare normals under light from everywhere with those that were photographed."""
    lights = np.random.default_rng(2).normal(size=(COUNT, 9)) + 6 * np.eye(9)[0]
    lights = np.repeat(lights[:1], COUNT, axis=0) if alike else lights
    albedo = np.linalg.norm(_scaled(), axis=1)
    normals = _scaled() / albedo[:, None]
    seen = factor * (lights.astype(np.longdouble) @ exact_harmonics.harmonic_pictures(normals, albedo))
    found = general_light_normals(seen.astype(np.float64), lights)
    ours = found.scaled / np.linalg.norm(found.scaled, axis=1, keepdims=True)
    error = np.linalg.norm(ours - normals, axis=1)
    allowed = SURE * np.radians(found.confidence) + CONSTANT * SETTLED
    note = "in three stated errors and what the search calls settled"
    return Measured(float((error / allowed).max()), 1.0, None, note)


def _factored(lamps: Floats, factor: float = 1.0, dtype: DTypeLike = np.float64) -> Measured:
    """Compare the product of the factors with the photographs: both are of rank three."""
    seen = _seen(lamps, factor, dtype)
    found = linear_factors(seen)
    gain = float(scaled_normals(np.zeros((len(lamps), 1)), found.lights)[1][0])
    values = exact.singular_values(seen)
    condition = len(lamps) * gain**2 * float(values[0] / values[2]) ** 2
    made = found.lights @ found.scaled.T
    return rounded(made, seen, condition, dtype, "condition of the Gram matrix and of the lamps that were found")
