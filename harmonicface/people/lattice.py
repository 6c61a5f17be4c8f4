"""The lattice of the mean head: rows and columns that follow the lids, its triangles, and its normals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.anatomy import INNER_CORNER, OUTER_CORNER, face_depth, lid_margins, outline

Array = NDArray[np.float64]

UPPER_LID, LOWER_LID = 2.6, -4.6  # mm, rows that are bent to the margins of the lids
LID_REACH = (14.0, -15.0)  # mm, where the bending has died away
LID_THICKNESS = 0.9  # mm, from the margin of a lid back to the eyeball

# (from, to, spacing) in mm: fine rows where lids, nose base and lips are, coarse ones on forehead and cheeks
ROWS = (
    (63.0, 14.0, 3.0),
    (14.0, -15.0, 1.25),
    (-15.0, -33.0, 1.8),
    (-33.0, -50.0, 1.2),
    (-50.0, -61.0, 1.6),
    (-61.0, -82.0, 1.2),
    (-82.0, -112.0, 2.3),
    (-112.0, -117.5, 1.1),
)
COLUMNS = ((0.0, 24.0, 1.3), (24.0, 48.0, 1.6), (48.0, 72.0, 3.0), (72.0, 80.3, 1.7))
EDGE = 9.0  # mm, over which the border of the face turns away from the camera


@dataclass(frozen=True, eq=False)
class Lattice:
    """The mean face as a grid of points, the closed eyes' skin where the eyeballs are seen through the lids.

    Parameters
    ----------
    points
        (rows, columns, 3) mm, in the frame of `anatomy`; the first row is the top, the first column the left.
    faces
        (m, 3) int64 corners of triangles among the flattened points.
    upper_lid, lower_lid
        (rows, columns) 1 at the lid's margin, falling to 0 at the other lid and on the skin around.
    eyes
        Two boolean grids (rows, columns), the points of the left and the right eyeball.
    margins
        Two boolean grids, the points of the lids' margins around each eye.
    """

    points: Array
    faces: NDArray[np.int64]
    upper_lid: Array
    lower_lid: Array
    eyes: tuple[NDArray[np.bool_], NDArray[np.bool_]]
    margins: tuple[NDArray[np.bool_], NDArray[np.bool_]]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.points.shape[0], self.points.shape[1]


@cache
def mean_lattice() -> Lattice:
    """Return the lattice of the mean face; it is made once."""
    heights, upper, lower = _row_heights()
    columns = _steps(COLUMNS)
    columns = np.concatenate([-columns[:0:-1], columns])
    y, lateral = np.meshgrid(heights, columns / columns[-1], indexing="ij")
    x = lateral * outline(y)
    y, upper_lid, lower_lid = _bend_to_lids(x, y)
    edge = np.clip((np.abs(lateral) - 1) * 80.3 / EDGE + 1, 0, None)
    points = np.stack([x, y, face_depth(x, y) - 6 * edge**2], axis=-1)
    rows = np.arange(len(heights))[:, None]
    within = (np.abs(x) > INNER_CORNER[0]) & (np.abs(x) < OUTER_CORNER[0])
    eye = within & (rows > upper) & (rows < lower)
    margin = within & ((rows == upper) | (rows == lower))
    sides = (x < 0), (x > 0)
    return Lattice(
        points,
        _triangles(*y.shape),
        upper_lid,
        lower_lid,
        (eye & sides[0], eye & sides[1]),
        (margin & sides[0], margin & sides[1]),
    )


def lattice_normals(points: Array) -> Array:
    """Return unit normals of a grid of points, from the differences to the neighbours along rows and columns."""
    across = np.empty_like(points)
    across[:, 1:-1] = points[:, 2:] - points[:, :-2]
    across[:, 0], across[:, -1] = points[:, 1] - points[:, 0], points[:, -1] - points[:, -2]
    up = np.empty_like(points)
    up[1:-1] = points[:-2] - points[2:]
    up[0], up[-1] = points[0] - points[1], points[-2] - points[-1]
    normals = np.empty_like(points)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        normals[..., i] = across[..., j] * up[..., k] - across[..., k] * up[..., j]
    length = np.sqrt(np.einsum("ijk,ijk->ij", normals, normals))
    return np.asarray(normals / np.maximum(length, 1e-12)[..., None])


def _steps(spans: tuple[tuple[float, float, float], ...]) -> Array:
    """Return the places that cut each span into equal steps of about its spacing, without its end but the last."""
    pieces = []
    for start, end, spacing in spans:
        count = max(1, round(abs(end - start) / spacing))
        pieces.append(np.linspace(start, end, count, endpoint=False))
    return np.concatenate([*pieces, [spans[-1][1]]])


def _row_heights() -> tuple[Array, int, int]:
    """Return the rows' heights, and which rows are the margins of the upper and the lower lid.

    The row behind each margin lies at the same height: it is the eyeball where the eye is open.
    """
    heights = _steps(ROWS)
    upper, lower = (int(np.abs(heights - height).argmin()) for height in (UPPER_LID, LOWER_LID))
    heights[upper], heights[lower] = UPPER_LID, LOWER_LID
    heights = np.insert(heights, [upper + 1, lower], [UPPER_LID, LOWER_LID])
    return heights, upper, lower + 2


def _bend_to_lids(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return the heights bent so that two rows follow the margins, and how much each lid moves each point."""
    _, upper, lower = lid_margins(x)
    beyond = np.maximum(INNER_CORNER[0] - np.abs(x), np.abs(x) - OUTER_CORNER[0])
    near = 0.5 + 0.5 * np.cos(np.pi * np.clip(beyond / 8, 0, 1))
    above = np.clip((LID_REACH[0] - y) / (LID_REACH[0] - UPPER_LID), 0, 1)
    below = np.clip((y - LID_REACH[1]) / (LOWER_LID - LID_REACH[1]), 0, 1)
    between = np.clip((y - LOWER_LID) / (UPPER_LID - LOWER_LID), 0, 1)
    upper_weight, lower_weight = np.minimum(above, between), np.minimum(below, 1 - between)
    bent = y + near * (upper_weight * (upper - UPPER_LID) + lower_weight * (lower - LOWER_LID))
    open_eye = np.clip((upper - lower) / 9.0, 0, 1)
    return bent, upper_weight * open_eye, lower_weight * open_eye


def _triangles(rows: int, columns: int) -> NDArray[np.int64]:
    """Return two triangles for each cell of a grid, the diagonals mirrored at the middle column."""
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    left = np.stack([a, c, b, b, c, d], axis=-1)
    right = np.stack([a, c, d, a, d, b], axis=-1)
    half = np.arange(columns - 1) < (columns - 1) / 2
    return np.where(half[None, :, None], left, right).reshape(-1, 3).astype(np.int64)
