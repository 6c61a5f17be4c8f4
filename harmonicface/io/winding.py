"""Winding: which vertices are one position, and which triangles run against their neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Integers = NDArray[np.integer[Any]]

MULTIPLIERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def positions(vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return a number for each vertex that it shares with all vertices at exactly the same place.

    Parameters
    ----------
    vertices
        (n, 3) finite positions.

    Returns
    -------
    (n,) numbers from 0 without gaps, in no particular order.

    Examples
    --------
    >>> here, there, again = positions(np.array([[0.0, 1, 2], [3, 4, 5], [-0.0, 1, 2]]))
    >>> bool(here == again), bool(here == there)
    (True, False)
    """
    placed = np.ascontiguousarray(vertices + 0.0)  # + 0.0: no negative zeros
    bits = placed.view(np.uint64)
    mixed = bits[:, 0] * MULTIPLIERS[0]
    for axis in (1, 2):  # a sort of hashes takes a fraction of a sort of coordinates
        mixed = (mixed ^ (mixed >> np.uint64(29)) ^ bits[:, axis]) * MULTIPLIERS[axis]
    order = np.argsort(mixed, kind="stable")
    new_hash = np.diff(mixed[order]) != 0
    new_place = (np.diff(bits[order], axis=0) != 0).any(axis=1)
    if (new_place & ~new_hash).any():  # two places of one hash: sort by the coordinates themselves
        order = np.lexsort(placed.T)
        new_place = (np.diff(bits[order], axis=0) != 0).any(axis=1)
    numbers = np.empty(len(vertices), dtype=np.int64)
    numbers[order] = np.concatenate([[0], np.cumsum(new_place)])[: len(vertices)]
    return numbers


def against_neighbours(faces: Integers, areas: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which triangles have to be turned so that neighbours run the same way round.

    Two triangles are neighbours if an edge is theirs alone; they agree if they pass it in opposite directions. Of a
    connected part the smaller area is turned. Edges of three and more triangles connect nothing; a part that cannot
    agree with itself, as a Moebius strip, is left as it is.

    Parameters
    ----------
    faces
        (m, 3) numbers of positions: corners at the same place must have the same number.
    areas
        (m,) what a triangle weighs.

    Returns
    -------
    (m,) booleans.

    Examples
    --------
    >>> against_neighbours(np.array([[0, 1, 2], [2, 1, 3], [2, 3, 4], [3, 4, 5]]), np.ones(4))
    array([False, False, False,  True])
    """
    one, other, clash = _neighbours(faces)
    count = len(faces)
    turned = np.zeros(count, dtype=bool)
    if not clash.any():
        return turned
    # Every triangle as it is (i) and turned (i + count): what can be so at the same time hangs together.
    start = np.concatenate([one, one + count])
    end = np.where(clash, other + count, other)
    end = np.concatenate([end, np.where(clash, other, other + count)])
    graph = coo_array((np.ones(len(start), dtype=np.int8), (start, end)), shape=(2 * count, 2 * count))
    label = connected_components(graph, directed=False)[1]
    as_it_is, other_way = label[:count], label[count:]
    turned = as_it_is > other_way  # one of the two ways round in which a part agrees with itself, and none if it cannot
    part = np.minimum(as_it_is, other_way)
    kept_area = np.bincount(part, np.where(turned, -areas, areas))
    return np.asarray((turned ^ (kept_area[part] < 0)) & (as_it_is != other_way))


def _neighbours(faces: Integers) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Return the pairs of triangles that share an edge of their own, and whether both pass it the same way."""
    start, end = faces[:, [0, 1, 2]].ravel(), faces[:, [1, 2, 0]].ravel()
    key = np.minimum(start, end).astype(np.int64) * (int(faces.max(initial=0)) + 1) + np.maximum(start, end)
    key[start == end] = -1
    order = np.argsort(key, kind="stable")
    begins = np.flatnonzero(np.diff(key[order], prepend=-2))
    pairs = begins[(np.diff(begins, append=len(key)) == 2) & (key[order[begins]] >= 0)]
    a, b = order[pairs], order[pairs + 1]
    return a // 3, b // 3, (start[a] == start[b])
