"""How much people differ: the spread of normals and of albedo between aligned faces, pixel by pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NormalSpread:
    """The angles between the people's normals and their mean normal.

    Parameters
    ----------
    rms, mean
        Degrees, over all people and all pixels that everybody has.
    map
        (h, w) root mean square over the people, degrees; NaN outside the pixels that everybody has.
    """

    rms: float
    mean: float
    map: Array


@dataclass(frozen=True, eq=False)
class AlbedoSpread:
    """How the people's albedos differ; each person's albedo is divided by its mean, except for `tone`.

    Parameters
    ----------
    between
        Root mean square over the pixels of the standard deviation between people, over the mean.
    contrast
        Standard deviation over the pixels of one person, over the mean; the average of all people.
    tone
        Standard deviation between the people's mean albedos, over their mean.
    map
        (h, w) standard deviation between people over their mean at the pixel; NaN outside.
    """

    between: float
    contrast: float
    tone: float
    map: Array


def normal_spread(people: Sequence[Surface], within: NDArray[np.bool_] | None = None) -> NormalSpread:
    """Return the spread of normals between people who are aligned.

    Parameters
    ----------
    people
        At least two Surfaces of one shape.
    within
        (h, w) booleans, the pixels to look at; by default all that everybody has.

    Raises
    ------
    HarmonicFaceError
        Fewer than two people, different shapes, no pixel in common.

    Examples
    --------
    >>> from harmonicface.people.synthetic import synthetic_people
    >>> spread = normal_spread(list(synthetic_people(4, size=32)))
    >>> 3 < spread.mean < spread.rms < 20
    True
    """
    common = common_mask(people, within)
    normals = np.stack([person.normals[common] for person in people]).astype(np.float64)
    average = normals.mean(axis=0)
    average /= np.linalg.norm(average, axis=-1, keepdims=True)
    # the chord's length keeps small angles that the arc cosine would lose in rounding
    chord = np.linalg.norm(normals - average, axis=-1)
    angles = np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1)))
    return NormalSpread(
        float(np.sqrt((angles**2).mean())), float(angles.mean()), _map(np.sqrt((angles**2).mean(axis=0)), common)
    )


def albedo_spread(people: Sequence[Surface], within: NDArray[np.bool_] | None = None) -> AlbedoSpread:
    """Return the spread of grey albedo between people who are aligned.

    Parameters
    ----------
    people
        At least two Surfaces of one shape.
    within
        (h, w) booleans, the pixels to look at; by default all that everybody has.

    Raises
    ------
    HarmonicFaceError
        Fewer than two people, different shapes, no pixel in common.

    Examples
    --------
    >>> from harmonicface.people.synthetic import synthetic_people
    >>> spread = albedo_spread(list(synthetic_people(4, size=32)))
    >>> 0.05 < spread.between < 0.4
    True
    """
    common = common_mask(people, within)
    albedo = np.stack([person.grey_albedo[common[person.mask]] for person in people]).astype(np.float64)
    tones = albedo.mean(axis=1)
    relative = albedo / tones[:, None]
    deviation = relative.std(axis=0, ddof=1)
    return AlbedoSpread(
        float(np.sqrt((deviation**2).mean())),
        float(relative.std(axis=1).mean()),
        float(tones.std(ddof=1) / tones.mean()),
        _map(deviation / relative.mean(axis=0), common),
    )


def common_mask(people: Sequence[Surface], within: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
    """Return the pixels that everybody has, (h, w).

    Raises
    ------
    HarmonicFaceError
        Fewer than two people, different shapes, no pixel in common.
    """
    if len(people) < 2:
        raise HarmonicFaceError(f"people: expected at least two Surfaces, got {len(people)}")
    shapes = {person.shape for person in people} | ({within.shape} if within is not None else set())
    if len(shapes) != 1:
        raise HarmonicFaceError(f"people: expected Surfaces of one shape, got {sorted(shapes)}")
    common = np.asarray(np.stack([person.mask for person in people]).all(axis=0))
    if within is not None:
        common = common & within
    if not common.any():
        raise HarmonicFaceError("people: expected pixels that all of them have, got none")
    return common


def _map(values: Array, common: NDArray[np.bool_]) -> Array:
    """Return values of the common pixels as a picture."""
    picture = np.full(common.shape, np.nan)
    picture[common] = values
    return picture
