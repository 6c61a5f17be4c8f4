"""References without rounding: linear algebra in fractions and long decimals, of numbers exactly as given."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

Exact = NDArray[np.object_]
Long = NDArray[np.longdouble]
DIGITS = 120  # of decimal arithmetic: squares of numbers that are 1e-14 of others keep 90 of them


def integers(numbers: ArrayLike) -> tuple[Exact, int]:
    """Return floating-point numbers exactly as integers times a power of two.

    Examples
    --------
    >>> whole, exponent = integers([0.75, -2.0])
    >>> whole.tolist(), exponent
    ([3, -8], -2)
    """
    array = np.asarray(numbers, np.float64)
    fractions, exponents = np.frexp(array)
    mantissas = (fractions * 2.0**53).astype(np.int64)
    least = int(exponents[mantissas != 0].min(initial=1 << 20)) if mantissas.any() else 0
    shifts = np.where(mantissas != 0, exponents - least, 0)
    flat = [int(m) << int(s) for m, s in zip(mantissas.ravel(), shifts.ravel(), strict=True)]
    common = math.gcd(*flat) or 1
    twos = (common & -common).bit_length() - 1
    whole = np.empty(array.size, object)
    whole[:] = [number >> twos for number in flat]
    return whole.reshape(array.shape), least - 53 + twos


def rationals(numbers: ArrayLike) -> Exact:
    """Return floating-point numbers exactly as fractions."""
    whole, exponent = integers(numbers)
    return np.asarray(whole * Fraction(2) ** exponent, object)


def reduced_rows(matrix: Exact) -> tuple[Exact, list[int]]:
    """Return the reduced row echelon form without its rows of zeros, and the columns of its ones."""
    rows = np.array([[Fraction(number) for number in row] for row in matrix], object)
    pivots: list[int] = []
    for column in range(rows.shape[1]):
        place = len(pivots)
        below = [index for index in range(place, len(rows)) if rows[index, column] != 0]
        if not below:
            continue
        rows[[place, below[0]]] = rows[[below[0], place]]
        rows[place] = rows[place] / rows[place, column]
        for index in range(len(rows)):
            if index != place and rows[index, column] != 0:
                rows[index] = rows[index] - rows[index, column] * rows[place]
        pivots.append(column)
    return rows[: len(pivots)], pivots


def solve(matrix: Exact, right: Exact) -> Exact:
    """Solve a regular system of equations with one right side.

    Examples
    --------
    >>> solve(np.array([[2, 1], [1, 3]], object), np.array([1, 0], object)).tolist()
    [Fraction(3, 5), Fraction(-1, 5)]
    """
    rows, _ = reduced_rows(np.column_stack([matrix, right]))
    return np.asarray(rows[:, -1], object)


def least_squares(matrix: ArrayLike, right: ArrayLike) -> Exact:
    """Return the x of least norm among those of least |A x - b|, as fractions, whatever the rank.

    With the reduced row echelon form C of A and the columns B of A at its ones, A = B C, so that
    x = C' (C C')^-1 (B' B)^-1 B' b.

    Examples
    --------
    >>> least_squares([[1.0, 1.0], [1.0, 1.0]], [1.0, 2.0]).tolist()
    [Fraction(3, 4), Fraction(3, 4)]
    """
    a, scale = integers(matrix)
    b, other = integers(right)
    rows, pivots = reduced_rows(a.T @ a)
    if not pivots:
        return np.array([Fraction(0)] * a.shape[1], object)
    columns = a[:, pivots]
    inner = solve(columns.T @ columns, columns.T @ b)
    return np.asarray((rows.T @ solve(rows @ rows.T, inner)) * Fraction(2) ** (other - scale), object)


def sine(rows: ArrayLike, photo: ArrayLike) -> float:
    """Return the sine of the angle between a vector and the span of some rows.

    Examples
    --------
    >>> sine([[1.0, 0.0]], [3.0, 4.0])
    0.8
    """
    square, inside, _ = _split(rows, photo)
    return math.sqrt((square - inside) / square)


def closeness(rows: ArrayLike, photo: ArrayLike) -> float:
    """Return the square of the length that the span of some rows explains of a vector.

    Examples
    --------
    >>> closeness([[1.0, 0.0]], [3.0, 4.0])
    9.0
    """
    _, inside, exponent = _split(rows, photo)
    return float(inside * Fraction(2) ** (2 * exponent))


def _split(rows: ArrayLike, photo: ArrayLike) -> tuple[Fraction, Fraction, int]:
    """Return the squared lengths of a vector and of its part in a span, and the power of two that both are in."""
    span, (y, exponent) = np.asarray(rows, np.float64), integers(photo)
    a, _ = integers(span.T)
    _, pivots = reduced_rows(a.T @ a)
    columns = a[:, pivots]
    return Fraction(y @ y), solve(columns.T @ columns, columns.T @ y) @ (columns.T @ y), exponent


def singular_values(matrix: ArrayLike) -> Long:
    """Return all singular values, largest first, by Jacobi's rotations of A' A or A A' in decimals of 120 digits.

    Examples
    --------
    >>> singular_values([[3.0, 0.0], [0.0, 4.0], [0.0, 0.0]]).astype(float).tolist()
    [4.0, 3.0]
    """
    a, exponent = integers(matrix)
    gram = a.T @ a if a.shape[0] >= a.shape[1] else a @ a.T
    squares, _ = eigen(gram)
    return np.asarray([root * np.longdouble(2) ** exponent for root in squares], np.longdouble)


def eigen(symmetric: Exact, roots: bool = True) -> tuple[Long, Exact]:
    """Return eigenvalues of a symmetric matrix of integers or fractions, largest first, and eigenvectors as columns.

    The roots of the eigenvalues (those of rounding below 0 become 0), unless told otherwise.
    """
    with localcontext() as context:
        context.prec, context.Emax, context.Emin = DIGITS, 10**9, -(10**9)
        fractions = [[Fraction(number) for number in row] for row in symmetric]
        matrix = np.array([[Decimal(f.numerator) / Decimal(f.denominator) for f in row] for row in fractions], object)
        size = len(matrix)
        turned = np.array([[Decimal(int(i == j)) for j in range(size)] for i in range(size)], object)
        total = sum((number * number for number in matrix.ravel()), Decimal(0))
        while _beside(matrix) > total * Decimal(10) ** (15 - 2 * DIGITS):
            for i in range(size - 1):
                for j in range(i + 1, size):
                    _annihilate(matrix, turned, i, j)
        values = [matrix[i, i] for i in range(size)]
        shown = [max(value, Decimal(0)).sqrt() if roots else value for value in values]
        order = sorted(range(size), key=lambda index: -values[index])
        return np.array([np.longdouble(str(+shown[i])) for i in order]), turned[:, order]


def _beside(matrix: Exact) -> Decimal:
    """Return the sum of squares beside the diagonal."""
    numbers = matrix[~np.eye(len(matrix), dtype=bool)]
    return sum((number * number for number in numbers), Decimal(0))


def _annihilate(matrix: Exact, turned: Exact, i: int, j: int) -> None:
    """Turn rows and columns i and j until their common number is 0, in place."""
    if matrix[i, j] == 0:
        return
    slope = (matrix[j, j] - matrix[i, i]) / (2 * matrix[i, j])
    tangent = 1 / (abs(slope) + (slope * slope + 1).sqrt())
    tangent = -tangent if slope < 0 else tangent
    cosine = 1 / (tangent * tangent + 1).sqrt()
    sine = tangent * cosine
    for array in (matrix, matrix.T, turned.T):  # rows, columns, and the columns of what turns
        first, second = array[i].copy(), array[j].copy()
        array[i], array[j] = cosine * first - sine * second, sine * first + cosine * second


def condition_of(matrix: ArrayLike) -> float:
    """Return the largest singular value over the smallest one that is not 0."""
    values = singular_values(matrix)
    kept = values[values > values[0] * np.longdouble("1e-40")]
    return float(kept[0] / kept[-1])


def longs(numbers: Exact) -> Long:
    """Return fractions in extended precision."""
    flat = np.array([as_long(Fraction(number)) for number in numbers.ravel()], np.longdouble)
    return flat.reshape(numbers.shape)


def as_long(number: Fraction) -> np.longdouble:
    """Return a fraction in extended precision, as a quotient of integers of 70 bits."""
    if number == 0:
        return np.longdouble(0)
    shift = number.denominator.bit_length() - abs(number.numerator).bit_length() + 70
    scaled = number * Fraction(2) ** shift
    whole = abs(scaled.numerator) // scaled.denominator
    high, low = divmod(whole, 1 << 32)
    value = np.ldexp(np.longdouble(high) * np.longdouble(1 << 32) + np.longdouble(low), -shift)
    return np.longdouble(-value if number < 0 else value)
