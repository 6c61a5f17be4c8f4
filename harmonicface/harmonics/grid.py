"""Grids on the sphere: rows of constant z, uniform azimuths, and harmonics on them by separability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_legendre

from harmonicface import _memory, _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._blocks import recursion
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count

Floats64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SphereGrid:
    """Directions on rows of constant z, each row with the same uniform azimuths 2 pi j / columns, and their weights.

    Made by `sphere_grid` (exact) or `latlong_grid`.

    Parameters
    ----------
    z
        (rows,) cosines of the polar angle.
    row_weights
        (rows,) weight of each direction of the row; all weights sum to 4 pi.
    columns
        How many azimuths there are, at least 1.

    Raises
    ------
    HarmonicFaceError
        No numbers, arrays of other shapes, z beyond -1 to 1, weights that are NaN or infinite, no column.
    """

    z: Floats64
    row_weights: Floats64
    columns: int

    def __post_init__(self) -> None:
        for name in ("z", "row_weights"):  # lists become arrays
            array = np.asarray(_validate.floats(getattr(self, name), name), np.float64)
            object.__setattr__(self, name, array)
        if self.z.ndim != 1 or self.z.shape != self.row_weights.shape or not (np.abs(self.z) <= 1).all():
            raise HarmonicFaceError(
                f"grid: expected rows of z from -1 to 1 and as many weights, got shapes {self.z.shape} and "
                f"{self.row_weights.shape}"
            )
        _validate.finite(self.row_weights, "row_weights")
        _validate.at_least(self.columns, 1, "columns")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return len(self.z), self.columns

    @property
    def azimuths(self) -> Floats64:
        """Azimuth of each column in radians, (columns,)."""
        return 2 * np.pi * np.arange(self.columns) / self.columns

    @property
    def directions(self) -> Floats64:
        """Unit vectors (rows * columns, 3), row by row."""
        across = np.sqrt((1 - self.z) * (1 + self.z))[:, None]
        result = np.empty((*self.shape, 3))
        result[..., 0] = across * np.cos(self.azimuths)
        result[..., 1] = across * np.sin(self.azimuths)
        result[..., 2] = self.z[:, None]
        return result.reshape(-1, 3)

    @property
    def weights(self) -> Floats64:
        """Quadrature weight of each direction, (rows * columns,); a function's integral is `weights @ values`."""
        return np.repeat(self.row_weights, self.columns)


def expect_grid(grid: SphereGrid) -> SphereGrid:
    """Return a grid if it is one."""
    if not isinstance(grid, SphereGrid):
        raise HarmonicFaceError(f"grid: expected a SphereGrid, got {_validate.describe(grid)}")
    return grid


def sphere_grid(order: int) -> SphereGrid:
    r"""Return the grid that integrates every product of two harmonics up to an order exactly.

    .. math:: \int f = \sum_{ij} w_i \frac{2\pi}{2N+1} f(z_i, \phi_j), \qquad z_i, w_i: \text{Gauss-Legendre}, \;
              i \le N + 1, \; j \le 2N + 1

    It is exact for polynomials up to degree 2N in x, y, z (Driscoll & Healy, Computing Fourier transforms and
    convolutions on the 2-sphere, 1994, with Gauss's nodes instead of uniform ones).

    Parameters
    ----------
    order
        N, at least 0.

    Returns
    -------
    SphereGrid
        (N + 1) x (2N + 1) directions with weights.

    Raises
    ------
    HarmonicFaceError
        A negative order, a grid larger than the memory.

    Examples
    --------
    >>> grid = sphere_grid(2)
    >>> grid.shape, round(float(grid.weights @ grid.directions[:, 0] ** 4), 6)  # 4 pi / 5
    ((3, 5), 2.513274)
    """
    rows = _validate.at_least(order, 0, "order") + 1
    _memory.require(8 * max(8 * rows * (2 * rows - 1), rows**2), f"the grid of order {order}")
    z = roots_legendre(rows)[0][::-1].copy()
    columns = 2 * rows - 1
    return SphereGrid(z, 1 / (columns * _zonal_energy(z, order)), columns)


def _zonal_energy(z: Floats64, order: int) -> Floats64:
    r"""Return \sum_l Y_l0(z)^2 up to an order: at Gauss's nodes, one over their weights for the sphere.

    Weights so found (Christoffel's) keep harmonics of order 200 orthonormal to 3e-14; those of the usual routines,
    from the derivative at the node, to 1e-12.
    """
    below, current = np.zeros_like(z), np.full_like(z, math.sqrt(1 / (4 * math.pi)))
    energy = current**2
    for degree in range(1, order + 1):
        step, back = recursion(degree, 0)
        below, current = current, step * (z * current - back * below)
        energy += current**2
    return energy


def latlong_grid(rows: int, columns: int) -> SphereGrid:
    """Return the latitude-longitude grid: equal steps of the polar angle, weights that are the cells' solid angles.

    Not exact, but what panoramas are sampled on: the error of an integral falls as 1 / rows^2.

    Parameters
    ----------
    rows, columns
        Its size, each at least 1; the first row is the one nearest +z.

    Returns
    -------
    SphereGrid
        rows x columns directions with weights.

    Raises
    ------
    HarmonicFaceError
        Fewer rows or columns, a grid larger than the memory.

    Examples
    --------
    >>> round(float(latlong_grid(16, 32).weights.sum() / np.pi), 6)
    4.0
    """
    _memory.require(
        64 * _validate.at_least(rows, 1, "rows") * _validate.at_least(columns, 1, "columns"),
        f"a grid of {rows} x {columns} directions",
    )
    edges = np.cos(np.pi * np.arange(rows + 1) / rows)
    return SphereGrid(np.cos(np.pi * (np.arange(rows) + 0.5) / rows), -np.diff(edges) * (2 * np.pi / columns), columns)


def harmonics_on_grid(grid: SphereGrid, order: int) -> Floats64:
    """Evaluate the real harmonics on a grid, one product of a row's and a column's factor each.

    Parameters
    ----------
    grid
        From `sphere_grid` or `latlong_grid`.
    order
        The highest degree l, at least 0.

    Returns
    -------
    array
        ((order + 1)^2, rows, columns), what `real_harmonics` gives at `grid.directions`.

    Raises
    ------
    HarmonicFaceError
        No grid, a negative order, a result larger than the memory.

    Examples
    --------
    >>> harmonics_on_grid(sphere_grid(1), 1)[:, 0, 0].round(4)
    array([0.2821, 0.    , 0.2821, 0.3989])
    """
    expect_grid(grid)
    result = _memory.empty((count(order), *grid.shape), np.float64, f"harmonics of order {order} on {grid.shape}")
    along = meridian(grid, order)
    for mode in range(order + 1):
        cosines, sines = np.cos(mode * grid.azimuths), np.sin(mode * grid.azimuths)
        for degree in range(mode, order + 1):
            centre = degree * (degree + 1)
            factor = along[centre + mode][:, None]
            np.multiply(factor, cosines, out=result[centre + mode])
            if mode:
                np.multiply(factor, sines, out=result[centre - mode])
    return result


def meridian(grid: SphereGrid, order: int) -> Floats64:
    """Return the harmonics of each row at azimuth 0: its factor in z, at m >= 0."""
    across = np.sqrt((1 - grid.z) * (1 + grid.z))
    towards = np.stack([across, np.zeros_like(across), grid.z], axis=-1)
    return real_harmonics(towards, order).astype(np.float64, copy=False)
