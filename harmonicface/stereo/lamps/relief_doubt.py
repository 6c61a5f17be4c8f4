"""What an open tilt and relief of the surface means for each of its normals."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.lamps.lamps import doubt_of

NAMES = "mu_std", "nu_std", "lambda_std"


def stated_doubt(scaled: Floats, parameters: Mapping[str, float]) -> NDArray[np.float64]:
    """Return the standard error in degrees that an ambiguity's parameters give to each normal, 0 where it has none.

    Parameters
    ----------
    scaled
        (p, 3) albedo times normal.
    parameters
        `mu_std`, `nu_std` and `lambda_std`, see `Ambiguity`.

    Examples
    --------
    >>> stated_doubt(np.array([[0.6, 0.0, 0.8]]), {"mu_std": 0.0, "nu_std": 0.0, "lambda_std": 0.105171}).round(2)
    array([2.78])
    """
    if any(name not in parameters for name in NAMES):
        return np.zeros(len(scaled))
    mu, nu, stretch = (parameters[name] for name in NAMES)
    return doubt_of(np.asarray(scaled, np.float64), np.array([mu, nu, np.log1p(stretch)]))
