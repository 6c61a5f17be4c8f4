"""Rows of the stability table: depth from normals, and from steps between pixels."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.ndimage import label

from harmonicface._validate import Floats
from harmonicface.bench.stability import exact
from harmonicface.bench.stability.row import Answers, Measured, Rows, named, rounded
from harmonicface.stereo.depth.integration import depth_from_steps, integrate_normals
from harmonicface.stereo.depth.perspective_integration import integrate_perspective

SIDE = 20
SHAPE = (4, 5)  # of steps that disagree, whose equations are solved in fractions
POISSON = "condition of the Poisson equation"

Mask = NDArray[np.bool_]


def of_integration() -> Answers:
    """Return a function for each row."""
    return {
        **named("integrate_normals", _of_normals()),
        **named("integrate_perspective", _of_pinhole()),
        **named("depth_from_steps", _of_steps()),
    }


def _of_normals() -> Rows:
    everywhere = np.ones((SIDE, SIDE), bool)
    parts, line, alone = everywhere.copy(), np.zeros_like(everywhere), np.zeros_like(everywhere)
    parts[:, SIDE // 2] = False
    line[3, :] = True
    alone[5, 6] = True
    rows: Rows = {"a plane": partial(_plane, everywhere)}
    rows["a plane, 256 x 256"] = partial(_plane, np.ones((256, 256), bool))
    rows["a plane, float32"] = partial(_plane, everywhere, dtype=np.float32)
    rows["a plane in a ragged mask"] = partial(_plane, _ragged())
    rows["a plane in two parts"] = partial(_plane, parts)
    rows["a line of pixels"] = partial(_plane, line)
    rows["one pixel"] = partial(_plane, alone)
    rows["a slope of 1e-12"] = partial(_plane, everywhere, 1e-12)
    rows["a slope of 5.6 (80 degrees)"] = partial(_plane, everywhere, 5.6)
    for size in (1e-12, 1e12, 1e-300, 1e300):
        rows[f"pixels of {size:.0e}"] = partial(_plane, everywhere, size=size)
    for least in (1e-4, 1e-8, 1e-12):
        trust = least ** np.random.default_rng(0).uniform(size=(SIDE, SIDE))
        rows[f"trust from 1 to {least:.0e}"] = partial(_plane, everywhere, trust=trust)
    for extreme in (1e-300, 1e300):
        rows[f"trust of {extreme:.0e}"] = partial(_plane, everywhere, trust=np.full((SIDE, SIDE), extreme))
    rows["pixels that touch no other"] = partial(_plane, np.indices((SIDE, SIDE)).sum(axis=0) % 2 == 0)
    rows["an empty mask"] = partial(_plane, ~everywhere)
    rows["a normal away from the camera"] = lambda: rounded(
        integrate_normals(np.tile([0.0, 0.0, -1.0], (3, 3, 1))), np.zeros((3, 3))
    )
    rows["NaN"] = partial(_plane, everywhere, np.nan)
    return rows


def _ragged() -> Mask:
    """Return a disc with slits, in one piece."""
    rows, columns = np.indices((SIDE, SIDE)) - SIDE / 2 + 0.5
    slits = (np.arange(SIDE) % 4 == 1) & (rows < SIDE / 10)
    return np.asarray((rows**2 + columns**2 < 0.9 * SIDE**2 / 4) & ~slits)


def _plane(
    mask: Mask, slope: float = 0.5, size: float = 1.0, trust: Floats | None = None, dtype: DTypeLike = np.float64
) -> Measured:
    """Compare with the plane of the normals as they are given, of mean 0 on each part."""
    normal = np.array([-0.8 * slope, 0.6 * slope, 1.0], dtype)
    normal /= np.linalg.norm(normal)
    field = np.where(mask[..., None], normal, normal.dtype.type(0))
    found = integrate_normals(field, mask, size, trust)
    x, y, z = normal.astype(np.longdouble)
    down, across = np.indices(mask.shape)
    right = np.longdouble(size) * ((y / z) * down - (x / z) * across)
    parts, count = label(mask)
    for part in range(1, count + 1):
        right[parts == part] -= right[parts == part].mean()
    return rounded(found[mask], right[mask], _condition(mask, trust), note=POISSON)


def _of_pinhole() -> Rows:
    everywhere = np.ones((SIDE, SIDE), bool)
    rows: Rows = {"a plane": partial(_before_a_pinhole, everywhere)}
    rows["a plane, float32"] = partial(_before_a_pinhole, everywhere, dtype=np.float32)
    rows["a plane in a ragged mask"] = partial(_before_a_pinhole, _ragged())
    for distance in (1e-12, 1e12, 1e-300, 1e300):
        rows[f"a distance of {distance:.0e}"] = partial(_before_a_pinhole, everywhere, distance)
    trust = 1e-8 ** np.random.default_rng(0).uniform(size=(SIDE, SIDE))
    rows["trust from 1 to 1e-08"] = partial(_before_a_pinhole, everywhere, trust=trust)
    for extreme in (1e-300, 1e300):
        even = np.full((SIDE, SIDE), extreme)
        rows[f"trust of {extreme:.0e}"] = partial(_before_a_pinhole, everywhere, trust=even)
    rows["an empty mask"] = partial(_before_a_pinhole, ~everywhere)
    return rows


def _before_a_pinhole(
    mask: Mask, distance: float = 1.0, trust: Floats | None = None, dtype: DTypeLike = np.float64
) -> Measured:
    """Compare with the plane of the normals as they are given, of a geometric mean of distances on its one part."""
    normal = np.array([-0.3, 0.2, 1.0], dtype)
    normal /= np.linalg.norm(normal)
    focal, centre = 30.0, SIDE / 2
    found = integrate_perspective(
        np.where(mask[..., None], normal, normal.dtype.type(0)),
        (focal, focal, centre, centre),
        mask,
        trust,
        distance=distance,
    )
    x, y, z = normal.astype(np.longdouble)
    down, across = np.indices(mask.shape) + np.longdouble(0.5) - centre
    nearness = np.log(z - x * across / focal + y * down / focal)[mask]
    right = -np.longdouble(distance) * np.exp(nearness.mean() - nearness)
    return rounded(found[mask], right, _condition(mask, trust), note=POISSON)


def _condition(mask: Mask, trust: Floats | None = None) -> float:
    """Return the largest eigenvalue of the weighted Laplacian over the least that is not 0."""
    if mask.size > 1000:  # of a square in closed form
        return float(8 / (2 - 2 * np.cos(np.pi / max(mask.shape))))
    weights = np.ones(mask.shape) if trust is None else trust / trust.max()
    index = np.arange(mask.size).reshape(mask.shape)
    matrix = np.zeros((mask.size, mask.size))
    for one, other in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        both = mask[one] & mask[other]
        first, second = index[one][both], index[other][both]
        pairs = 2 / (1 / weights[one][both] + 1 / weights[other][both])
        matrix[first, second] = matrix[second, first] = -pairs
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    values = np.linalg.eigvalsh(matrix[np.ix_(mask.ravel(), mask.ravel())])
    kept = values[label(mask)[1] :]
    return float(values[-1] / max(kept.min(initial=np.inf), values[-1] * 1e-16)) if len(kept) else 1.0


def _of_steps() -> Rows:
    rows: Rows = {"steps that disagree": partial(_disagreeing)}
    for least in (1e-4, 1e-8, 1e-12):
        rows[f"steps that disagree, weights from 1 to {least:.0e}"] = partial(_disagreeing, least=least)
    rows["steps times 1e-300"] = partial(_disagreeing, 1e-300)
    rows["steps times 1e+300"] = partial(_disagreeing, 1e300)
    rows["steps of 1e-310 (subnormal)"] = partial(_disagreeing, 1e-310)
    rows["a cut through the middle"] = partial(_disagreeing, cut=True)
    return rows


def _disagreeing(factor: float = 1.0, least: float = 1.0, cut: bool = False) -> Measured:
    """Compare with the normal equations solved in fractions."""
    random = np.random.default_rng(1)
    height, width = SHAPE
    right, down = (factor * random.normal(size=shape) for shape in ((height, width - 1), (height - 1, width)))
    first_trust, second_trust = (least ** random.uniform(size=each.shape) for each in (right, down))
    if cut:
        first_trust[:, 1] = 0
    found = depth_from_steps(right, down, first_trust, second_trust, np.ones(SHAPE, bool))
    number = np.arange(height * width).reshape(SHAPE)
    pairs = [*zip(number[:, :-1].ravel(), number[:, 1:].ravel(), strict=True)]
    pairs += zip(number[:-1].ravel(), number[1:].ravel(), strict=True)
    steps = np.concatenate([exact.rationals(each).ravel() for each in (right, down)])
    trust = np.concatenate([exact.rationals(each).ravel() for each in (first_trust, second_trust)])
    matrix = np.array([[Fraction(0)] * number.size for _ in range(number.size)], object)
    target = np.array([Fraction(0)] * number.size, object)
    for (first, second), step, weight in zip(pairs, steps, trust, strict=True):
        matrix[[first, second], [first, second]] += weight
        matrix[[first, second], [second, first]] -= weight
        target[first] -= weight * step
        target[second] += weight * step
    sides = [slice(0, 2), slice(2, width)] if cut else [slice(0, width)]
    solved = np.array([Fraction(0)] * number.size, object)
    for side in sides:
        pixels = number[:, side].ravel()
        solved[pixels[1:]] = exact.solve(matrix[np.ix_(pixels[1:], pixels[1:])], target[pixels[1:]])
        solved[pixels] = solved[pixels] - solved[pixels].sum() / len(pixels)
    values = exact.eigen(matrix, roots=False)[0]
    condition = float(values[0] / values[-1 - len(sides)])
    return rounded(found.ravel(), exact.longs(solved), condition, note=POISSON)
