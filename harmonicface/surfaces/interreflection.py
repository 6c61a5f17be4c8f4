"""Interreflection: light that surfaces throw on one another, by the form factors between their pieces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from harmonicface._validate import Floats
from harmonicface.surfaces.blockers import pixel_samples
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.patches import Patches
from harmonicface.surfaces.rays import RayCaster
from harmonicface.surfaces.scene import FineSamples, Scene
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.visible_sums import facing_rays, sphere_directions

Doubles = NDArray[np.float64]
Integers = NDArray[np.int64]

RAYS = 512  # directions on the sphere a pixel
PATCH_RAYS = 256  # the same for a patch
SETS = 64
BLOCK = 1 << 22  # what rays met, held before what falls on the same place is added up


@dataclass(frozen=True, eq=False)
class Exchange:
    r"""What pixels and pieces of a surface see of its pieces: light thrown back arrives as E_1 = F \rho E_0.

    .. math:: F_{ij} = \frac{1}{\pi} \int_{\text{piece } j \text{ seen from } i} \max(n_i \cdot w, 0) \, dw

    (Cohen & Wallace, Radiosity and Realistic Image Synthesis, 1993, chapter 4.) Rows sum to 1 inside a closed surface
    and to less wherever light from outside arrives.

    Parameters
    ----------
    to_pixels
        (p, e) sparse, from e pieces to p pixels.
    between
        (e, e) sparse, from pieces to pieces.
    pieces
        The pieces: their places, normals and albedo.
    """

    to_pixels: sparse.csr_matrix
    between: sparse.csr_matrix
    pieces: FineSamples

    def bounced(self, direct: Floats, bounces: int) -> Doubles:
        """Return what arrives at the pixels by 1 to `bounces` bounces of what arrives at the pieces directly.

        Parameters
        ----------
        direct
            (e, k) direct irradiance, or transport, of the pieces; (e, k, 3) for each colour another.
        bounces
            How many, at least 1.

        Returns
        -------
        array
            (p, k), or (p, k, 3) when the pieces or the light have colour.
        """
        albedo = self.pieces.albedo
        if direct.ndim == 3 or albedo.ndim == 2:
            colours = [
                self._one_colour(
                    direct[..., c] if direct.ndim == 3 else direct,
                    albedo[:, c] if albedo.ndim == 2 else albedo,
                    bounces,
                )
                for c in range(3)
            ]
            return np.stack(colours, axis=-1)
        return self._one_colour(direct, albedo, bounces)

    def _one_colour(self, direct: Floats, albedo: Floats, bounces: int) -> Doubles:
        thrown = direct * albedo[:, None]
        result = self.to_pixels @ thrown
        for _ in range(bounces - 1):
            thrown = (self.between @ thrown) * albedo[:, None]
            result += self.to_pixels @ thrown
        return np.asarray(result)


_LATEST: WeakKeyDictionary[Surface, tuple[int, Exchange]] = WeakKeyDictionary()  # one: it may take 200 MB


def exchange_of(surface: Surface, bounces: int) -> Exchange:
    """Return the exchange of a Surface with a scene, or else depth; that of the latest Surface is kept as it lives."""
    reach = 0 if surface.scene is None else bounces  # depth alone exchanges with all that it has at once
    known = _LATEST.get(surface)
    if known is not None and known[0] == reach:
        return known[1]
    _LATEST.clear()
    if surface.scene is None:
        found = depth_exchange(surface)
    else:
        found = mesh_exchange(surface.scene, surface.scene.samples(surface.mask), bounces)
    _LATEST[surface] = reach, found
    return found


def mesh_exchange(scene: Scene, samples: FineSamples, bounces: int, rays: int = RAYS) -> Exchange:
    """Return the exchange between the samples of a scene's pixels and the patches of its mesh.

    Only patches that light can leave for a pixel in so many bounces are in it.
    """
    patches = Patches(scene)

    def met(triangle: Integers, weights: Doubles, directions: Floats) -> tuple[Integers, Integers, Doubles]:
        behind = np.einsum("ni,ni->n", scene.triangle_normals[triangle], directions) > 0
        return np.arange(len(triangle)), patches.side(triangle, weights, behind), np.ones(len(triangle))

    to_pixels = _form_factors(scene.caster, samples, met, patches.sides, rays)
    known = np.zeros(0, dtype=np.int64)
    rows: list[sparse.csr_matrix] = []
    reached = np.unique(to_pixels.indices).astype(np.int64)
    everything = reached
    for _ in range(bounces - 1):
        fresh = np.setdiff1d(reached, known)
        found = _form_factors(scene.caster, patches.samples(fresh), met, patches.sides, PATCH_RAYS)
        rows.append(found)
        known = np.concatenate([known, fresh])
        reached = np.unique(found.indices).astype(np.int64)
        everything = np.union1d(everything, reached)
    between = sparse.csr_matrix((len(everything), len(everything)))
    if rows:
        tall = sparse.vstack(rows).tocsr()[:, everything].tocoo()
        place = np.searchsorted(everything, known)
        between = sparse.csr_matrix((tall.data, (place[tall.row], tall.col)), shape=between.shape)
    return Exchange(to_pixels[:, everything], between, patches.samples(everything))


def depth_exchange(surface: Surface, rays: int = RAYS) -> Exchange:
    """Return the exchange between the pixels of a Surface with depth: the vertices of the triangles between them."""
    mesh = mesh_from_depth(surface)
    caster = RayCaster(mesh.vertices, mesh.faces)
    samples = pixel_samples(surface)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    def met(triangle: Integers, weights: Doubles, directions: Floats) -> tuple[Integers, Integers, Doubles]:
        front = np.flatnonzero(np.einsum("ni,ni->n", normals[triangle], directions) < 0)
        return np.repeat(front, 3), mesh.faces[triangle[front]].reshape(-1), weights[front].reshape(-1)

    to_pixels = _form_factors(caster, samples, met, samples.pixels, rays)
    return Exchange(to_pixels, to_pixels, samples)


def with_bounces(direct: Floats, bounced: Floats) -> Floats:
    """Return direct transport (k, p) plus what arrives by bounces, (p, k) or (p, k, 3): (k, p) or (k, p, 3)."""
    more = bounced.swapaxes(0, 1)
    return np.asarray((direct[..., None] if more.ndim == 3 else direct) + more)


Met = Callable[[Integers, Doubles, Floats], tuple[Integers, Integers, Doubles]]


def _form_factors(caster: RayCaster, samples: FineSamples, met: Met, pieces: int, rays: int) -> sparse.csr_matrix:
    """Return the form factors from each pixel of some samples to pieces, (p, pieces).

    `met` tells what a ray meets: which rays, which pieces, with which share.
    """
    parts = samples.slots.shape[1]
    directions = sphere_directions(SETS, -(-rays // parts) * parts)
    starts = caster.starts(samples.positions, samples.geometric)
    whole = np.zeros(samples.pixels)
    result = sparse.csr_matrix((samples.pixels, pieces))
    found: list[tuple[Integers, Integers, Doubles]] = []
    for some in facing_rays(samples, directions):
        whole[some.pixels] = some.unshadowed.sum(axis=(0, 2))
        triangle, weights = caster.hits_from(starts[some.sample], some.directions)
        hit = np.flatnonzero(triangle >= 0)
        which, piece, share = met(triangle[hit], weights[hit], some.directions[hit])
        found.append((some.pixel[hit[which]], piece, some.cosine[hit[which]] * share))
        if sum(len(piece) for _, piece, _ in found) > BLOCK:
            result = result + _collected(found, result.shape)
            found.clear()
    result = result + _collected(found, result.shape)
    whole = np.divide(1, whole, out=whole, where=whole > 0)
    return sparse.csr_matrix(sparse.diags(whole) @ result)


def _collected(found: list[tuple[Integers, Integers, Doubles]], shape: tuple[int, int]) -> sparse.csr_matrix:
    """Return rows, columns and values as a matrix; values at the same place are added."""
    if not found:
        return sparse.csr_matrix(shape)
    rows, columns, values = (np.concatenate(part) for part in zip(*found, strict=True))
    return sparse.csr_matrix((values, (rows, columns)), shape=shape)
