"""Rows of the stability table: factors of photographs, and light and material from a light field."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import DTypeLike, NDArray

from harmonicface._validate import Floats
from harmonicface.bench.stability import exact, exact_harmonics
from harmonicface.bench.stability.row import CONSTANT, Answers, Measured, Rows, if_honest, named, unit
from harmonicface.reflectance.factorization import factor_light_field
from harmonicface.stereo.factors import leading_factors

COUNT, PIXELS = 8, 50


def of_photographs() -> Answers:
    """Return a function for each row of `leading_factors`."""
    rows: Rows = {}
    for share in (1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-14):
        rows[f"a third value of {share:.0e}"] = partial(_factored, _photographs(share))
    rows["a third value of 0"] = partial(_factored, _photographs(0.0))
    for share in (1e-2, 1e-4):
        rows[f"a third value of {share:.0e}, float32"] = partial(_factored, _photographs(share, np.float32))
    rows["a third value of 1e-04, read once"] = partial(_factored, _photographs(1e-4), once=True)
    for factor in (1e-12, 1e12, 1e-200, 1e200):
        rows[f"times {factor:.0e}"] = partial(_factored, factor * _photographs(0.1))
    for factor in (1e-30, 1e30):
        rows[f"float32, times {factor:.0e}"] = partial(_factored, (factor * _photographs(0.1)).astype(np.float32))
    rows["every photo twice"] = partial(_factored, np.repeat(_photographs(0.1)[::2], 2, axis=0))
    rows["one pixel"] = partial(_factored, _photographs(0.1)[:, :1], rank=1)
    rows["two of three factors"] = partial(_factored, _photographs(0.1), rank=2)
    rows["black photos"] = partial(_factored, np.zeros((COUNT, PIXELS)))
    rows["no pixels"] = partial(_factored, np.zeros((COUNT, 0)))
    rows["NaN"] = partial(_factored, np.full((COUNT, PIXELS), np.nan))
    return named("leading_factors", rows)


def _photographs(share: float, dtype: DTypeLike = np.float64) -> Floats:
    """Return photographs of three factors, the third so much weaker than the first."""
    random = np.random.default_rng(0)
    left = np.linalg.qr(random.normal(size=(COUNT, 3)))[0]
    right = np.linalg.qr(random.normal(size=(PIXELS, 3)))[0]
    return np.asarray((left * [1.0, 0.5, share]) @ right.T, dtype)


def _factored(photographs: Floats, rank: int = 3, once: bool = False) -> Measured:
    """Compare singular values, and the product of the factors, with those of decimals of 120 digits."""
    found = leading_factors(iter([photographs]) if once else photographs, rank)
    size = float(np.abs(photographs).max())
    if size == 0:
        return Measured(float(found.singular_values.max()), 0.0, found.condition, "absolute")
    values = exact.singular_values(photographs)[: len(found.singular_values)]
    off = np.abs(found.singular_values[:rank] - values[:rank]).max() / values[0]
    if found.right is not None:
        made = found.left @ found.right
        beyond = float(np.sqrt((values[rank:] ** 2).sum())) if rank < len(values) else 0.0
        excess = np.linalg.norm((made - photographs.astype(np.longdouble)).astype(np.longdouble) / size) * size
        off = max(float(off), max(float(excess) - beyond, 0.0) / float(values[0]))
    precision = unit(float(values[0]), photographs.dtype)
    note = "of the largest singular value; condition reported"
    measured = Measured(float(off), CONSTANT * found.condition * precision, found.condition, note)
    # a factor within the rounding of the photographs themselves has no condition
    true = float(values[0] / max(values[rank - 1], values[0] * np.longdouble(CONSTANT * precision)))
    return if_honest(measured, true)


def of_light_fields() -> Answers:
    """Return a function for each row of `factor_light_field`."""
    rows: Rows = {"any light": partial(_told_apart)}
    for factor in (1e-12, 1e12, 1e-200, 1e200):
        rows[f"times {factor:.0e}"] = partial(_told_apart, factor)
    for share in (1e-4, 1e-10, 1e-14):
        rows[f"light of degree 2 times {share:.0e}"] = partial(_told_apart, second=share)
    rows["a BRDF of 1e-04 at l = 2"] = partial(_told_apart, material=1e-4)
    rows["no light of degree 2"] = partial(_told_apart, second=0.0)
    rows["no light of degree 0"] = partial(_told_apart, constant=0.0)
    rows["dark"] = partial(_told_apart, 0.0)
    rows["NaN"] = partial(_told_apart, np.nan)
    return named("factor_light_field", rows)


def _told_apart(factor: float = 1.0, second: float = 1.0, constant: float = 1.0, material: float = 1.0) -> Measured:
    """Compare light and BRDF with those that the light field was made of, in extended precision."""
    random = np.random.default_rng(1)
    light = random.uniform(0.2, 0.5, 9).astype(np.longdouble)
    light[0] = constant
    light[4:] *= second
    brdf = random.uniform(0.5, 1.0, (3, 3, 3)).astype(np.longdouble)
    brdf = brdf + brdf.transpose(1, 0, 2)
    strength = np.array([1, 1, material])
    brdf *= (strength[:, None] * strength)[..., None]
    modes = np.arange(3)
    brdf *= modes <= np.minimum.outer(modes, modes)[..., None]
    degree = np.repeat(modes, 2 * modes + 1)
    norms = np.sqrt(4 * exact_harmonics.PI / (2 * degree + 1).astype(np.longdouble))
    field = factor * (norms * light)[:, None, None] * brdf[degree]
    found = factor_light_field(_in_complex_modes(field))
    weakest = min(np.abs(field[degree == each]).max() for each in range(3))
    condition = float(np.abs(field).max() / weakest)
    right, scale = light / light[0], 1 / np.sqrt(4 * np.pi)
    off = np.abs(found.light / scale - right).max()
    other = np.abs(found.brdf * scale - factor * light[0] * brdf).max() / np.abs(factor * light[0] * brdf).max()
    error = max(float(off), float(other))
    note = "of the largest coefficients; condition: the brightest over the faintest degree"
    return Measured(error, CONSTANT * condition * unit(1.0), condition, note)


def _in_complex_modes(field: Floats) -> NDArray[np.complexfloating]:
    """Return coefficients m of real harmonics as those of complex ones: (c_m -+ i c_-m) / sqrt 2, signs (-1)^m."""
    result = np.zeros(field.shape, np.complex128)
    for degree in range(3):
        centre = degree * (degree + 1)
        result[centre] = field[centre]
        for mode in range(1, degree + 1):
            cosine, sine = field[centre + mode] / np.sqrt(2), field[centre - mode] / np.sqrt(2)
            result[centre + mode] = (-1) ** mode * (cosine - 1j * sine)
            result[centre - mode] = cosine + 1j * sine
    return np.asarray(result)
