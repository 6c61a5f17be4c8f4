"""Projection onto harmonics by exact quadrature on Gauss-Legendre by uniform grids, and its inverse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.grid import SphereGrid, expect_grid, meridian, sphere_grid
from harmonicface.harmonics.indexing import count, order_of
from harmonicface.harmonics.scattered import fit

__all__ = ["SphereGrid", "fit", "project", "sphere_grid", "synthesize"]

Floats64 = NDArray[np.float64]


def project(
    function: Callable[[Floats64], ArrayLike] | ArrayLike, order: int, grid: SphereGrid | None = None
) -> Floats64:
    r"""Return the real harmonic coefficients of a function, f_lm = \int f Y_lm, by quadrature.

    Exact to rounding for a function of degree N on `sphere_grid(M)` if N + order <= 2 M; else what lies beyond
    aliases into the answer, and a finer grid helps. Rows are transformed first, then columns, so the cost is of the
    order cubed, not to the fourth.

    Parameters
    ----------
    function
        A function of (n, 3) directions that returns (n,) or (n, channels) values; or the values at
        `grid.directions`, (n,) or (n, channels), or as (rows, columns) or (rows, columns, channels).
    order
        The highest degree l, at least 0.
    grid
        Where to sample, or where it was sampled; `sphere_grid(order)` if not given.

    Returns
    -------
    array
        ((order + 1)^2,) or ((order + 1)^2, channels) coefficients.

    Raises
    ------
    HarmonicFaceError
        No grid, values that are not finite or do not fit the grid, an order that the grid's columns cannot tell apart.

    Examples
    --------
    >>> project(lambda n: 1 + n[:, 2], order=1).round(4) + 0.0
    array([3.5449, 0.    , 2.0467, 0.    ])
    """
    grid = sphere_grid(order) if grid is None else expect_grid(grid)
    size = count(order)
    if 2 * order + 1 > grid.columns:
        raise HarmonicFaceError(
            f"grid: expected at least {2 * order + 1} columns for order {order}, got {grid.columns}"
        )
    samples = _samples(function(grid.directions) if callable(function) else function, grid)
    channels = samples.shape[2:]
    along = meridian(grid, order)
    weighted = grid.row_weights[:, None] * samples.reshape(len(grid.z), -1)
    spectrum = np.fft.rfft(weighted.reshape(*grid.shape, -1), axis=1)  # sums with exp(-i m phi)
    result = np.zeros((size, spectrum.shape[2]))
    for mode in range(order + 1):
        degree = np.arange(mode, order + 1)
        centre = degree * (degree + 1)
        parts = along[centre + mode] @ spectrum[:, mode]
        result[centre + mode] = parts.real
        if mode:
            result[centre - mode] = -parts.imag
    return result.reshape(size, *channels)


def synthesize(coefficients: ArrayLike, grid: SphereGrid) -> Floats64:
    """Evaluate the function of given real harmonic coefficients on a grid, the inverse of `project`.

    Parameters
    ----------
    coefficients
        ((order + 1)^2,) or ((order + 1)^2, channels).
    grid
        From `sphere_grid` or `latlong_grid`, of any size.

    Returns
    -------
    array
        (rows, columns) or (rows, columns, channels) values.

    Raises
    ------
    HarmonicFaceError
        No grid, a count that is not a square number, NaN or infinity, values larger than the memory.

    Examples
    --------
    >>> synthesize([1.0, 0.0, 0.0, 0.0], sphere_grid(1)).round(4)
    array([[0.2821, 0.2821, 0.2821],
           [0.2821, 0.2821, 0.2821]])
    """
    given = _validate.finite(coefficients, "coefficients")
    if given.ndim not in (1, 2):
        raise HarmonicFaceError(f"coefficients: expected shape (k,) or (k, channels), got {given.shape}")
    expect_grid(grid)
    order = order_of(len(given))
    columns = given.reshape(len(given), -1)
    _memory.require(24 * columns.shape[1] * grid.columns * len(grid.z), f"values on a grid of {grid.shape}")
    values = np.zeros((*grid.shape, columns.shape[1]))
    along = meridian(grid, order)
    for mode in range(order + 1):
        degree = np.arange(mode, order + 1)
        centre = degree * (degree + 1)
        row_factors = along[centre + mode].T
        values += np.cos(mode * grid.azimuths)[:, None] * (row_factors @ columns[centre + mode])[:, None]
        if mode:
            values += np.sin(mode * grid.azimuths)[:, None] * (row_factors @ columns[centre - mode])[:, None]
    return values.reshape(*grid.shape, *given.shape[1:])


def _samples(values: ArrayLike, grid: SphereGrid) -> Floats64:
    """Return values as (rows, columns) or (rows, columns, channels)."""
    array: Floats64 = np.asarray(_validate.finite(values, "values"), np.float64)
    total = len(grid.z) * grid.columns
    if array.ndim in (1, 2) and len(array) == total:
        return array.reshape(*grid.shape, *array.shape[1:])
    if array.ndim in (2, 3) and array.shape[:2] == grid.shape:
        return array
    raise HarmonicFaceError(
        f"values: expected one a direction, {total} or {grid.shape} and channels, got {_validate.describe(array)}"
    )
