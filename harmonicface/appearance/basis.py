"""Harmonic images: the few pictures whose combinations are all pictures of a matte Surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance._options import checked_order, with_shadows
from harmonicface.harmonics.basis import scaled_harmonics
from harmonicface.io.colour import LUMINANCE, luminance
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport


def harmonic_images(surface: Surface, order: int = 2, shadows: bool = False, bounces: int = 0) -> Floats:
    r"""Return the images of a Surface under each harmonic light, (k, p).

    .. math:: b_{lm}(x) = \rho(x) A_l Y_{lm}(n(x)) \quad\text{or, with shadows,}\quad b_{lm}(x) = \rho(x) T_{lm}(x)

    so that `photo = light.coefficients(order) @ images` (Basri & Jacobs, Lambertian Reflectance and Linear
    Subspaces, 2003, section 3.2; Sloan, Kautz & Snyder, Precomputed Radiance Transfer, 2002, for T). Attached
    shadows are in them; cast shadows are, if asked for.

    Where the albedo or the transport has colour, the images are the luminance of the coloured ones, as a grey
    photograph under grey light is: 0.2126 rho_R T_R + 0.7152 rho_G T_G + 0.0722 rho_B T_B.

    Parameters
    ----------
    surface
        Its albedo rho is taken as luminance when it has colour. For shadows it needs depth or a scene.
    order
        The highest degree l, at most 200, with shadows 12: 1 gives four images, 2 gives nine, which hold 99.22 % of
        the energy.
    shadows
        With cast shadows; see `transport`.
    bounces
        How often light may be thrown back from surface to surface; more than 0 implies shadows.

    Returns
    -------
    array
        (k, p) with k = (order + 1)^2 and p masked pixels in row-major order; one contiguous row a harmonic.

    Raises
    ------
    HarmonicFaceError
        An order or a number of bounces out of range, shadows of a Surface with neither depth nor scene.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2)))
    >>> hf.harmonic_images(wall)[:, 0].round(4)
    array([0.8862, 0.    , 1.0233, 0.    , 0.    , 0.    , 0.4954, 0.    , 0.    ])
    """
    if with_shadows(shadows, bounces):
        return _shadowed_images(surface, order, bounces)
    checked_order(order)
    normals, albedo = _pixels(surface.normals, surface.mask), _pixels(surface.albedo, surface.mask)
    return scaled_harmonics(normals, order, lambertian_filter(order), luminance(albedo) if albedo.ndim == 2 else albedo)


def _pixels(values: Floats, mask: NDArray[np.bool_]) -> Floats:
    """Return the masked pixels in row-major order, without a copy where they are all of them."""
    flat = values.reshape(-1, *values.shape[2:])
    return flat if mask.all() else flat.take(np.flatnonzero(mask), axis=0)


def _shadowed_images(surface: Surface, order: int, bounces: int) -> Floats:
    """Return albedo times transport, as luminance."""
    values = transport(surface, order, bounces).values
    if values.ndim == 2:
        return np.asarray(values * surface.grey_albedo.astype(values.dtype, copy=False))
    albedo = surface.pixel_albedo.reshape(values.shape[1], -1)
    return np.asarray(np.einsum("kpc,pc->kp", values, (albedo * LUMINANCE).astype(values.dtype)))
