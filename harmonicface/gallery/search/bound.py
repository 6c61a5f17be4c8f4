r"""How much of a photograph a person can explain at most, from her sketch.

Let Q be an orthonormal basis of her span, (r, p), and U the shared basis, (m, p). A unit photograph is y = U^T a + z
with U z = 0 and |z| <= rho. With C = Q U^T and the stored B, which is C rounded,

    Q y = C a + (Q - C U) z = B a + (C - B) a + R z,   R = Q - C U,   R R^T = I - C C^T.

Q is turned so that I - C C^T = diag(s_k^2). Then R z = S t with t = S^{-1} R z, and |t| <= |z| <= rho because S^{-1} R
has orthonormal rows (a row with s_k = 0 is 0). The products are b = B a + rounding. With |a| <= 1 both roundings
together are at most a known doubt delta, so

    |Q y| <= max_{|t| <= rho} |b + S t| + delta.

The maximum of the square is at most V(lambda) for *any* lambda above all s_k^2 (weak duality of the trust region):

    |b + S t|^2 <= sum_k (b_k + s_k t_k)^2 + lambda (rho^2 - |t|^2)
                <= |b|^2 + lambda rho^2 + sum_k b_k^2 s_k^2 / (lambda - s_k^2) = V(lambda),

and the smallest V is the maximum itself. With lambda = max_k s_k^2 + |S b| / rho, V is at most

    |b|^2 + 2 rho |S b| + rho^2 max_k s_k^2,

which needs one more product: `plain`. `sharp` takes a few steps of Newton's method towards the best lambda from there.
Strong modes have small s_k: that is why both are far below the bound (|b| + rho max_k s_k)^2 of the spectral norm.

Larger s_k and rho only make the bound larger, so they may be rounded up. All terms are sums, products, quotients and
roots of numbers that are not negative, and the one difference, lambda - s_k^2, is between two stored numbers; so
float32 errs by at most r + `OPERATIONS` units of the result, and twice as many are added.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search.shared_basis import UNIT_ROUNDING

Array = NDArray[np.float32]
SINGLE = np.float32(2.0**-24)
OPERATIONS = 24  # roundings behind a bound, beside one for each row
LEAST_GAP = np.float32(1e-6)  # so that lambda, at most about 1, differs from s^2 in float32
TINY = np.float32(1e-30)  # above what underflow loses


def inflation(rank: int) -> np.float32:
    """Return what the square of a bound over so many rows is multiplied by, for float32."""
    return np.float32(1 + 2 * (rank + OPERATIONS) * SINGLE)


def plain(products: Array, squares: Array, largest: Array, remainders: Array) -> tuple[Array, Array]:
    r"""Return |b|^2 and |b|^2 + 2 rho |S b| + rho^2 max s^2, of each person.

    Parameters
    ----------
    products
        (n, r, ...) b.
    squares
        (n, r) or (n, r, 1) s^2, broadcast against the products.
    largest
        (n,) or (n, 1) the largest s^2 of each person.
    remainders
        (n,) or (...) rho, rounded up.
    """
    energies = np.square(products)
    explained = _summed(energies)
    mixed = _summed(np.multiply(energies, squares, out=energies))
    bound = explained + 2 * remainders * np.sqrt(mixed) + np.square(remainders) * largest + TINY
    return explained, np.asarray(bound * inflation(products.shape[1]), np.float32)


def _summed(array: Array) -> Array:
    """Return the sum over the second axis; numpy is slow where that is the last and short."""
    return np.asarray(array @ np.ones(array.shape[1], np.float32) if array.ndim == 2 else array.sum(axis=1))


def sharp(products: Array, squares: Array, remainders: Array, steps: int = 2) -> Array:
    """Return the least V(lambda) that a few steps find, of each person: (n,) from (n, r) b, (n, r) s^2 and (n,) rho."""
    energies = np.square(products)
    crossed = energies * squares
    explained, largest = _summed(energies), squares.max(axis=1)
    radius = np.maximum(remainders, np.float32(1e-12))
    squared = np.square(radius)
    beyond = np.maximum(np.sqrt(_summed(crossed)) / radius, LEAST_GAP)
    best = np.full(len(products), np.float32(np.inf))
    for step in range(steps + 1):
        multiplier = largest + beyond
        gaps = multiplier[:, None] - squares
        quotients = crossed / gaps
        best = np.minimum(best, explained + multiplier * squared + _summed(quotients))
        if step < steps:
            quotients /= gaps
            slope = squared - _summed(quotients)
            quotients /= gaps
            curvature = 2 * _summed(quotients)
            beyond = np.maximum(beyond - slope / np.maximum(curvature, TINY), np.maximum(beyond / 2, LEAST_GAP))
    return (best + TINY) * inflation(products.shape[1])


def least_closeness(distance: float, pixels: int, rank: int) -> float:
    r"""Return the |Q y|^2 that a person must be able to reach to have a distance of at most so much.

    `Subspace.distance` computes |y - P (2 - P) y| with P = Q^T Q of the stored rows. Even if these are not quite
    orthonormal, the part of y off their span passes unchanged, so the distance is at least \sqrt{|y|^2 - |Q y|^2} with
    orthonormal Q of the same span, less its rounding in float64.
    """
    rounding = 16 * (pixels + rank) * rank * UNIT_ROUNDING
    return (1 - rounding) - (distance + rounding) ** 2
