r"""How much of a photograph a person can explain at most, from her sketch.

Let Q be an orthonormal basis of her span, (r, p), and U the shared basis, (m, p). A unit photograph is y = U^T a + z
with U z = 0 and |z| <= rho. With C = Q U^T,

    Q y = C a + R z,   R = Q - C U,   R R^T = I - C C^T = G.

For any number l above all eigenvalues of G, l I - R^T R is positive definite, and for any b and z

    |b + R z|^2 <= max_z (|b + R z|^2 - l |z|^2) + l |z|^2 = b^T K b + l |z|^2,   K = (I - G / l)^{-1}:

the maximum is where (l I - R^T R) z = R^T b, and there it is |b|^2 + b^T R (l I - R^T R)^{-1} R^T b = b^T K b. So

    |Q y|^2 <= a^T C^T K C a + l rho^2 = |N a|^2 + l rho^2,   N = K^{1/2} C.

This holds for *every* l, also for one that is chosen before any photograph is seen; the smallest value over l is the
maximum over all z itself. `level` chooses l for photographs like the person's own, and N and l are kept.

Two ways to compute it. As <N^T N, a a^T> with the few first rows of the shared basis, where it is *one* product of
stored numbers with the products a_k a_l: this asks everybody about all photographs by one matrix product
(`quadratic`, `features`). And as |N a|^2 with more rows.

Rounding. Stored N differs from N by at most d in the Frobenius norm together with what float64 lost and what float32
products lose, gamma_n = n u / (1 - n u) times the lengths; as |N a| <= n, the square errs by at most 2 d n + 3 d^2.
The quadratic form errs by at most gamma_n |N^T N|_F. Roundings of the sums that follow are of numbers that are at most
n^2 + l. All of it together is the doubt, a number a person that is added to her bound; nothing is left to be considered
when photographs are compared (`whole_doubt`).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search.shared_basis import UNIT_ROUNDING

SINGLE = 2.0**-24  # the unit rounding of float32
NOISE = 0.01  # energy of the noise that photographs are expected to have; other noise makes the bound larger, not wrong
LEAST_GAP = 0.05  # of the largest eigenvalue, so that K is at most 21
TINY = 1e-7
TRIED = np.geomspace(0.2, 1, 12)


def level(eigenvalues: NDArray[np.float64], turns: NDArray[np.float64], unseen: float) -> float:
    r"""Return l, for which the bound is least for photographs like the person's own.

    Her photographs are taken to be Q^T c with E[c_k^2] falling as 1 / k^2, the strongest mode first, which is about
    what harmonic images have under natural light, and white noise. With the eigenvectors W of G the expected bound
    is \sum_k h_k l / (l - g_k) + l E[rho^2], h_k = (1 - g_k)^2 E[(W^T c)_k^2].

    Parameters
    ----------
    eigenvalues, turns
        (r,) g and (r, r) W.
    unseen
        Share of all directions that are not rows of the shared basis, 0 to 1.

    Examples
    --------
    >>> round(level(np.array([0.01, 0.3]), np.eye(2), 0.9), 3)
    0.995
    """
    energies = np.arange(1, len(eigenvalues) + 1.0) ** -2
    shares = np.square(turns).T @ (energies / energies.sum())
    crossed = np.square(1 - eigenvalues) * shares * eigenvalues
    left = float(eigenvalues @ shares) + NOISE * unseen + TINY
    largest = float(eigenvalues.max())
    # the minimum is at most here: the bound with all eigenvalues of the quotients replaced by the largest
    gaps = np.maximum(np.sqrt(crossed.sum() / left) * TRIED, LEAST_GAP * largest + TINY)
    expected = (crossed / (largest + gaps[:, None] - eigenvalues)).sum(axis=1) + gaps * left
    return largest + float(gaps[expected.argmin()])


def quadratic(folded: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the numbers whose product with `features` is |N a|^2: (m (m + 1) / 2,) from N, (r, m)."""
    gram = 2 * (folded.T @ folded)
    gram[np.diag_indices(len(gram))] /= 2
    return np.asarray(gram[_pairs(len(gram))])


@cache
def _pairs(count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return all k <= l below a number."""
    first, second = np.triu_indices(count)
    return first, second


def features(coordinates: NDArray[np.float32], left: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a_k a_l for k <= l, then rho^2 and 1: (m (m + 1) / 2 + 2, q) from (m, q) and (q,)."""
    first, second = _pairs(len(coordinates))
    products = coordinates[first] * coordinates[second]
    return np.concatenate([products, left[None], np.ones((1, len(left)), np.float32)])


def whole_doubt(lost: float, longest: float, beside: float, operations: int, highest: float) -> float:
    """Return what must be added to a bound for all rounding.

    Parameters
    ----------
    lost
        d, how far |N a| may be from what is computed.
    longest
        n, the most that |N a| can be.
    beside
        What the square may be wrong by, beside.
    operations
        Roundings of the sums after the products.
    highest
        l.
    """
    square = 2 * lost * longest + 3 * lost**2 + beside
    return 1.01 * (square + operations * SINGLE * ((longest + lost) ** 2 + highest + square)) + 1e-30


def gamma(operations: int) -> float:
    """Return what so many roundings of float32 in a row lose at most, relative to what is summed."""
    loss = operations * SINGLE
    return loss / (1 - loss) if loss < 1 else float("inf")


def least_closeness(distance: float, pixels: int, rank: int) -> float:
    r"""Return the |Q y|^2 that a person must be able to reach to have a distance of at most so much.

    `Subspace.distance` computes |y - P (2 - P) y| with P = Q^T Q of the stored rows. Even if these are not quite
    orthonormal, the part of y off their span passes unchanged, so the distance is at least \sqrt{|y|^2 - |Q y|^2} with
    orthonormal Q of the same span, less its rounding in float64.
    """
    rounding = 16 * (pixels + rank) * rank * UNIT_ROUNDING
    return (1 - rounding) - (distance + rounding) ** 2
