"""Lorentz: photographs under first-order light give a surface up to the Lorentz group, integrability the rest."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

METRIC = np.array([1.0, -1.0, -1.0, -1.0])  # albedo squared minus the scaled normal's square is 0
PAIRS = tuple(combinations(range(4), 2))
LEAST_CONE = 1e-6  # of the largest eigenvalue: factors whose cone is flatter lie in fewer than four dimensions


def null_cone(right: Floats) -> Doubles:
    r"""Return the (4, 4) map of four factors to albedo and scaled normal, up to the scaled Lorentz group.

    Under first-order light a photograph is a combination of albedo and the three parts of albedo times normal,
    `s = (a, a n)`, for which `s_0^2 = s_1^2 + s_2^2 + s_3^2`. The factors are a linear map of them, so that they lie
    on a quadratic cone, `f' B f = 0`, whose ten numbers follow from a least-squares problem; with B of signature
    (1, 3), `B = C' diag(1, -1, -1, -1) C` gives `s = C f` (Basri, Jacobs & Kemelmacher 2007, section 4.1). Any
    transformation that keeps the cone is as good.

    Parameters
    ----------
    right
        (4, p) factors of the photographs.

    Raises
    ------
    HarmonicFaceError
        Factors that lie in fewer than four dimensions.
    """
    factors = np.asarray(right, np.float64)
    spread = np.sqrt((factors**2).mean(axis=1))
    if not spread.min() > 1e-9 * spread.max():
        raise HarmonicFaceError("right: expected four independent factors, got light that varies in fewer dimensions")
    scaled = factors / spread[:, None]
    scaled = scaled / np.linalg.norm(scaled, axis=0)
    rows, columns = np.triu_indices(4)
    products = scaled[rows] * scaled[columns] * np.where(rows == columns, 1.0, np.sqrt(2.0))[:, None]
    cone = np.linalg.eigh(products @ products.T)[1][:, 0] / np.where(rows == columns, 1.0, np.sqrt(2.0))
    form = np.zeros((4, 4))
    form[rows, columns] = form[columns, rows] = cone
    values, vectors = np.linalg.eigh(form)
    if (values > 0).sum() > 2 or ((values > 0).sum() == 2 and values.sum() > 0):
        values, vectors = -values[::-1], vectors[:, ::-1]
    least = LEAST_CONE * np.abs(values).max()
    lengths = np.concatenate([-np.minimum(values[:3], -least), [max(values[3], least)]])  # noise may turn one's sign
    order = [3, 0, 1, 2]
    found = np.sqrt(lengths[order])[:, None] * vectors[:, order].T / spread
    return np.asarray(found if (found[0] @ factors).sum() > 0 else found * np.array([-1.0, 1, 1, 1])[:, None])


def integrable(cone: Floats, mask: Mask) -> Doubles:
    r"""Return the (3, 4) map of cone coordinates to scaled normals whose slopes are those of a surface.

    With `b = P s`, the condition `d(b_1 / b_3)/dy = d(b_2 / b_3)/dx` is linear in the outer products u of the
    third row of P with the first one and v with the second one,

    .. math:: \sum_{i<j} u_{ij} (s_i \partial_y s_j - s_j \partial_y s_i) =
              \sum_{i<j} v_{ij} (s_i \partial_x s_j - s_j \partial_x s_i)

    whose smallest singular vector gives both; their common line is the third row. What a bas-relief would leave open
    follows from P being part of a Lorentz transformation: its rows are orthogonal and alike in length under the
    metric. What is left is one sign, convex or concave.

    Parameters
    ----------
    cone
        (4, p) albedo and scaled normals up to a Lorentz transformation.
    mask
        (h, w) booleans with p pixels.

    Raises
    ------
    HarmonicFaceError
        A mask without neighbouring pixels, or coordinates that no surface gives.
    """
    inner = mask[1:-1, 1:-1] & mask[1:-1, :-2] & mask[1:-1, 2:] & mask[:-2, 1:-1] & mask[2:, 1:-1]
    if inner.sum() < 24:
        raise HarmonicFaceError(
            f"mask: expected at least 24 pixels with four neighbours for integrability, got {inner.sum()}"
        )
    grid = np.zeros((4, *mask.shape))
    grid[:, mask] = cone
    right = ((grid[:, 1:-1, 2:] - grid[:, 1:-1, :-2]) / 2)[:, inner]
    up = ((grid[:, :-2, 1:-1] - grid[:, 2:, 1:-1]) / 2)[:, inner]
    middle = grid[:, 1:-1, 1:-1][:, inner]
    if not middle.any():
        raise HarmonicFaceError("cone: expected coordinates of a surface, got zeros")
    weight = 1 / np.maximum((middle**2).sum(axis=0), 1e-12 * (middle**2).sum(axis=0).max())
    wedges = [
        np.stack([weight * (middle[i] * slope[j] - middle[j] * slope[i]) for i, j in PAIRS]) for slope in (up, right)
    ]
    system = np.concatenate([wedges[0], -wedges[1]])
    system *= np.minimum(1, 3 * np.median(np.abs(system).sum(axis=0)) / np.maximum(np.abs(system).sum(axis=0), 1e-300))
    size = np.sqrt((system**2).mean(axis=1)) + 1e-300
    solution = np.linalg.eigh((system / size[:, None]) @ (system / size[:, None]).T)[1][:, 0] / size
    first, second = (_antisymmetric(part) for part in (solution[:6], solution[6:]))
    return _lorentz_rows(first, second)


def _antisymmetric(parts: Doubles) -> Doubles:
    matrix = np.zeros((4, 4))
    for (i, j), value in zip(PAIRS, parts, strict=True):
        matrix[i, j], matrix[j, i] = value, -value
    return matrix


def _lorentz_rows(first: Doubles, second: Doubles) -> Doubles:
    """Return the rows P from `u = P3 ^ P1` and `v = P3 ^ P2`."""
    planes = []
    for wedge in (first, second):
        left, sizes, _ = np.linalg.svd(wedge)
        planes.append(left[:, :2])
        if sizes[0] < 1e-12:
            raise HarmonicFaceError("cone: expected coordinates of a surface, got some that slope one way only")
    left, _, _ = np.linalg.svd(planes[0].T @ planes[1])
    common = planes[0] @ left[:, 0]
    third_size = -(METRIC * common) @ common
    third = common / np.sqrt(max(third_size, 1e-6))
    rows = []
    for wedge in (first, second):
        # u = third x row' - row x third': contract with third under the metric, and take what is orthogonal to it
        row = wedge @ (METRIC * third)
        rows.append(row + ((METRIC * row) @ third) * third)
    lengths = [max(-(METRIC * row) @ row, 1e-12) for row in rows]
    scale = np.sqrt(np.mean(lengths))
    return np.stack([rows[0] / scale, rows[1] / scale, third])


def first_order_normals(right: Floats, mask: Mask) -> Doubles:
    """Return scaled normals (p, 3) from four factors, up to convex or concave, the third part mostly positive.

    Parameters
    ----------
    right
        (4, p) factors of photographs under light of first order, in row-major order of the mask.
    mask
        (h, w) booleans with p pixels.

    Raises
    ------
    HarmonicFaceError
        Factors in fewer than four dimensions, too few pixels, coordinates that no surface gives.
    """
    cone = null_cone(right) @ np.asarray(right, np.float64)
    scaled = integrable(cone, mask) @ cone
    return np.asarray((scaled * np.sign(np.median(scaled[2]) or 1.0)).T)
