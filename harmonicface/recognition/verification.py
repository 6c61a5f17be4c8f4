"""One against one: whether a photograph can be a picture of a Surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.models import harmonic9
from harmonicface.recognition.subspace import Subspace
from harmonicface.surfaces.surface import Surface

DEFAULT_THRESHOLD = 0.15


@dataclass(frozen=True)
class Verification:
    """The answer of `verify`: yes or no, and what it rests on."""

    same: bool
    distance: float
    threshold: float
    light: HarmonicLight


def verify(
    photo: ArrayLike, surface: Surface, threshold: float = DEFAULT_THRESHOLD, mask: ArrayLike | None = None
) -> Verification:
    """Say whether a photograph is a picture of a Surface under some light.

    The distance is the sine of the angle between the photograph and the span of the nine harmonic images, on linear
    intensities over the Surface's mask; its square is the share of the photograph's energy that no light explains.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities of the Surface's shape, in any unit; colour is taken as luminance.
    surface
        Whose picture it may be.
    threshold
        The largest distance at which the answer is yes, 0 to 1. With 0.15, of 3,312 pairs of synthetic strangers in
        the six kinds of light of `harmonicface bench` none is taken for the same person, and of 144 photographs of
        the right one 3 are refused, all under extreme light. On Yale B no stranger is accepted; 21 % of the right
        people are refused up to 25 degrees, 76 % up to 51: unaligned real photographs need 0.2 to 0.25.
    mask
        (h, w) booleans, false where the photograph is bad: burnt out, hidden.

    Returns
    -------
    Verification
        `.same`, `.distance`, `.threshold` and the `.light` that explains the photograph best.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN or infinity, a photograph that is all 0, an empty mask, a threshold outside 0 to 1.

    Examples
    --------
    >>> import harmonicface as hf
    >>> ada = hf.synthetic_person(0)
    >>> hf.verify(hf.render(ada, hf.lights.directional([1, 1, 2])), ada).same
    True
    """
    limit = _validate.fraction(threshold, "threshold")
    picture = _validate.image(photo, "photo")
    if picture.shape[:2] != surface.shape:
        raise HarmonicFaceError(f"photo: expected the Surface's shape {surface.shape}, got {picture.shape[:2]}")
    seen = surface.mask.copy() if mask is None else surface.mask & _validate.mask(mask, "mask", surface.shape)
    _validate.mask(seen, "mask and the Surface's mask together", surface.shape)
    pixels = (picture if picture.ndim == 2 else luminance(picture))[seen]
    subspace = Subspace.of(harmonic9(surface)[:, seen[surface.mask]])
    distance = subspace.distance(pixels)
    light = HarmonicLight(subspace.coefficients(np.asarray(pixels)))
    return Verification(distance <= limit, distance, limit, light)
