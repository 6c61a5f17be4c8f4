"""Transport by rays: how much of each harmonic light reaches the pixels past all of a mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.surfaces.blockers import Blocker, MeshBlocker
from harmonicface.surfaces.interreflection import PATCH_RAYS, exchange_of, with_bounces
from harmonicface.surfaces.scene import FineSamples
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.visible_sums import Doubles, sphere_directions, visible_sums

RAYS = 512  # directions on the sphere a pixel; half of them are below its horizon and cost nothing
SETS = 64
BLOCK = 1 << 14  # normals whose harmonics are held at once
TOGETHER = 1 << 15  # pixels whose sums are held at once


def ray_transport(surface: Surface, order: int = 4, bounces: int = 0, rays: int = RAYS) -> Floats:
    r"""Return T_lm(x) = \int V max(n.w, 0) Y_lm dw of the masked pixels of a Surface with a scene, (k, p).

    Each pixel sends rays into directions spread evenly over the sphere, each from another of its finer samples, so
    that the result is the mean over the pixel's area. The exact transport without shadows is a control variate:
    with Q the sums over directions and c the share of them that is open, weighted by the cosine,

    .. math:: T_{lm} = Q_{lm}[V] + c \, (A_l Y_{lm}(n) - Q_{lm}[1]), \quad c = Q_{00}[V] / Q_{00}[1]

    which is exact where nothing is in the way and 0 where nothing gets through. On a scanned face (15,394 pixels,
    order 4) the RMS error relative to 8,192 directions is 2.1 % with 256, 1.2 % with 512 and 0.8 % with 1,024; it
    falls with the 0.7th power of their number, the time grows with the first.

    Parameters
    ----------
    surface
        What `surface_from_mesh` made. A triangle that faces away from a direction gets no light from it, even where
        its smooth normal would.
    order
        The highest degree l.
    bounces
        How often light may be thrown back from surface to surface before it arrives.
    rays
        Directions over the whole sphere for each pixel, at least 1; rounded up to a multiple of its samples.

    Returns
    -------
    array
        (k, p) of the type of the Surface's normals, p masked pixels in row-major order; (k, p, 3) with bounces
        between coloured surfaces.

    Raises
    ------
    HarmonicFaceError
        A Surface without scene, or one whose mask is not what the scene's view sees; a negative order or count.
    """
    if surface.scene is None:
        raise HarmonicFaceError("surface: expected one with a scene (surface_from_mesh makes it), got none")
    _validate.at_least(order, 0, "order")
    _validate.at_least(bounces, 0, "bounces")
    _validate.at_least(rays, 1, "rays")
    scene = surface.scene
    samples = scene.samples(surface.mask)
    direct = direct_transport(MeshBlocker(scene.caster, samples), samples, order, rays)
    if bounces:
        exchange = exchange_of(surface, bounces)
        arriving = direct_transport(MeshBlocker(scene.caster, exchange.pieces), exchange.pieces, order, PATCH_RAYS)
        return with_bounces(direct, exchange.bounced(arriving.T, bounces)).astype(surface.normals.dtype)
    return direct.astype(surface.normals.dtype)


def direct_transport(blocker: Blocker, samples: FineSamples, order: int, rays: int = RAYS) -> Doubles:
    """Return the transport without bounces to the pixels of some samples, (k, p)."""
    parts = samples.slots.shape[1]
    directions = sphere_directions(SETS, -(-rays // parts) * parts)
    harmonics = np.moveaxis(real_harmonics(directions, order), 0, -1)  # (sets, r, k)
    brought = 4 * np.pi / directions.shape[1] * harmonics
    result = unshadowed_transport(samples, order)
    for first in range(0, samples.pixels, TOGETHER):
        some = slice(first, first + TOGETHER)
        visible, everything = visible_sums(blocker, replace(samples, slots=samples.slots[some]), directions, brought)
        share = np.divide(visible[0], everything[0], out=np.zeros_like(visible[0]), where=everything[0] > 0)
        result[:, some] = visible + share * (result[:, some] - everything)
    return result


def unshadowed_transport(samples: FineSamples, order: int) -> Doubles:
    """Return A_l Y_lm of the normals, averaged over the samples of each pixel, (k, p)."""
    shape = (count(order), samples.pixels)
    result: Doubles = _memory.empty(shape, np.float64, f"transport of order {order} at {samples.pixels} pixels")
    counts = np.bincount(samples.pixel, minlength=samples.pixels)
    ends = np.cumsum(counts)  # samples are in the order of their pixels
    step = max(1, BLOCK // samples.slots.shape[1])
    for first in range(0, samples.pixels, step):
        some = slice(first, first + step)
        starts = ends[some] - counts[some]
        harmonics = real_harmonics(samples.normals[starts[0] : ends[some][-1]], order)
        result[:, some] = np.add.reduceat(harmonics, starts - starts[0], axis=1) / counts[some]
    result *= lambertian_weights(order)[:, None]
    return result
