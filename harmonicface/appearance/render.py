"""Pictures of a Surface under a light."""

from __future__ import annotations

import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance._options import with_shadows
from harmonicface.appearance.colours import colourwise
from harmonicface.appearance.gloss import gloss
from harmonicface.appearance.irradiance import surface_irradiance
from harmonicface.appearance.shadows import shadowed_radiosity
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.as_light import LightLike, as_light
from harmonicface.lighting.light import Light
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.surface import Surface


def render(
    surface: Surface,
    light: LightLike,
    order: int | None = None,
    material: Material | None = None,
    shadows: bool = False,
    bounces: int = 0,
) -> Floats:
    r"""Return the picture of a Surface: albedo times irradiance, B = \rho E, and what a glossy coat adds.

    Exact unless told otherwise: the clamped cosine is summed over the light's own directions, with `shadows` as far as
    nothing is in their way (`shadowed_radiosity`). With `order`, by the light's harmonics (Ramamoorthi & Hanrahan, An
    Efficient Representation for Irradiance Environment Maps, 2001, equation 7), with `shadows` times the transport
    (Sloan, Kautz & Snyder, Precomputed Radiance Transfer, 2002).

    Parameters
    ----------
    surface
        What is seen. For shadows it needs depth or a scene.
    light
        What falls on it: a Light, a published name, coefficients, a direction, or a list (see `as_light`).
    order
        None for the exact sum; otherwise the highest degree of the harmonic approximation, at most 200, with shadows
        12 (see `transport`).
    material
        `Phong` or `Microfacet`: a coat that shines on top of the matte albedo (see `gloss`). None: matte.
    shadows
        With cast shadows: of all of the mesh that the Surface was seen from (its `scene`), or of its depth alone. A
        saved Surface has no scene any more, so its exact shadows are those of its depth, and so are harmonic ones of a
        higher order, or with other bounces, than the transports that were saved with it.
    bounces
        How often light may be thrown back from surface to surface; more than 0 implies shadows.

    Returns
    -------
    array
        (h, w), or (h, w, 3) when the surface or the light has colour; 0 outside the mask. A unit directional light
        on a white wall facing it gives 1.

    Raises
    ------
    HarmonicFaceError
        No Surface, no light, no material, an order or a count of bounces out of range, shadows of a Surface with
        neither depth nor scene.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.full((1, 2), 0.5))
    >>> hf.render(wall, hf.lights.directional([0.0, 0.6, 0.8]))
    array([[0.4, 0.4]])
    """
    if not isinstance(surface, Surface):
        raise HarmonicFaceError(f"surface: expected a Surface, got {_validate.describe(surface)}")
    casting = with_shadows(shadows, bounces)
    source = as_light(light)
    pixels = _matte(surface, source, order, casting, bounces)
    if material is not None:
        pixels = colourwise(np.add, pixels, gloss(surface, source, material, order, casting))
    picture = np.zeros((*surface.shape, *pixels.shape[1:]), pixels.dtype)
    picture[surface.mask] = pixels
    return picture


def _matte(surface: Surface, light: Light, order: int | None, shadows: bool, bounces: int) -> Floats:
    """Return albedo times irradiance, (p,) or (p, 3)."""
    if order is None and shadows:
        return shadowed_radiosity(surface, light, bounces)
    irradiance = surface_irradiance(surface, light, order, shadows, bounces)
    return colourwise(np.multiply, surface.pixel_albedo, irradiance)
