"""Agreement: how far a picture is from an oracle's pictures, with and without the oracle's own noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError


@dataclass(frozen=True)
class Agreement:
    """How far a picture is from an oracle's, relative to the RMS of the oracle's.

    Parameters
    ----------
    raw
        The RMS difference from the mean of the oracle's pictures, its noise included.
    noise
        The RMS noise of that mean, from how its pictures differ.
    error
        The RMS difference without the oracle's noise: the root of raw^2 - noise^2 (0 if that is negative).
    """

    raw: float
    noise: float
    error: float


def agreement(ours: NDArray[Any], pictures: Sequence[NDArray[Any]], mask: NDArray[np.bool_]) -> Agreement:
    """Return how far a picture is from the mean of at least two pictures with independent noise, over a mask.

    The mean square difference from a noisy mean is the true one plus the noise's variance, and that is known from
    how the pictures differ: what remains is free of bias however noisy they are.

    Parameters
    ----------
    ours
        (h, w) or (h, w, 3).
    pictures
        (h, w, 3) each, of different seeds.
    mask
        (h, w) booleans.

    Raises
    ------
    HarmonicFaceError
        Fewer than two pictures, or pictures in which there is nothing but noise.

    Examples
    --------
    >>> agreement(np.full((2, 2, 3), 1.01), [np.ones((2, 2, 3))] * 2, np.ones((2, 2), bool)).error
    0.01
    """
    if len(pictures) < 2:
        raise HarmonicFaceError(f"pictures: expected at least two, which tell their noise, got {len(pictures)}")
    theirs = np.stack([picture[mask].astype(np.float64) for picture in pictures])
    mean = theirs.mean(axis=0)
    judged = ours[mask].reshape(len(mean), -1)
    variance = float(theirs.var(axis=0, ddof=1).mean()) / len(theirs)
    square = float(((judged - mean) ** 2).mean())
    scale = float((mean**2).mean()) - variance  # noise adds to the power of what it falls on, too
    if not scale > 0:
        raise HarmonicFaceError("pictures: expected more than noise in the mask, got none")
    parts = (square / scale, variance / scale, max(0.0, square - variance) / scale)
    return Agreement(*(round(float(np.sqrt(part)), 12) for part in parts))
