"""Rows of the stability table: principal components of all pictures of a surface, without rendering one."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import DTypeLike, NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.principal import analytic_pca
from harmonicface.bench.stability import exact, exact_harmonics
from harmonicface.bench.stability.inverse_light import spread
from harmonicface.bench.stability.row import CONSTANT, Answers, Measured, Rows, named, unit
from harmonicface.surfaces.surface import Surface

COUNT = 100
ORDER = 2


def of_principal() -> Answers:
    """Return a function for each row."""
    half = spread(np.pi / 2, COUNT)
    rows: Rows = {"a ball": partial(_components, half)}
    rows["a ball, float32"] = partial(_components, half, dtype=np.float32)
    for factor in (1e-12, 1e12, 1e-100, 1e100):
        rows[f"albedo times {factor:.0e}"] = partial(_components, half, 0.7 * factor)
    rows["every other pixel black"] = partial(_components, half, black=True)
    rows["every pixel twice"] = partial(_components, np.repeat(half[::2], 2, axis=0))
    for angle, case in ((0.1, "0.1"), (1e-2, "1e-02"), (1e-4, "1e-04"), (1e-8, "1e-08")):
        rows[f"normals within {case}"] = partial(_components, spread(angle, COUNT))
    rows["a wall"] = partial(_components, np.tile([0.0, 0.0, 1.0], (COUNT, 1)))
    rows["one pixel"] = partial(_components, half[:1])
    rows["no albedo"] = partial(_components, half, 0.0)
    rows["an empty mask"] = partial(_components, half, mask=np.zeros((1, COUNT), bool))
    rows["no components"] = partial(_components, half, wanted=0)
    return named("analytic_pca", rows)


def _components(
    normals: Floats,
    albedo: float = 0.7,
    black: bool = False,
    dtype: DTypeLike = np.float64,
    mask: NDArray[np.bool_] | None = None,
    wanted: int = 8,
) -> Measured:
    """Compare variances with singular values in decimals, and how exact pictures vary along the components."""
    shades = np.full(len(normals), albedo, dtype)
    shades[::2] *= not black
    given = normals.astype(dtype)
    found = analytic_pca(Surface(given[None], shades[None], mask), wanted, ORDER)
    pictures = exact_harmonics.harmonic_pictures(given, shades)[1:]  # of degree 0 every lamp has as much
    values = exact.singular_values(pictures.astype(np.float64))
    right = values**2 / (4 * exact_harmonics.PI)
    kept = len(found.variances)
    # what was left out must be rounding as well
    off = np.abs(np.pad(found.variances.astype(np.longdouble), (0, len(right) - kept)) - right).max() / right[0]
    condition = float(found.variances[0] / found.variances[-1])
    components = found.components.astype(np.longdouble)
    turned = float(np.abs(components @ components.T - np.eye(kept)).max())
    # how the exact pictures vary along the components that were found: apart from each other, each as it should
    along = pictures @ components.T
    mixed = float(np.abs(along.T @ along / (4 * exact_harmonics.PI) - np.diag(right[:kept])).max() / right[0])
    note = (
        "variances, of the largest; components off orthonormal, and mixed, over the condition: the first over the last"
    )
    error = max(float(off), max(turned, mixed) / condition)
    return Measured(error, CONSTANT * unit(float(right[0]), dtype), condition, note)
