"""How much any linear map lets through: singular values, numerical rank and condition of a kernel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.quadrature import sphere_grid
from harmonicface.reflectance._arguments import numbers

LARGEST_GRID = 4096  # directions of a square kernel: 128 megabytes, and half a minute for its singular values


@dataclass(frozen=True, eq=False)
class KernelRank:
    """What a kernel lets through.

    Attributes
    ----------
    singular_values
        All of them, largest first.
    tolerance
        What counts as nothing, as a fraction of the largest.
    """

    singular_values: NDArray[np.float64]
    tolerance: float

    @property
    def rank(self) -> int:
        """How many singular values exceed the tolerance: the unknowns that can be found to that relative noise."""
        return int((self.singular_values > self.tolerance * self.singular_values[0]).sum())

    @property
    def condition(self) -> float:
        """The largest singular value over the smallest of them all; infinite where the kernel is degenerate."""
        least = self.singular_values[-1]
        return float(self.singular_values[0] / least) if least > 0 else math.inf

    @property
    def kept_condition(self) -> float:
        """The largest singular value over the smallest within the rank; infinite for a kernel of nothing."""
        return float(self.singular_values[0] / self.singular_values[self.rank - 1]) if self.rank else math.inf

    def __str__(self) -> str:
        return (
            f"rank {self.rank} of {len(self.singular_values)} at tolerance {self.tolerance:g}, "
            f"condition {self.condition:.3g} ({self.kept_condition:.3g} within the rank)"
        )


def kernel_rank(
    kernel: ArrayLike,
    tolerance: float = 1e-6,
    row_weights: ArrayLike | None = None,
    column_weights: ArrayLike | None = None,
) -> KernelRank:
    r"""Return singular values, numerical rank and condition of a sampled kernel.

    .. math:: b(s) = \int K(s, t) f(t) \, dt = \sum_i \sigma_i u_i(s) \langle v_i, f \rangle

    a Fredholm equation of the first kind (Ramamoorthi & Hanrahan 2004, equations 60 and 61). With the weights of a
    quadrature the singular values are those of the integral operator, sqrt(w_s) K sqrt(w_t), and do not depend on how
    densely it is sampled. Without them they are the matrix's own. f is recoverable along v_i to noise / sigma_i.

    Parameters
    ----------
    kernel
        (rows, columns) values K(s, t), real or complex.
    tolerance
        What counts as nothing, as a fraction of the largest singular value: the relative noise of b.
    row_weights, column_weights
        (rows,) and (columns,) non-negative weights of the quadrature in s and in t.

    Returns
    -------
    KernelRank

    Raises
    ------
    HarmonicFaceError
        A kernel that is no finite matrix, a tolerance that is no fraction, weights that are negative or do not fit.

    Examples
    --------
    >>> print(kernel_rank([[1.0, 1.0], [1.0, 1.0]]))
    rank 1 of 2 at tolerance 1e-06, condition ... (1 within the rank)
    """
    matrix = numbers(kernel, "kernel")
    if matrix.ndim != 2 or matrix.size == 0:
        raise HarmonicFaceError(f"kernel: expected a matrix, got {_validate.describe(matrix)}")
    if row_weights is not None:
        matrix = _roots(row_weights, len(matrix), "row_weights")[:, None] * matrix
    if column_weights is not None:
        matrix = matrix * _roots(column_weights, matrix.shape[1], "column_weights")
    values = np.linalg.svd(matrix, compute_uv=False)
    return KernelRank(np.asarray(values, np.float64), _validate.fraction(tolerance, "tolerance"))


def sphere_kernel_rank(
    kernel: Callable[[Floats, Floats], Floats],
    order: int,
    tolerance: float = 1e-6,
) -> KernelRank:
    r"""Return singular values, rank and condition of a kernel between two directions, sampled on a quadrature.

    The grid (Gauss-Legendre in height, uniform around) integrates products of two harmonics up to the order exactly,
    so a kernel without degrees beyond it has its exact singular values: |f_l|, each 2l + 1 times, for a material's
    filter f_l; of a kernel with a kink, such as the clamped cosine, they come near as the order grows.

    Parameters
    ----------
    kernel
        K(s, t) of directions (rows, 1, 3) and (1, columns, 3), vectorized: (rows, columns).
    order
        The highest degree of the kernel in either direction; (order + 1) (2 order + 1) directions are taken.
    tolerance
        What counts as nothing, as a fraction of the largest singular value.

    Raises
    ------
    HarmonicFaceError
        A negative order or one with a grid beyond 4096 directions, a kernel that is no function or whose values
        do not fit.

    Examples
    --------
    >>> cosine = sphere_kernel_rank(lambda s, t: np.einsum("...i,...i->...", s, t), order=1)
    >>> cosine.rank, cosine.singular_values[:3].round(4)
    (3, array([4.1888, 4.1888, 4.1888]))
    """
    size = (_validate.at_least(order, 0, "order") + 1) * (2 * order + 1)
    if size > LARGEST_GRID:
        raise HarmonicFaceError(f"order: expected a grid of at most {LARGEST_GRID} directions, got {size} at {order}")
    if not callable(kernel):
        raise HarmonicFaceError(f"kernel: expected a function of two directions, got {_validate.describe(kernel)}")
    grid = sphere_grid(order)
    directions, shares = grid.directions, grid.weights
    values = np.asarray(kernel(directions[:, None], directions[None]))
    if values.shape != (len(directions), len(directions)):
        expected = (len(directions), len(directions))
        raise HarmonicFaceError(f"kernel: expected values of shape {expected}, got {_validate.describe(values)}")
    return kernel_rank(values, tolerance, shares, shares)


def _roots(weights: ArrayLike, size: int, name: str) -> NDArray[np.float64]:
    """Return the square roots of non-negative weights, one a sample."""
    values = _validate.finite(weights, name)
    if values.shape != (size,) or (values < 0).any():
        raise HarmonicFaceError(f"{name}: expected {size} weights of at least 0, got {_validate.describe(values)}")
    return np.sqrt(values, dtype=np.float64)
