"""Visible sums: what reaches points of a scene from a set of directions, with what stands in the way and without."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from harmonicface._validate import Floats
from harmonicface.surfaces.blockers import Blocker
from harmonicface.surfaces.scene import FineSamples

Doubles = NDArray[np.float64]

BLOCK = 1 << 18  # pairs of a sample and a direction held at once
GOLDEN = (1 + 5**0.5) / 2


def visible_sums(
    blocker: Blocker, samples: FineSamples, directions: Floats, weights: Floats
) -> tuple[Doubles, Doubles]:
    r"""Return \sum_j V(x, w_j) max(n.w_j, 0) c_j at each pixel, and the same with V = 1.

    There are several sets of directions, and each pixel has one of them, so that neighbouring pixels do not share
    their error. Within a pixel each direction belongs to another of its samples: the sum over directions is the mean
    over the pixel's area as well. V is 0 where the triangle itself faces away from the direction, whatever its
    shading normal says: a surface is opaque.

    Parameters
    ----------
    blocker
        What is in the way.
    samples
        Where the light arrives; s of them a pixel.
    directions
        (sets, r, 3) unit vectors; r is a multiple of s.
    weights
        (sets, r, c) what each direction brings; c quantities at once.

    Returns
    -------
    visible, all
        (c, p) each.
    """
    sets, rays, columns = weights.shape
    parts = samples.slots.shape[1]
    geometric = samples.geometric.astype(np.float32)
    normals = samples.normals.astype(np.float32)
    visible, everything = np.zeros((samples.pixels, columns)), np.zeros((samples.pixels, columns))
    owner = np.random.default_rng(0).permutation(samples.pixels) % sets
    for number in range(sets):
        towards = _by_slot(directions[number], parts).astype(np.float32)  # (s, r / s, 3)
        brought = _by_slot(weights[number], parts).astype(np.float32)
        members = np.flatnonzero(owner == number)
        for block in np.array_split(members, max(1, -(-len(members) * rays // BLOCK))):
            chosen = samples.slots[block].T  # (s, b)
            cosines = np.maximum(normals[chosen] @ towards.swapaxes(1, 2), 0)  # (s, b, r / s)
            everything[block] = np.matmul(cosines, brought).sum(axis=0)
            cosines *= geometric[chosen] @ towards.swapaxes(1, 2) > 0
            slot, pixel, ray = np.nonzero(cosines)
            hidden = blocker.blocked(chosen[slot, pixel], towards[slot, ray])
            cosines[slot[hidden], pixel[hidden], ray[hidden]] = 0
            visible[block] = np.matmul(cosines, brought).sum(axis=0)
    return np.ascontiguousarray(visible.T), np.ascontiguousarray(everything.T)


def sphere_directions(sets: int, count: int) -> Doubles:
    """Return sets of `count` directions, evenly spread over the sphere, (sets, count, 3): turned Fibonacci lattices."""
    index = np.arange(count) + 0.5
    height = 1 - 2 * index / count
    around = 2 * np.pi * index / GOLDEN
    radius = np.sqrt(1 - height**2)
    lattice = np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)
    turns = Rotation.random(sets, random_state=np.random.default_rng(0)).as_matrix()
    return np.asarray(np.einsum("sij,nj->sni", turns, lattice))


def _by_slot(array: Floats, parts: int) -> Floats:
    """Return rows dealt out in turn to the slots of a pixel, (s, r / s, c)."""
    return array.reshape(-1, parts, array.shape[1]).swapaxes(0, 1)
