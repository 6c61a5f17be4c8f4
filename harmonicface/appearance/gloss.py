"""Gloss: what a coat of a Surface mirrors of the light toward the camera."""

from __future__ import annotations

import math
from functools import partial, reduce

import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.colours import colourwise
from harmonicface.appearance.specular_shadows import LobeRays, open_share
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count
from harmonicface.lighting._clamped_cosine import sum_lobe
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.gathering import gathered
from harmonicface.lighting.layouts import layout_named
from harmonicface.lighting.light import HarmonicLight, Light, SumOfLights
from harmonicface.lighting.prefiltered import reflected
from harmonicface.lighting.sources import AmbientLight, DirectionalLights
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.perspective import PerspectiveView
from harmonicface.surfaces.surface import Surface

NARROWEST = 0.75  # pixels of a map: a lobe of this width summed over their centres errs by about 0.2 %
FINENESS = 1 / 8  # of a lobe's width: pixels of a map that are finer are put together, which changes 0.1 %
BLOCK = 1 << 23  # harmonics held at once, 64 MB


def gloss(
    surface: Surface, light: Light, material: Material, order: int | None = None, shadows: bool = False
) -> Floats:
    r"""Return what the coat of a Surface adds to its picture, in the picture's units (pi times radiance).

    .. math:: B_s(x) = \pi F(n \cdot v) \int L(w) \, \mathrm{lobe}(R \cdot w) \, dw
              = \pi F(n \cdot v) \sum_{lm} f_l L_{lm} Y_{lm}(R), \quad R = 2 (n \cdot v) n - v

    with v toward the camera, R its mirror image and F the material's reflectance (Ramamoorthi & Hanrahan, A
    Signal-Processing Framework for Reflection, 2004, sections 5.2 and 5.3). Light that is the same from everywhere adds
    F f_0 times its irradiance.

    Modelled: a lobe of one shape about R for every normal, the reflectance at the angle of view; with `shadows` the
    surface's own horizon and what casts shadows. Not modelled: the horizon without `shadows`, a lobe that grows longer
    at grazing angles, light mirrored twice or mirrored after it was thrown back by skin. The camera is far away along z
    unless the scene was seen by a pinhole.

    Parameters
    ----------
    surface
        What is seen.
    light
        What falls on it.
    material
        Its coat.
    order
        None for the lobe summed over the light's own directions: exact for lamps, light from everywhere and harmonics,
        and for a map to 0.1 %; where the lobe is narrower than the map's pixels it shows the map itself. Otherwise
        by harmonics, and not only up to this order: up to the degree above which the lobe lets less than 1 % through
        (`Material.highest_degree`). Discs are always summed that way.
    shadows
        Light is also kept from the coat. Without an order lamp by lamp, exactly; other light is multiplied with the
        share of 96 rays through the lobe that are open, each weighted with the light from there if that is a map. By
        harmonics, it is multiplied with the share that the transport of this order tells (`open_share`), whatever part
        of the lobe the light comes from: under light from behind the head it hides too little.

    Returns
    -------
    array
        (p,) or (p, 3) over the masked pixels in row-major order.

    Raises
    ------
    HarmonicFaceError
        No material, a lobe too narrow for harmonics, shadows of a Surface with neither depth nor scene.
    """
    if not isinstance(material, Material):
        raise HarmonicFaceError(f"material: expected Phong or Microfacet, got {_validate.describe(material)}")
    normals = surface.pixel_normals
    view = view_directions(surface).astype(normals.dtype)
    facing = np.einsum("pi,pi->p", normals, view)
    mirrored = _unit(2 * facing[:, None] * normals - view)
    if shadows and order is None:
        received = _past_obstacles(LobeRays(surface), light, material, mirrored)
    else:
        received = (_exactly if order is None else _by_harmonics)(light, material, mirrored)
    strength = math.pi * material.reflectance(facing)
    if shadows and order is not None:
        strength *= open_share(surface, mirrored, material, order)
    return colourwise(np.multiply, received, strength).astype(normals.dtype, copy=False)


def view_directions(surface: Surface) -> Floats:
    """Return unit vectors from the masked pixels to the camera, (p, 3): z, unless the scene was seen by a pinhole."""
    view = None if surface.scene is None else surface.scene.view
    if not isinstance(view, PerspectiveView):
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), (int(surface.mask.sum()), 3))
    rows, columns = np.nonzero(surface.mask)
    fx, fy, cx, cy = view.intrinsics
    return _unit(np.stack([(cx - columns - 0.5) / fx, (rows + 0.5 - cy) / fy, np.ones(len(rows))], axis=1))


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _exactly(light: Light, material: Material, mirrored: Floats) -> Floats:
    """Return the lobe's share of the light, summed over what the light is made of."""
    if isinstance(light, SumOfLights):
        parts = [_exactly(part, material, mirrored) for part in light.parts]
        return reduce(partial(colourwise, np.add), parts)
    if isinstance(light, DirectionalLights):
        return sum_lobe(mirrored, light.directions, light.strengths, material.lobe)
    if isinstance(light, EnvironmentMap):
        return _of_map(light, material, mirrored)
    if isinstance(light, (AmbientLight, HarmonicLight)):
        known = light.order if isinstance(light, HarmonicLight) else 0
        return _series(light, material, mirrored, known)
    return _by_harmonics(light, material, mirrored)


def _of_map(light: EnvironmentMap, material: Material, mirrored: Floats) -> Floats:
    """Sum over pixels; a lobe narrower than they are falls between their centres, and shows the map itself."""
    if material.width < NARROWEST * layout_named(light.layout).spacing(light.shape):
        return np.asarray(material.filter(0)[0] * light.radiance_toward(mirrored))
    return sum_lobe(mirrored, *gathered(*light.lamps(), FINENESS * material.width), material.lobe)


def _by_harmonics(light: Light, material: Material, mirrored: Floats) -> Floats:
    """Return the lobe's share of the light as far as its filter reaches."""
    return _series(light, material, mirrored, material.highest_degree())


def _series(light: Light, material: Material, mirrored: Floats, order: int) -> Floats:
    """Sum the harmonics up to an order, a block of pixels at a time."""
    known, factors = HarmonicLight(light.coefficients(order)), material.filter(order)
    rows = max(1, BLOCK // count(order))
    blocks = [mirrored[first : first + rows] for first in range(0, len(mirrored), rows)]
    return np.concatenate([reflected(known, factors, block) for block in blocks])


def _past_obstacles(rays: LobeRays, light: Light, material: Material, mirrored: Floats) -> Floats:
    """Return the same with what is in the way: lamps one by one, other light by rays through the lobe."""
    if isinstance(light, SumOfLights):
        parts = [_past_obstacles(rays, part, material, mirrored) for part in light.parts]
        return reduce(partial(colourwise, np.add), parts)
    if not isinstance(light, DirectionalLights):
        return colourwise(np.multiply, _exactly(light, material, mirrored), _share(rays, light, material, mirrored))
    total = np.zeros((len(mirrored), *light.strengths.shape[1:]))
    for lamp, strength, reached in zip(light.directions, light.strengths, rays.reaching(light.directions), strict=True):
        lobe = material.lobe(np.clip(mirrored @ lamp, -1, 1)) * reached
        total += np.multiply.outer(lobe, strength)
    return total


def _share(rays: LobeRays, light: Light, material: Material, mirrored: Floats) -> Floats:
    """Return the share of a lobe's light that nothing hides, (p,), or (p, 3) of a coloured map."""
    colours = (light.channels,) if isinstance(light, EnvironmentMap) and light.channels > 1 else ()
    arriving, all_ = np.zeros((len(mirrored), *colours)), np.zeros((len(mirrored), *colours))
    for towards, is_open in rays.through_lobes(mirrored, material):
        sent = light.radiance_toward(towards) if isinstance(light, EnvironmentMap) else np.ones(len(mirrored))
        all_ += sent
        arriving += sent * (is_open[:, None] if colours else is_open)
    return np.divide(arriving, all_, out=np.zeros_like(all_), where=all_ > 0)
