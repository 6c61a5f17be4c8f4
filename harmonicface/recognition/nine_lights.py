"""Nine points of light: nine lamps whose pictures span nearly all others of a person, and how to choose them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.nonnegative_light import fibonacci_sphere
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface

# Lee, Ho & Kriegman, Acquiring linear subspaces for face recognition under variable lighting, 2005: degrees from the
# camera's axis, and about it from x to y
POLAR = (0.0, 68.0, 74.0, 80.0, 85.0, 85.0, 85.0, 85.0, 51.0)
AZIMUTH = (0.0, -90.0, 108.0, 52.0, -42.0, -137.0, 146.0, -4.0, 67.0)
CANDIDATES = 200  # half of them in front
TINY = 1e-12


def nine_lights() -> NDArray[np.float64]:
    """Return the nine directions of Lee, Ho & Kriegman (2005), (9, 3) unit vectors to the lamps.

    Examples
    --------
    >>> nine_lights()[:2].round(2) + 0.0
    array([[ 0.  ,  0.  ,  1.  ],
           [ 0.  , -0.93,  0.37]])
    """
    polar, azimuth = np.radians(POLAR), np.radians(AZIMUTH)
    return np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1)


def lamp_pictures(surface: Surface, lamps: ArrayLike) -> Floats:
    """Return the pictures of a Surface under single lamps (n, 3), attached shadows only, (n, p).

    Examples
    --------
    >>> import harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.ones((1, 2)))
    >>> lamp_pictures(wall, [[0.0, 0.6, 0.8]])
    array([[0.8, 0.8]])
    """
    towards = _validate.directions(lamps, "lamps").reshape(-1, 3)
    return np.asarray(np.maximum(towards @ surface.pixel_normals.T, 0) * surface.grey_albedo)


def nine_points(surface: Surface) -> Floats:
    """Return a Surface's pictures under the nine lamps, (9, p)."""
    return lamp_pictures(surface, nine_lights())


def choose_lights(
    surfaces: Surface | Sequence[Surface], count: int = 9, candidates: ArrayLike | int = CANDIDATES
) -> NDArray[np.float64]:
    r"""Choose lamps one by one so that their pictures span most of what light can do to a person.

    .. math:: x_i = \arg\max_x \frac{d(x, R_{i-1})}{d(x, H)}

    with R the span of the pictures chosen so far and H that of the nine harmonic images: the next picture is far from
    what is there already, and near to what light can do at all (Lee, Ho & Kriegman 2005). Of several people the
    quotients are added, which gives one configuration for all.

    Parameters
    ----------
    surfaces
        One Surface, or several.
    count
        How many lamps.
    candidates
        (n, 3) directions to choose from, or how many to spread over the sphere; of these, the half in front.

    Returns
    -------
    array
        (count, 3) unit vectors in the order in which they were chosen.

    Raises
    ------
    HarmonicFaceError
        No Surface, fewer candidates than wanted lamps, candidates none of which lights anything new.

    Examples
    --------
    >>> import harmonicface as hf
    >>> choose_lights(hf.synthetic_person(0, size=32), count=3).shape
    (3, 3)
    """
    people = [surfaces] if isinstance(surfaces, Surface) else list(surfaces)
    if not people:
        raise HarmonicFaceError("surfaces: expected at least one, got none")
    wanted = _validate.at_least(count, 1, "count")
    towards = _candidates(candidates)
    if len(towards) < wanted:
        raise HarmonicFaceError(f"candidates: expected at least {wanted}, got {len(towards)}")
    residuals = [_unit_pictures(surface, towards) for surface in people]
    from_harmonics = [_distances_to_harmonics(surface, own) for surface, own in zip(people, residuals, strict=True)]
    chosen: list[int] = []
    for _ in range(wanted):
        gains = np.zeros(len(towards))
        for own, away in zip(residuals, from_harmonics, strict=True):
            gains += np.linalg.norm(own, axis=1) / away
        gains[chosen] = -1
        best = int(gains.argmax())
        if not gains[best] > TINY:
            raise HarmonicFaceError(f"candidates: expected {wanted} with different pictures, got {len(chosen)}")
        chosen.append(best)
        for own in residuals:
            length = float(np.linalg.norm(own[best]))
            if length > TINY:
                own -= np.outer(own @ own[best], own[best]) / length**2
    return towards[chosen]


def _candidates(candidates: ArrayLike | int) -> NDArray[np.float64]:
    """Return directions to choose from."""
    if isinstance(candidates, (int, np.integer)):
        sphere = fibonacci_sphere(int(candidates))
        return np.asarray(sphere[sphere[:, 2] > 0])
    return _validate.directions(candidates, "candidates").astype(np.float64).reshape(-1, 3)


def _unit_pictures(surface: Surface, towards: Floats) -> NDArray[np.float64]:
    """Return pictures scaled to length 1; dark ones stay 0."""
    pictures = lamp_pictures(surface, towards).astype(np.float64)
    lengths = np.linalg.norm(pictures, axis=1, keepdims=True)
    return np.asarray(pictures / np.where(lengths == 0, 1, lengths))


def _distances_to_harmonics(surface: Surface, pictures: Floats) -> NDArray[np.float64]:
    """Return how far unit pictures are from the span of the nine harmonic images, at least a little."""
    rows = np.linalg.svd(harmonic_images(surface).astype(np.float64), full_matrices=False)[2]
    return np.asarray(np.maximum(np.linalg.norm(pictures - (pictures @ rows.T) @ rows, axis=1), 1e-3))
