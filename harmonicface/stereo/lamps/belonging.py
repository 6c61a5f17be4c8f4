"""Belonging: lamps are found again without the photographs that do not belong to the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.known.bad_images import find_bad_images
from harmonicface.stereo.lamps.lamps import Lamps


def lamps_of_those_that_belong(
    find: Callable[[Floats], Lamps], observations: Floats, saturation: float = np.inf
) -> tuple[Lamps, dict[int, str]]:
    """Find unknown lamps, and once more without the photographs that the others do not explain under these.

    Parameters
    ----------
    find
        Finds the lamps of (n, p) photographs.
    observations
        (n, p) linear grey intensities.
    saturation
        Observations that reach it are not used.

    Returns
    -------
    lamps
        (n, 3) lights, NaN for photographs that were left out.
    left_out
        Their indices, each with its reason.
    """
    found = find(observations)
    bad = find_bad_images(observations, found.lights, saturation)
    if not bad.left_out:
        return found, {}
    kept: NDArray[np.bool_] = bad.kept(len(observations))
    again = find(observations[kept])
    lights = np.full((len(observations), 3), np.nan)
    lights[kept] = again.lights
    return replace(again, lights=lights), bad.left_out
