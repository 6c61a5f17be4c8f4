"""Pictures of a Surface under a light."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats
from harmonicface.lighting.light import HarmonicLight, Light
from harmonicface.surfaces.surface import Surface


def render(surface: Surface, light: Light, order: int | None = None) -> Floats:
    r"""Return the picture of a matte Surface: albedo times irradiance, B = \rho E(n).

    Exact unless told otherwise: the clamped cosine is summed over the light's own directions. With `order`, by the
    light's harmonics (Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001,
    equation 7). No cast shadows, no interreflection.

    Parameters
    ----------
    surface
        What is seen.
    light
        What falls on it.
    order
        None for the exact sum; otherwise the highest degree of the harmonic approximation.

    Returns
    -------
    array
        (h, w), or (h, w, 3) when the surface or the light has colour; 0 outside the mask. A unit directional light
        on a white wall facing it gives 1.

    Raises
    ------
    HarmonicFaceError
        A negative order.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.full((1, 2), 0.5))
    >>> hf.render(wall, hf.lights.directional([0.0, 0.6, 0.8]))
    array([[0.4, 0.4]])
    """
    source = light if order is None else HarmonicLight(light.coefficients(order))
    irradiance = source.irradiance(surface.pixel_normals)
    albedo = surface.pixel_albedo
    if irradiance.ndim != albedo.ndim:
        irradiance, albedo = (array if array.ndim == 2 else array[:, None] for array in (irradiance, albedo))
    pixels = albedo * irradiance
    picture = np.zeros((*surface.shape, *pixels.shape[1:]), pixels.dtype)
    picture[surface.mask] = pixels
    return picture
