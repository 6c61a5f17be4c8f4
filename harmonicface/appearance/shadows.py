"""Shadows: the exact irradiance of a Surface under any light past all that stands in its way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.light_directions import RAYS, Spread, parts_of
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.lighting.light import HarmonicLight, Light
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.blockers import Blocker, DepthBlocker, MeshBlocker, pixel_samples
from harmonicface.surfaces.interreflection import PATCH_RAYS, exchange_of
from harmonicface.surfaces.ray_transport import RAYS as TRANSPORT_RAYS
from harmonicface.surfaces.ray_transport import direct_transport
from harmonicface.surfaces.scene import FineSamples
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.visible_sums import visible_sums

Doubles = NDArray[np.float64]


def shadowed_irradiance(surface: Surface, light: Light, bounces: int = 0) -> Floats:
    r"""Return E(x) = \int V(x, w) L(w) max(n.w, 0) dw of the masked pixels, with cast shadows.

    A Surface with a scene is shadowed by all of its mesh: a pixel is the mean over 4 x 4 points of the mesh in it, each
    with its own shadows. That division decides the error where a hard shadow ends within a pixel: against a path
    tracer with the same pixels, a scanned face at 128 x 128 under one lamp differs by 0.4 % RMS. A triangle that faces
    away from a lamp gets no light from it even where its smooth normal would (the terminator of a coarse mesh is that
    of its triangles), as renderers do that take a surface for opaque. A Surface with depth alone is shadowed by its
    horizons, one point a pixel.

    Up to 16 directional lights cast hard shadows, tested one by one. Of any other light, 1,024 directions are tested at
    each pixel, more where it is bright (see `light_directions`); the exact irradiance without shadows is multiplied by
    the share of them, by strength and cosine, that is open. So it is exact where nothing is in the way; of a map of
    more than 2,048 pixels, to 5e-4. Harmonic light goes through the transport of its order.

    Parameters
    ----------
    surface
        What is lit; it needs a scene (`surface_from_mesh`) or depth.
    light
        What falls on it.
    bounces
        How often light may be thrown back from surface to surface before it arrives.

    Returns
    -------
    array
        (p,) over the masked pixels in row-major order, of the type of the normals; (p, 3) under coloured light, or with
        bounces between coloured surfaces.

    Raises
    ------
    HarmonicFaceError
        A Surface with neither scene nor depth, a negative count of bounces, a light not of this package.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> step = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 3, 1)), np.ones((1, 3)), depth=np.array([[0.0, 0.0, 5.0]]))
    >>> shadowed_irradiance(step, hf.lights.directional([0.6, 0.0, 0.8]))
    array([0. , 0. , 0.8])
    """
    _validate.at_least(bounces, 0, "bounces")
    samples, blocker = _receivers(surface)
    result = _arriving(samples, blocker, light, np.ones((len(samples.normals), 1)))
    if bounces:
        result = result + _thrown_back(surface, blocker, light, bounces)
    return _shaped(result).astype(surface.normals.dtype)


def shadowed_radiosity(surface: Surface, light: Light, bounces: int = 0) -> Floats:
    r"""Return B(x) = \rho E with cast shadows: `shadowed_irradiance`, but the mean over a pixel is that of the product.

    Where both change within a pixel, the mean of the product is not the product of the means; a photograph records the
    former.

    Returns
    -------
    array
        (p,) over the masked pixels in row-major order; (p, 3) when the surface or the light has colour.
    """
    _validate.at_least(bounces, 0, "bounces")
    samples, blocker = _receivers(surface)
    own = _columns(surface.pixel_albedo)
    factor, mean = _relative_albedo(samples, own.shape[1])
    thrown = own / mean * _arriving(samples, blocker, light, factor)
    if bounces:
        thrown = thrown + own * _thrown_back(surface, blocker, light, bounces)
    return _shaped(thrown).astype(surface.normals.dtype)


def _relative_albedo(samples: FineSamples, colours: int) -> tuple[Doubles, Doubles]:
    """Return the albedo of each sample, (n, 1 or 3), and its mean over each pixel; 1 in pixels that are black.

    The Surface's own albedo, by which the caller multiplies, may have been changed since the mesh was seen.
    """
    albedo = _columns(samples.albedo if colours == 3 or samples.albedo.ndim == 1 else luminance(samples.albedo))
    albedo = np.where(samples.means(albedo)[samples.pixel] > 0, albedo, 1.0)
    return albedo, np.asarray(samples.means(albedo), dtype=np.float64)


def _receivers(surface: Surface) -> tuple[FineSamples, Blocker]:
    """Return where the light of a Surface arrives, and what is in its way."""
    if surface.scene is not None:
        samples = surface.scene.samples(surface.mask)
        return samples, MeshBlocker(surface.scene.caster, samples)
    if surface.depth is None:
        raise HarmonicFaceError("surface: expected a scene or depth, which cast the shadows, got neither")
    return pixel_samples(surface), DepthBlocker(surface)


def _shaped(values: Doubles) -> Doubles:
    """Return (p, 1) as (p,), and (p, 3) as it is."""
    return values[:, 0] if values.shape[1] == 1 else values


def _columns(values: Floats) -> Doubles:
    """Return (n,) or (n, 3) as (n, 1) or (n, 3)."""
    return values.reshape(len(values), 3 if values.ndim == 2 else 1).astype(np.float64)


def _arriving(samples: FineSamples, blocker: Blocker, light: Light, factor: Doubles, rays: int = RAYS) -> Doubles:
    """Return the mean of a factor (n, 1 or 3) of the samples times the irradiance, (p, 1 or 3)."""
    result = np.zeros((samples.pixels, max(light.channels, factor.shape[1])))
    parts = samples.slots.shape[1]
    for part in parts_of(light, -(-rays // parts) * parts):
        if isinstance(part, DirectionalLights):
            result += samples.means(factor * _of_lamps(samples, blocker, part))
        elif isinstance(part, HarmonicLight):
            reaching = direct_transport(blocker, samples, part.order, min(rays, TRANSPORT_RAYS))
            result += samples.means(factor) * (reaching.T @ _columns(part.values))
        else:
            unshadowed = samples.means(factor * _columns(part.irradiance(samples.normals)))
            result += unshadowed * _open_share(samples, blocker, part)
    return result


def _thrown_back(surface: Surface, blocker: Blocker, light: Light, bounces: int) -> Doubles:
    """Return the irradiance of the pixels from light that the surface throws on itself, (p, 1 or 3)."""
    exchange = exchange_of(surface, bounces)
    if surface.scene is not None:
        blocker = MeshBlocker(surface.scene.caster, exchange.pieces)
    pieces = exchange.pieces
    direct = _arriving(pieces, blocker, light, np.ones((pieces.pixels, 1)), PATCH_RAYS)
    coloured = direct.shape[1] == 3
    bounced = exchange.bounced(direct[:, None] if coloured else direct, bounces)  # each colour its own light
    return bounced.reshape(len(bounced), -1)


def _of_lamps(samples: FineSamples, blocker: Blocker, lamps: DirectionalLights) -> Doubles:
    """Return the irradiance of each sample under a few lamps with hard shadows, (n, 1 or 3)."""
    strengths = _columns(lamps.strengths)
    result = np.zeros((len(samples.normals), strengths.shape[1]))
    for direction, strength in zip(lamps.directions.astype(np.float64), strengths, strict=True):
        cosine = samples.normals @ direction
        facing = np.flatnonzero((cosine > 0) & (samples.geometric @ direction > 0))
        lit = facing[~blocker.blocked_toward(facing, direction)]
        result[lit] += cosine[lit, None] * strength
    return result


def _open_share(samples: FineSamples, blocker: Blocker, light: Spread) -> Doubles:
    """Return the share of the light that gets through to each pixel, (p, 1 or 3)."""
    visible, everything = visible_sums(blocker, samples, light.directions, light.weights)
    return np.divide(visible, everything, out=np.zeros_like(visible), where=everything > 0).T
