"""Relighting: a photograph of a known Surface as it would be under another light, its own detail kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance._options import with_shadows
from harmonicface.appearance.gloss import gloss
from harmonicface.appearance.irradiance import surface_irradiance
from harmonicface.appearance.nonnegative_light import nonnegative_light
from harmonicface.appearance.shadowed_light import shadowed_light
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.lighting.as_light import LightLike, as_light
from harmonicface.lighting.light import Light
from harmonicface.reflectance._arguments import at_least_zero
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.surface import Surface


def relight(
    photo: ArrayLike,
    surface: Surface,
    light: LightLike,
    photo_light: LightLike | None = None,
    order: int | None = None,
    *,
    shadows: bool = False,
    bounces: int = 0,
    material: Material | None = None,
    floor: float = 0.1,
) -> Floats:
    r"""Return a photograph as it would be under another light.

    .. math:: I' = a \, E'(x) + S'(x), \quad
              a(x) = \frac{(I - S) \, E + \kappa^2 \rho}{E^2 + \kappa^2}

    with the irradiances E, E' and the gloss S, S' of the Surface under the old and the new light. Where the old light
    is strong, a is (I - S) / E: what the photograph shows, with every pore and freckle that the Surface's albedo rho
    lacks, is multiplied with the ratio of two pictures (Riklin-Raviv & Shashua, The Quotient Image, 2001; Wen, Liu &
    Huang, Face Relighting with Radiance Environment Maps, 2003). Where it is weak that quotient is noise, and a goes
    over to rho. It is the mean of the albedo given the photograph, if the noise has the standard deviation sigma, the
    albedo differs from rho by tau, and kappa = sigma / tau: noise grows by E' / (2 kappa) at most.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities, in place on the Surface.
    surface
        Whose photograph it is.
    light
        The new light; anything that `as_light` takes.
    photo_light
        The light of the photograph. If not given it is what `nonnegative_light` explains the photograph with: 500
        lamps, as if the Surface were matte; with shadows `shadowed_light`. Of ten faces without noise, whose known
        albedo lacked the finer half of the texture, it left 1.6 % at the median between natural lights and 2.7 %
        between lamps (the known light .2 and 1.3 %; nine harmonics of `estimate_light` 5 and 18 %; a picture from the
        albedo alone 9 and 10 %).
    order
        Of the harmonics by which both lights arrive, fast for a light with many directions; None for the exact sums.
        Irradiance below 0, which cut series have, is taken as 0. With shadows prefer the exact sums: on a scanned head
        between two environments order 4 left 27 % where they left 0.6 %.
    shadows, bounces
        Of both lights, as for `render`.
    material
        The coat, taken off the photograph under the old light and put on under the new one; None: all is matte.
    floor
        kappa as a fraction of the root mean square of E over the Surface, at least 0: 0.1 for noise of 1 % and an
        albedo known to 0.1. 0 is the plain quotient, and rho where no light was.

    Returns
    -------
    array
        (h, w), or (h, w, 3) where photograph or light have colour; outside the mask the photograph as it is.

    Raises
    ------
    HarmonicFaceError
        A photo of another shape, NaN in the mask, no Surface, no light, a photograph from which none can be estimated,
        a floor below 0, and whatever `render` refuses.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.full((1, 2), 0.5))
    >>> photo = np.array([[0.4, 0.3]])  # the wall under a lamp; its second pixel has a spot that nobody told of
    >>> relight(photo, wall, [0, 0.8, 0.6], photo_light=[0, 0.6, 0.8], floor=0)
    array([[0.3  , 0.225]])
    """
    if not isinstance(surface, Surface):
        raise HarmonicFaceError(f"surface: expected a Surface, got {_validate.describe(surface)}")
    casting = with_shadows(shadows, bounces)
    picture = _checked(photo, surface)
    floor = at_least_zero(floor, "floor")
    new = as_light(light)
    old = _estimated(picture, surface, casting) if photo_light is None else as_light(photo_light)
    before, after = (
        np.maximum(_columns(surface_irradiance(surface, each, order, shadows, bounces)), 0) for each in (old, new)
    )
    shone: Floats = np.zeros((1, 1), before.dtype)
    shines = shone
    if material is not None:
        shone, shines = (_columns(gloss(surface, each, material, order, casting)) for each in (old, new))
    shown, known = _columns(picture[surface.mask]), _columns(surface.pixel_albedo)
    if shown.shape[1] == 1:  # a grey photograph shows luminance
        before, shone, known = (
            each if each.shape[1] == 1 else luminance(each)[:, None] for each in (before, shone, known)
        )
    pixels = np.maximum(_albedo(np.maximum(shown - shone, 0), before, known, floor) * after + shines, 0)
    result = np.array(np.repeat(picture[..., None], 3, axis=2) if pixels.shape[1] > shown.shape[1] else picture)
    result[surface.mask] = pixels if result.ndim == 3 else pixels[:, 0]
    return result


def _checked(photo: ArrayLike, surface: Surface) -> Floats:
    """Return a photograph in place on the Surface."""
    picture = _validate.floats(photo, "photo")
    if picture.shape not in (surface.shape, (*surface.shape, 3)):
        expected = f"shape {surface.shape} or {(*surface.shape, 3)}, as the surface"
        raise HarmonicFaceError(f"photo: expected {expected}, got {_validate.describe(picture)}")
    _validate.finite(picture[surface.mask], "photo")
    return picture


def _estimated(picture: Floats, surface: Surface, shadows: bool) -> Light:
    """Return lamps that explain the photograph."""
    if not picture[surface.mask].any():
        raise HarmonicFaceError("photo: expected some light in it to estimate its light from, got 0 in all of the mask")
    return shadowed_light(picture, surface) if shadows else nonnegative_light(picture, surface).light


def _columns(values: Floats) -> Floats:
    """Return (p,) or (p, 3) values as (p, 1) or (p, 3)."""
    return values.reshape(len(values), -1)


def _albedo(shown: Floats, irradiance: Floats, known: Floats, floor: float) -> Floats:
    """Return what the photograph says of the albedo where there was light, and elsewhere what is known of it."""
    doubt = floor**2 * float(np.mean(np.square(irradiance, dtype=np.float64)))
    told, trust = shown * irradiance + doubt * known, irradiance**2 + doubt
    result = np.array(np.broadcast_to(known, told.shape), told.dtype)
    np.divide(told, trust, out=result, where=trust > 0)
    return result
