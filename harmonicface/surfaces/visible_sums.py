"""Visible sums: what reaches points of a scene from a set of directions, with what stands in the way and without."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from harmonicface._validate import Floats
from harmonicface.surfaces.blockers import Blocker
from harmonicface.surfaces.scene import FineSamples

Doubles = NDArray[np.float64]
Singles = NDArray[np.float32]
Integers = NDArray[np.int64]

BLOCK = 1 << 18  # pairs of a sample and a direction held at once
GOLDEN = (1 + 5**0.5) / 2


@dataclass(frozen=True, eq=False)
class FacingRays:
    """The directions that some pixels turn a side to, one ray each.

    Parameters
    ----------
    number
        Which set of directions these pixels have.
    pixels
        (b,) their numbers.
    unshadowed
        (s, b, r / s) clamped cosines of all directions, those of a slot together.
    place
        Where the rays are in that array: three arrays of (n,).
    sample
        (n,) the number of the sample from which each ray starts.
    directions
        (n, 3) where it goes.
    """

    number: int
    pixels: Integers
    unshadowed: Singles
    place: tuple[Integers, Integers, Integers]
    sample: Integers
    directions: Singles

    @property
    def pixel(self) -> Integers:
        """The pixel of each ray, (n,)."""
        return self.pixels[self.place[1]]

    @property
    def cosine(self) -> Singles:
        """The cosine of each ray, (n,)."""
        return self.unshadowed[self.place]


def facing_rays(samples: FineSamples, directions: Floats) -> Iterator[FacingRays]:
    """Yield the rays of all pixels in blocks: into directions that both the shading normal and the triangle face.

    There are several sets of directions, and each pixel has one of them, so that neighbouring pixels do not share
    their error. Within a pixel each direction belongs to another of its samples, in turn: a sum over directions is the
    mean over the pixel's area as well. A triangle that faces away is opaque, whatever its shading normal says.

    Parameters
    ----------
    samples
        Where the light arrives; s of them a pixel.
    directions
        (sets, r, 3) unit vectors; r is a multiple of s.
    """
    sets, rays, _ = directions.shape
    parts = samples.slots.shape[1]
    geometric, normals = samples.geometric.astype(np.float32), samples.normals.astype(np.float32)
    owner = np.random.default_rng(0).permutation(samples.pixels) % sets
    for number in range(sets):
        towards = by_slot(directions[number], parts).astype(np.float32)  # (s, r / s, 3)
        members = np.flatnonzero(owner == number)
        if len(members) == 0:
            continue
        for block in np.array_split(members, -(-len(members) * rays // BLOCK)):
            chosen = samples.slots[block].T  # (s, b)
            cosines = np.maximum(normals[chosen] @ towards.swapaxes(1, 2), 0)
            slot, pixel, ray = np.nonzero((cosines > 0) & (geometric[chosen] @ towards.swapaxes(1, 2) > 0))
            yield FacingRays(number, block, cosines, (slot, pixel, ray), chosen[slot, pixel], towards[slot, ray])


def visible_sums(
    blocker: Blocker, samples: FineSamples, directions: Floats, weights: Floats
) -> tuple[Doubles, Doubles]:
    r"""Return \sum_j V(x, w_j) max(n.w_j, 0) c_j at each pixel, and the same with V = 1.

    Parameters
    ----------
    blocker
        What is in the way.
    samples
        Where the light arrives; s of them a pixel.
    directions
        (sets, r, 3) unit vectors, see `facing_rays`.
    weights
        (sets, r, c) what each direction brings; c quantities at once.

    Returns
    -------
    visible, all
        (c, p) each.
    """
    parts, columns = samples.slots.shape[1], weights.shape[2]
    visible, everything = np.zeros((samples.pixels, columns)), np.zeros((samples.pixels, columns))
    for some in facing_rays(samples, directions):
        brought = by_slot(weights[some.number], parts).astype(np.float32)
        everything[some.pixels] = np.matmul(some.unshadowed, brought).sum(axis=0)
        open_ = ~blocker.blocked(some.sample, some.directions)
        cosines = np.zeros_like(some.unshadowed)
        place = tuple(part[open_] for part in some.place)
        cosines[place] = some.unshadowed[place]
        visible[some.pixels] = np.matmul(cosines, brought).sum(axis=0)
    return np.ascontiguousarray(visible.T), np.ascontiguousarray(everything.T)


def sphere_directions(sets: int, count: int) -> Doubles:
    """Return sets of `count` directions, evenly spread over the sphere, (sets, count, 3): turned Fibonacci lattices."""
    index = np.arange(count) + 0.5
    height = 1 - 2 * index / count
    around = 2 * np.pi * index / GOLDEN
    radius = np.sqrt(1 - height**2)
    lattice = np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)
    turns = Rotation.from_quat(np.random.default_rng(0).normal(size=(sets, 4))).as_matrix()  # any way is as likely
    return np.asarray(np.einsum("sij,nj->sni", turns, lattice))


def by_slot(array: Floats, parts: int) -> Floats:
    """Return rows dealt out in turn to the slots of a pixel, (s, r / s, c)."""
    return array.reshape(-1, parts, array.shape[1]).swapaxes(0, 1)
