"""Fresnel's factor: how much of the light a smooth boundary throws back at an angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError


def fresnel(cosines: ArrayLike, refractive_index: float) -> Floats:
    r"""Return the share of unpolarized light that a dielectric reflects.

    .. math:: F = \frac{1}{2} \frac{(g - c)^2}{(g + c)^2}
                  \left( 1 + \frac{(c (g + c) - 1)^2}{(c (g - c) + 1)^2} \right), \quad
              c = \cos\theta, \quad g^2 = \eta^2 + c^2 - 1

    (Cook & Torrance, A Reflectance Model for Computer Graphics, 1982, section 3: the exact equations for a real
    refractive index, seen from the thinner side.) At normal incidence ((eta - 1) / (eta + 1))^2, at grazing 1.

    Parameters
    ----------
    cosines
        (...) cosines of the angle with the normal, 0 to 1; what rounding puts outside is taken as the end.
    refractive_index
        eta, above 1 to 100: about 1.4 for skin, 1.5 for glass.

    Returns
    -------
    array
        (...) numbers from 0 to 1.

    Raises
    ------
    HarmonicFaceError
        An index that is not above 1 to 100, cosines that are not finite.

    Examples
    --------
    >>> fresnel([1.0, 0.5, 0.0], 1.4).round(4)
    array([0.0278, 0.072 , 1.    ])
    """
    index = index_of(refractive_index)
    c = np.clip(_validate.finite(cosines, "cosines"), 0, 1)
    g = np.sqrt(index**2 + c**2 - 1)
    across = ((g - c) / (g + c)) ** 2
    along = ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2
    return np.asarray(across * (1 + along) / 2)


def index_of(value: float) -> float:
    """Return a refractive index above that of air."""
    index = _validate.positive(value, "refractive_index")
    if not 1 < index <= 100:
        raise HarmonicFaceError(f"refractive_index: expected a number above 1 to 100, got {index:g}")
    return index
