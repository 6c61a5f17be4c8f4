"""Rows of the stability table: harmonics, harmonic images, and rotations of coefficients."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.spatial.transform import Rotation

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.bench.stability import exact, exact_harmonics
from harmonicface.bench.stability.row import Answers, Measured, Rows, named, rounded
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.rotation import rotate
from harmonicface.surfaces.surface import Surface

STEEP = "condition: order + 1, how fast the steepest harmonic changes"


def directions(count: int, seed: int = 0, dtype: DTypeLike = np.float64) -> Floats:
    """Return random unit vectors, (n, 3)."""
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True), dtype)


def of_harmonics() -> Answers:
    """Return a function for each row of harmonics and harmonic images."""
    return {**_of_directions(), **_of_images()}


def _of_directions() -> Answers:
    rows: Rows = {}
    rows["order 2"] = partial(_evaluated, directions(20), 2)
    rows["order 2, float32"] = partial(_evaluated, directions(20, dtype=np.float32), 2)
    rows["order 8, axes and poles"] = partial(_evaluated, np.concatenate([np.eye(3), -np.eye(3)]), 8)
    for distance in (1e-4, 1e-8, 1e-14):
        rows[f"order 8, {distance:.0e} from a pole"] = partial(_evaluated, _near_poles(distance), 8)
    rows["order 8, a subnormal number from a pole"] = partial(_evaluated, _near_poles(5e-324), 8)
    rows["order 8, one direction repeated"] = partial(_evaluated, np.repeat(directions(1), 20, axis=0), 8)
    rows["order 64"] = partial(_evaluated, directions(3), 64)
    rows["order 64, float32"] = partial(_evaluated, directions(3, dtype=np.float32), 64)
    rows["order 200"] = partial(_evaluated, directions(1), 200, (1, 2, 100, 200))
    rows["no directions"] = lambda: rounded(real_harmonics(np.zeros((0, 3)), 2), np.zeros((9, 0)))
    for factor, case in ((1e-12, "1e-12"), (1e12, "1e+12"), (1e-310, "1e-310 (subnormal)")):
        rows[f"vectors of {case}"] = partial(_evaluated, factor * directions(4), 2)
    rows["NaN"] = partial(_evaluated, np.full((1, 3), np.nan), 2)
    return named("real_harmonics", rows)


def _near_poles(distance: float) -> Floats:
    return np.array([[distance, 0, 1], [0, distance, 1], [0, distance, -1], [distance, distance, 1.0]])


def _evaluated(vectors: Floats, order: int, degrees: tuple[int, ...] = ()) -> Measured:
    """Compare harmonics of some degrees (of all up to 8, of a few above) with sums of fractions."""
    found = real_harmonics(vectors, order)
    some = degrees or (range(order + 1) if order <= 8 else (0, 1, order // 2, order - 1, order))
    ours = np.concatenate([found[degree**2 : (degree + 1) ** 2] for degree in some])
    right = [np.concatenate([exact_harmonics.harmonics(one, degree) for degree in some]) for one in vectors]
    return rounded(ours, np.stack(right, axis=1), order + 1, vectors.dtype, STEEP)


def _of_images() -> Answers:
    rows: Rows = {}
    for factor in (1e-12, 1e12, 1e-300, 1e300):
        rows[f"albedo times {factor:.0e}"] = partial(_pictured, np.full((4, 5), 0.7 * factor))
    rows["albedo of 1e-310 (subnormal)"] = partial(_pictured, np.full((4, 5), 1e-310))
    faint = np.full((4, 5), 1e-40, np.float32)
    rows["float32 albedo of 1e-40 (subnormal)"] = partial(_pictured, faint, dtype=np.float32)
    rows["float32"] = partial(_pictured, np.full((4, 5), 0.7, np.float32), dtype=np.float32)
    rows["one pixel"] = partial(_pictured, np.array([[0.7]]))
    rows["every other pixel black"] = partial(_pictured, 0.7 * (np.indices((4, 5)).sum(axis=0) % 2))
    rows["an empty mask"] = partial(_pictured, np.ones((4, 5)), mask=np.zeros((4, 5), bool))
    return named("harmonic_images", rows)


def _pictured(albedo: Floats, mask: NDArray[np.bool_] | None = None, dtype: DTypeLike = np.float64) -> Measured:
    """Compare the nine harmonic images with polynomials in fractions."""
    normals = directions(albedo.size, 1, dtype)
    surface = Surface(normals.reshape(*albedo.shape, 3), albedo, mask)
    right = exact_harmonics.harmonic_pictures(normals, albedo.ravel())
    return rounded(harmonic_images(surface), right, 3, dtype, STEEP)


def of_rotations() -> Answers:
    """Return a function for each row of rotations."""
    rows: Rows = {}
    rows["by nothing"] = partial(_turned, np.eye(3))
    for axis, about in zip(np.eye(3), "xyz", strict=True):
        rows[f"half a turn about {about}"] = partial(_turned, 2 * np.outer(axis, axis) - np.eye(3))
    for angle in (1e-4, 1e-8, 1e-14, 1e-300):
        rows[f"{angle:.0e} about y"] = partial(_turned, _about_y(angle))
    any_turn = Rotation.random(rng=np.random.default_rng(3)).as_matrix()
    rows["order 2"] = partial(_turned, any_turn, 2)
    rows["order 64"] = partial(_turned, any_turn, 64)
    rows["order 64, float32"] = partial(_turned, any_turn, 64, dtype=np.float32)
    for factor in (1e-12, 1e12, 1e-300, 1e300):
        rows[f"times {factor:.0e}"] = partial(_turned, any_turn, factor=factor)
    rows["times 1e-310 (subnormal)"] = partial(_turned, any_turn, factor=1e-310)
    rows["black"] = lambda: rounded(rotate(np.zeros(9), any_turn), np.zeros(9))
    rows["a matrix rounded to float32"] = partial(_nearest, any_turn.astype(np.float32).astype(np.float64))
    noise = np.random.default_rng(4).normal(size=(3, 3))
    rows["a matrix off by 1e-06"] = partial(_nearest, any_turn + 1e-6 * noise)
    rows["a matrix off by 1e-04"] = partial(_nearest, any_turn + 1e-4 * noise)
    rows["a mirror"] = partial(_turned, np.diag([1.0, 1.0, -1.0]))
    rows["a singular matrix"] = partial(_turned, np.diag([1.0, 1.0, 0.0]))
    rows["no coefficients"] = lambda: rounded(rotate(np.zeros(0), any_turn), np.zeros(0))
    rows["NaN"] = lambda: rounded(rotate(np.full(9, np.nan), any_turn), np.zeros(9))
    return named("rotate", rows)


def _about_y(angle: float) -> Floats:
    return np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])


def _turned(matrix: Floats, order: int = 8, factor: float = 1.0, dtype: DTypeLike = np.float64) -> Measured:
    """Rotate a point of light, whose coefficients are the harmonics at its place, and compare those where it went."""
    place = directions(1, 5)[0]
    some = range(order + 1) if order <= 8 else (0, 1, order // 2, order)
    before = np.zeros((order + 1) ** 2, dtype)
    after = np.zeros((order + 1) ** 2, np.longdouble)
    there = np.asarray(exact.longs(exact.rationals(matrix) @ exact.rationals(place)), np.float64)
    for degree in some:
        inside = slice(degree**2, (degree + 1) ** 2)
        before[inside] = np.longdouble(factor) * exact_harmonics.harmonics(place, degree)
        after[inside] = np.longdouble(factor) * exact_harmonics.harmonics(there, degree)
    note = "of a point of light, against the harmonics where it went; condition: order + 1"
    return rounded(rotate(before, matrix), after, order + 1, dtype, note)


def _nearest(matrix: Floats) -> Measured:
    """Compare with the nearest rotation, by Newton's iteration for the polar factor in fractions."""
    nearest = exact.rationals(matrix)
    for _ in range(5):
        inverse = np.stack([exact.solve(nearest, column) for column in exact.rationals(np.eye(3))], axis=1)
        nearest = exact.rationals(np.asarray(exact.longs((nearest + inverse.T) / 2), np.float64))
    turned = exact.longs(nearest)
    coefficients = np.arange(1.0, 5.0)
    right = np.concatenate([[1], (turned @ coefficients[[3, 1, 2]])[[1, 2, 0]]])
    return rounded(rotate(coefficients, matrix), right, 2, note="against the nearest rotation; condition: order + 1")
