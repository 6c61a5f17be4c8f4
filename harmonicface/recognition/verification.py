"""One against one: whether a photograph can be a picture of a Surface, or two photographs of one person."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.blocks import REACH
from harmonicface.recognition.models import harmonic9
from harmonicface.recognition.patterns import Template, patterns, similarity
from harmonicface.recognition.render_compare import Photograph, Pictures
from harmonicface.recognition.subspace import Subspace
from harmonicface.surfaces.surface import Surface

INTENSITIES, PATTERNS = "intensities", "patterns"
DEFAULT_THRESHOLDS = {INTENSITIES: 0.15, PATTERNS: 0.75}
SHIFTS = tuple((right, down) for down in range(-REACH, REACH + 1) for right in range(-REACH, REACH + 1))


@dataclass(frozen=True)
class Verification:
    """The answer of `verify`: yes or no, and what it rests on.

    Parameters
    ----------
    same
        Whether the distance is at most the threshold.
    distance, threshold
        0 to 1, in the domain.
    light
        The light that explains the photograph best; None where a photograph was compared with a photograph, and for
        one without light.
    domain
        What was compared: "intensities" or "patterns".
    """

    same: bool
    distance: float
    threshold: float
    light: HarmonicLight | None
    domain: str = INTENSITIES


def verify(
    photo: ArrayLike,
    surface: Surface | ArrayLike,
    threshold: float | None = None,
    mask: ArrayLike | None = None,
    domain: str | None = None,
) -> Verification:
    """Say whether a photograph is a picture of a Surface under some light, or of whom another photograph shows.

    - "intensities": the distance is the sine of the angle between the photograph and the span of the nine harmonic
      images, on linear intensities over the Surface's mask; its square is the share of the photograph's energy that no
      light explains. For pictures that are aligned to a pixel, as renderings are.
    - "patterns": the distance is 1 minus the mean correlation of blocks of local patterns, of the photograph and of the
      Surface lit as it is, or of the other photograph, at the best of all shifts by up to 4 of 96 rows. For
      photographs; the light may be extreme.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities, in any unit; colour is taken as luminance.
    surface
        A Surface of that shape, whose picture it may be; or another photograph of that shape.
    threshold
        The largest distance at which the answer is yes, 0 to 1; by default 0.15 for intensities, 0.75 for patterns.

        Intensities at 0.15: of 3,312 pairs of synthetic strangers in the six kinds of light of `harmonicface bench`
        none is taken for the same person, and of 144 photographs of the right one 3 are refused, all under extreme
        light. On Yale B no stranger is accepted; 21 % of the right people are refused up to 25 degrees, 76 % up to 51.

        Patterns at 0.75, chosen on people 1 to 5 of Yale B by their photographs in subsets 2 to 5: of these, 0 % of
        strangers are accepted by Surfaces from subset 1 and 0.35 % of the right people refused; of people 6 to 11,
        0.24 % and 0.59 %. With one frontal photograph in place of the Surface, 0 % and 1.4 %; of people 6 to 11, 0 %
        and 7.1 %. (Intensities refuse 60 % where they accept 0.1 %.) Synthetic strangers of 64 pixels come as near as
        0.42: intensities suit them better.
    mask
        (h, w) booleans, false where the photograph is bad: burnt out, hidden.
    domain
        "intensities" or "patterns"; by default intensities for a Surface, patterns for a photograph.

    Returns
    -------
    Verification
        `.same`, `.distance`, `.threshold` and the `.light` that explains the photograph best.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN or infinity, an empty mask, a threshold outside 0 to 1, another domain, intensities for a
        photograph; for intensities a photograph that is all 0, for patterns fewer than 24 pixels a side.

    Examples
    --------
    >>> import harmonicface as hf
    >>> ada = hf.synthetic_person(0)
    >>> hf.verify(hf.render(ada, hf.lights.directional([1, 1, 2])), ada).same
    True
    """
    known = isinstance(surface, Surface)
    compared = (INTENSITIES if known else PATTERNS) if domain is None else domain
    if compared not in DEFAULT_THRESHOLDS or (compared == INTENSITIES and not known):
        expected = "intensities or patterns" if known else "patterns, as photographs are compared"
        raise HarmonicFaceError(f"domain: expected {expected}, got {domain!r}")
    limit = _validate.fraction(DEFAULT_THRESHOLDS[compared] if threshold is None else threshold, "threshold")
    picture = _grey(photo, "photo")
    if not isinstance(surface, Surface):
        reference = _grey(surface, "surface")
        if picture.shape != reference.shape:
            raise HarmonicFaceError(
                f"photo: expected the other photograph's shape {reference.shape}, got {picture.shape}"
            )
        seen = None if mask is None else _validate.mask(mask, "mask", (picture.shape[0], picture.shape[1]))
        distance = _apart(picture, reference, seen)
        return Verification(distance <= limit, distance, limit, None, compared)
    if picture.shape != surface.shape:
        raise HarmonicFaceError(f"photo: expected the Surface's shape {surface.shape}, got {picture.shape}")
    seen = surface.mask.copy() if mask is None else surface.mask & _validate.mask(mask, "mask", surface.shape)
    _validate.mask(seen, "mask and the Surface's mask together", surface.shape)
    pixels = picture[seen]
    images = harmonic9(surface)
    dark = compared == PATTERNS and not pixels.any()
    subspace = None if dark else Subspace.of(images[:, seen[surface.mask]])
    if compared == PATTERNS:
        distance = _unlike(picture, images, seen, surface.mask)
    else:
        assert subspace is not None
        distance = subspace.distance(pixels)
    light = None if subspace is None else HarmonicLight(subspace.coefficients(np.asarray(pixels)))
    return Verification(distance <= limit, distance, limit, light, compared)


def _grey(photo: ArrayLike, name: str) -> Floats:
    """Return a photograph in grey."""
    picture = _validate.image(photo, name)
    return picture if picture.ndim == 2 else luminance(picture)


def _apart(photo: Floats, other: Floats, seen: NDArray[np.bool_] | None) -> float:
    """Return how far the patterns of two photographs are apart."""
    found = similarity(patterns(photo, seen), [Template.of([patterns(other)])])
    return float(np.clip(1 - found.scores[0], 0, 1))


def _unlike(photo: Floats, images: Floats, seen: NDArray[np.bool_], mask: NDArray[np.bool_]) -> float:
    """Return how far the patterns of a photograph are from those of a Surface that is lit as the photograph is."""
    placed = np.zeros((len(images), *mask.shape), np.float32)
    placed[:, mask] = images
    asked = Photograph(photo, seen)
    fit = asked.explained(Pictures.of(placed, mask), SHIFTS)
    return float(np.clip(1 - asked.likeness([fit.picture])[0], 0, 1))
