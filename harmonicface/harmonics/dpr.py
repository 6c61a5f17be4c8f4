"""The light files of Deep Single-Image Portrait Relighting (DPR): nine numbers in axes of their own."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.rotation import rotate

# Rows: the axes of DPR (right, away from the camera, up) in ours (right, up, toward the camera).
DPR_AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def from_dpr(numbers: ArrayLike) -> Floats:
    """Return light coefficients L_lm from the nine numbers of a light file of Deep Single-Image Portrait Relighting.

    Such a file holds nine lines, one number each: `from_dpr(numpy.loadtxt(path))`. Scale, order and phase are ours
    (its shading multiplies by pi, 2 pi / 3, pi / 4 as irradiance does); the axes are those of pyshtools, x right,
    y away from the camera, z up. Its demonstration dims the light by 0.7 first; this function does not.
    (Zhou et al., Deep Single-Image Portrait Relighting, 2019, and its published code.)

    Parameters
    ----------
    numbers
        (9,), or (9, channels).

    Returns
    -------
    array
        The coefficients in our axes: x right, y up, z toward the camera.

    Raises
    ------
    HarmonicFaceError
        Not nine finite numbers.

    Examples
    --------
    >>> from_dpr([1, 0, 0.5, 0, 0, 0, 0, 0, 0]).round(6)[:4] + 0.0  # z of theirs is y of ours
    array([1. , 0.5, 0. , 0. ])
    """
    return rotate(_nine(numbers), DPR_AXES.T)


def to_dpr(coefficients: ArrayLike) -> Floats:
    """Return the nine numbers of a DPR light file from light coefficients of order 2, the inverse of `from_dpr`.

    Parameters
    ----------
    coefficients
        (9,) or (9, channels), in our axes.

    Returns
    -------
    array
        The nine numbers in DPR's axes; `numpy.savetxt` writes them as its files are.

    Raises
    ------
    HarmonicFaceError
        Not nine finite numbers.

    Examples
    --------
    >>> to_dpr([1, 0, 0, 0.5, 0, 0, 0, 0, 0]).round(6)[:4] + 0.0
    array([1. , 0. , 0. , 0.5])
    """
    return rotate(_nine(coefficients), DPR_AXES)


def _nine(value: ArrayLike) -> Floats:
    """Return nine finite coefficients, or nine a channel."""
    given = np.atleast_1d(_validate.finite(value, "coefficients"))
    if len(given) != 9:
        raise HarmonicFaceError(f"coefficients: expected nine of them, got {_validate.describe(given)}")
    return given
