"""Specular shadows: how much of what a coat mirrors is hidden by the rest of the surface."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.blockers import Blocker, DepthBlocker, MeshBlocker, pixel_samples
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport

Doubles = NDArray[np.float64]

RAYS = 96  # in the lobe of a pixel
ANGLES = 4096  # at which a lobe is tabulated
GOLDEN = np.pi * (3 - np.sqrt(5))


def open_share(surface: Surface, mirrored: Floats, material: Material, order: int) -> Floats:
    r"""Return the share of each pixel's lobe that nothing hides, as far as a transport of an order tells, (p,).

    .. math:: \frac{\int V(w) \max(n \cdot w, 0) \, \mathrm{lobe}(R \cdot w) \, dw}
                   {\int \max(n \cdot w, 0) \, \mathrm{lobe}(R \cdot w) \, dw}
              \approx \frac{\sum_{lm} f_l T_{lm} Y_{lm}(R)}{\sum_{lm} f_l A_l Y_{lm}(n) Y_{lm}(R)}

    cut to 0 to 1. The transport is the visibility times the cosine, and both integrals are cut at the same order: a
    surface that nothing shadows gets 1. The lobe it resolves is pi / order wide at best.

    Parameters
    ----------
    surface
        With depth or a scene, or with a transport of this order.
    mirrored
        (p, 3) unit vectors R.
    material
        What shines.
    order
        Of the transport.

    Raises
    ------
    HarmonicFaceError
        A Surface with none of these.
    """
    reaching = transport(surface, order).values
    factors = material.filter(order)[degrees(order)][:, None]
    lobes = factors * real_harmonics(mirrored, order)
    free = (lambertian_weights(order)[:, None] * lobes * real_harmonics(surface.pixel_normals, order)).sum(axis=0)
    share = np.divide((lobes * reaching).sum(axis=0), free, out=np.zeros_like(free), where=free > 0)
    return np.asarray(np.clip(share, 0, 1))


class LobeRays:
    """What of a Surface sees lamps, and directions in the lobe about what each pixel mirrors.

    Parameters
    ----------
    surface
        With a scene, or with depth: the mesh is in the way, or without one the Surface's own depth.

    Raises
    ------
    HarmonicFaceError
        A Surface with neither.
    """

    def __init__(self, surface: Surface) -> None:
        self._blocker: Blocker
        if surface.scene is not None:  # several samples a pixel: the edge of a shadow is as soft as the pixel is wide
            self._samples = surface.scene.samples(surface.mask)
            self._blocker = MeshBlocker(surface.scene.caster, self._samples)
        elif surface.depth is not None:
            self._samples = pixel_samples(surface)
            self._blocker = DepthBlocker(surface)
        else:
            raise HarmonicFaceError("surface: expected a scene or depth, which cast the shadows, got neither")

    def reaching(self, directions: Floats) -> Iterator[Floats]:
        """Yield the share of each pixel that each lamp reaches, (p,): the mean over its samples.

        Of many lamps each looks at one sample of a pixel, another one each.
        """
        parts = self._samples.slots.shape[1]
        for number, direction in enumerate(directions):
            if len(directions) < parts:
                chosen = np.arange(len(self._samples.positions))
                yield self._samples.means(self._open(chosen, direction).astype(np.float64))
            else:
                yield self._open(self._samples.slots[:, number % parts], direction).astype(np.float64)

    def through_lobes(self, mirrored: Floats, material: Material) -> Iterator[tuple[Doubles, NDArray[np.bool_]]]:
        """Yield directions (p, 3) in the lobe of each pixel, equally likely, and which are open, (p,)."""
        polar = _quantiles(material)
        across, along = _tangents(mirrored)
        turn = np.random.default_rng(0).uniform(0, 2 * np.pi, len(mirrored))
        for number, angle in enumerate(polar):
            around = turn + number * GOLDEN
            sideways = np.cos(around)[:, None] * across + np.sin(around)[:, None] * along
            towards = np.cos(angle) * mirrored + np.sin(angle) * sideways
            chosen = self._samples.slots[:, number % self._samples.slots.shape[1]]
            yield towards, self._open(chosen, towards)

    def _open(self, chosen: NDArray[np.int64], towards: Floats) -> NDArray[np.bool_]:
        """Tell from which samples nothing hides one direction, (3,), or each its own; what is behind is hidden."""
        above = (_dot(self._samples.geometric[chosen], towards) > 0) & (
            _dot(self._samples.normals[chosen], towards) > 0
        )
        if towards.ndim == 1:
            hidden = self._blocker.blocked_toward(chosen[above], towards)
        else:
            hidden = self._blocker.blocked(chosen[above], towards[above])
        above[above] = ~hidden
        return above


def _dot(normals: Floats, towards: Floats) -> Floats:
    """Return the cosines of normals (n, 3) with one direction or with one each."""
    return np.asarray(np.einsum("ni,ni->n", normals, np.broadcast_to(towards, normals.shape)))


def _quantiles(material: Material) -> Doubles:
    """Return angles from the mirror direction, each in the middle of an equal share of the lobe, (RAYS,)."""
    farthest = min(np.pi / 2, 8 * material.width)  # nothing of a narrow lobe is beyond, and it is to be seen finely
    angles = np.linspace(0, farthest, ANGLES)
    below = np.cumsum(material.lobe(np.cos(angles)) * np.sin(angles))
    return np.asarray(np.interp((np.arange(RAYS) + 0.5) / RAYS * below[-1], below, angles))


def _tangents(axes: Floats) -> tuple[Doubles, Doubles]:
    """Return two unit vectors across each axis and each other, (p, 3) each."""
    helper = np.where(np.abs(axes[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    across = np.cross(axes, helper)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(axes, across)
