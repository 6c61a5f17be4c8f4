"""Rows of the stability table: light from a photograph of a known surface."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import DTypeLike

from harmonicface._validate import Floats
from harmonicface.appearance.inverse import LightEstimate, estimate_light
from harmonicface.appearance.nonnegative_light import nonnegative_light
from harmonicface.bench.stability import exact, exact_harmonics
from harmonicface.bench.stability.row import CONSTANT, SURE, Answers, Measured, Rows, if_honest, named, unit
from harmonicface.surfaces.surface import Surface

SIDE = 16
LIGHT = np.array([1.0, 0.3, -0.4, 0.5, 0.1, -0.2, 0.3, 0.1, -0.1])
TRUSTED = 0.5  # of the ambient light: what `estimate_light` calls determined
LAMPS = np.array([[0.0, 0, 1], [1, 0, 1], [-1, 0, 1], [0, 1, 1], [0, -1, 1], [1, 1, 0.5]])


def of_inverse_light() -> Answers:
    """Return a function for each row."""
    return {**named("estimate_light", _of_harmonics()), **named("nonnegative_light", _of_lamps())}


def _of_harmonics() -> Rows:
    everywhere, half = spread(np.pi), spread(np.pi / 2)
    rows: Rows = {"all normals": partial(_estimated, everywhere)}
    rows["all normals, float32"] = partial(_estimated, everywhere, dtype=np.float32)
    rows["half of the sphere"] = partial(_estimated, half)
    for factor in (1e-12, 1e12, 1e-100, 1e100):
        rows[f"times {factor:.0e}"] = partial(_estimated, half, factor=factor)
    for factor in (1e-12, 1e12):
        rows[f"albedo times {factor:.0e}"] = partial(_estimated, half, albedo=factor)
    rows["every other pixel black"] = partial(_estimated, half, black=True)
    rows["noise of 1 %"] = partial(_estimated, everywhere, noise=0.01, stated=True)
    rows["a black photo"] = partial(_estimated, half, factor=0.0)
    rows["every pixel twice"] = partial(_estimated, np.repeat(spread(np.pi / 2)[::2], 2, axis=0))
    for angle in (0.1, 1e-2, 1e-4, 1e-8):
        case = f"{angle:.0e}" if angle < 0.1 else "0.1"
        rows[f"normals within {case}"] = partial(_estimated, spread(angle), stated=True)
    wall = np.tile([0.0, 0.0, 1.0], (SIDE * SIDE, 1))
    rows["a wall"] = partial(_estimated, wall, stated=True)
    rows["two normals"] = partial(_estimated, np.where(np.arange(len(wall))[:, None] % 2, half[9], wall), stated=True)
    rows["one pixel, its noise told"] = partial(_estimated, half[:1], stated=True, told=1e-3)
    rows["one pixel"] = partial(_estimated, half[:1], stated=True)
    rows["an empty mask"] = partial(_masked, np.zeros((SIDE, SIDE), bool))
    rows["all saturated"] = partial(_masked, None, 1e-9)
    rows["NaN"] = partial(_estimated, half, factor=np.nan)
    rows["no albedo"] = partial(_estimated, half, albedo=0.0)
    return rows


def spread(angle: float, count: int = SIDE * SIDE) -> Floats:
    """Return evenly spread normals up to an angle from the camera's axis, (n, 3)."""
    steps = (np.arange(count) + 0.5) / count
    polar, around = 2 * np.arcsin(np.sin(angle / 2) * np.sqrt(steps)), np.arange(count) * np.pi * (3 - np.sqrt(5))
    vectors = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=1)
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _grid(values: Floats) -> Floats:
    rows = SIDE if len(values) == SIDE * SIDE else 1
    return values.reshape(rows, -1, *values.shape[1:])


def _estimated(
    normals: Floats,
    factor: float = 1.0,
    albedo: float = 0.7,
    noise: float = 0.0,
    told: float | None = None,
    black: bool = False,
    stated: bool = False,
    dtype: DTypeLike = np.float64,
) -> Measured:
    """Compare with the light that the photograph was made with, in extended precision."""
    shades = np.full(len(normals), albedo)
    shades[::2] *= not black
    given, shades = normals.astype(dtype), shades.astype(dtype)
    seen = np.longdouble(factor) * (LIGHT @ exact_harmonics.harmonic_pictures(given, shades))
    seen += factor * noise * albedo * np.random.default_rng(0).normal(size=len(seen))
    surface = Surface(_grid(given), _grid(shades), np.ones(_grid(shades).shape, bool))
    found = estimate_light(_grid(seen.astype(dtype)), surface, noise=told)
    off = np.abs(found.coefficients - factor * LIGHT)
    if factor == 0:
        return Measured(float(off.max()), 0.0, found.condition, "absolute")
    if stated:
        return _as_stated(found, off)
    size = abs(factor) * float(np.abs(LIGHT).max())
    note = "condition reported: of the normal equations"
    allowed = CONSTANT * found.condition * unit(min(size, size * albedo), dtype)
    pictures = exact_harmonics.harmonic_pictures(given, shades).astype(np.float64)
    return if_honest(
        Measured(float(off.max()) / size, allowed, found.condition, note), exact.condition_of(pictures) ** 2
    )


def _as_stated(found: LightEstimate, off: Floats) -> Measured:
    """Compare errors with three of those that are stated; what is not said to be recoverable is no statement."""
    rounding = CONSTANT * 1e6**2 * np.finfo(float).eps  # of the least singular value that is not taken for 0
    allowed = SURE * np.hypot(found.std, found.systematic) + rounding
    sure = found.recoverable
    worst = [float((off[sure] / allowed[sure]).max(initial=0.0))]
    error = found.coefficients - LIGHT
    worst += [abs(float(mode.direction @ error)) / (SURE * TRUSTED * LIGHT[0]) for mode in found.determined]
    note = f"in three stated errors; {int(sure.sum())} coefficients, {len(found.determined)} modes said to be known"
    return Measured(max(worst), 1.0, None, note)


def _masked(mask: Floats | None, saturation: float = np.inf) -> Measured:
    surface = Surface(_grid(spread(np.pi / 2)), np.ones((SIDE, SIDE)))
    estimate_light(np.ones((SIDE, SIDE)), surface, mask=mask, saturation=saturation)
    return Measured(np.inf, 0.0, None, "answered")


def _of_lamps() -> Rows:
    rows: Rows = {"six lamps": partial(_lit, LAMPS)}
    for distance in (1e-2, 1e-4, 1e-8):
        rows[f"two lamps {distance:.0e} apart"] = partial(_lit, _two(distance))
    for factor in (1e-12, 1e12):
        rows[f"times {factor:.0e}"] = partial(_lit, LAMPS, factor)
    rows["a black photo"] = partial(_lit, LAMPS, 0.0)
    rows["one lamp twice"] = partial(_lit, np.concatenate([LAMPS[:3], LAMPS[2:3]]), strengths=False)
    rows["an empty mask"] = lambda: _lit(LAMPS, mask=np.zeros((SIDE, SIDE), bool))
    return rows


def _two(distance: float) -> Floats:
    return np.concatenate([LAMPS[:3], LAMPS[2:3] + np.array([0, distance, 0])])


def _lit(towards: Floats, factor: float = 1.0, mask: Floats | None = None, strengths: bool = True) -> Measured:
    """Compare strengths (or the irradiance where they are not unique) of lamps with those that shone."""
    lamps = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    normals = spread(np.pi / 2)
    pictures = 0.7 * np.maximum(normals.astype(np.longdouble) @ lamps.T.astype(np.longdouble), 0)
    shone = factor * (1 + np.arange(len(lamps)) / 2)
    seen = pictures @ shone
    surface = Surface(_grid(normals), np.full((SIDE, SIDE), 0.7))
    found = nonnegative_light(_grid(seen.astype(np.float64)), surface, lamps, mask=mask).light
    if factor == 0:
        return Measured(float(np.abs(found.irradiance(normals)).max()), 0.0, 1.0, "absolute")
    condition = exact.condition_of(pictures.astype(np.float64)) if strengths else 1.0
    if strengths:
        shares = np.array(
            [found.strengths[(np.abs(found.directions - lamp) < 1e-15).all(axis=1)].sum() for lamp in lamps]
        )
        error = float(np.abs(shares - shone).max() / shone.max())
        return Measured(error, CONSTANT * condition * unit(1.0), condition, "strengths; condition of the pictures")
    lit = 0.7 * found.irradiance(normals)
    error = float(np.abs(lit - seen).max() / seen.max())
    return Measured(error, CONSTANT * unit(1.0), 1.0, "the picture: the strengths are not unique")
