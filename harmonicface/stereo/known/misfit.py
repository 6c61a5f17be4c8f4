"""Misfit: how far normals are off because the model does not hold, which halves of the lamps tell."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.in_blocks import Pixels

PIXELS = 300  # that are asked: the misfit is stated as one number for all
FEWEST = 8  # lamps: of fewer, halves do not determine normals

Doubles = NDArray[np.float64]
Solve = Callable[[Floats, Floats], Pixels]


def model_misfit(observations: Floats, lights: Floats, solve: Solve) -> float:
    r"""Return the standard error in degrees that the model adds to normals, which residuals alone do not tell.

    The lamps are halved twice, by the side on which they stand along the two axes in which they differ most. A surface
    that is what the model says, gloss, cast shadows and all, has the same normals under either half but for the
    stated errors e_1 and e_2; what they differ by beyond that is the model's fault:

    .. math:: m^2 = \max(\mathrm{median}\, \angle(n_1, n_2)^2 - \mathrm{median} (e_1^2 + e_2^2), 0)

    averaged over both ways. Under one side of the lamps the model errs to one side, so all lamps together err less than
    the halves differ; but what both halves have in common (light thrown back within the thing) does not show.

    Parameters
    ----------
    observations
        (n, p) intensities, of which 300 pixels are asked.
    lights
        (n, 3) directions times brightness.
    solve
        From observations and their lights to pixels.

    Returns
    -------
    float
        Degrees; 0 with fewer than 8 lamps, and where no pixel is determined under both halves.

    Examples
    --------
    >>> from harmonicface.stereo.known.known_lights import plain
    >>> angles = np.arange(12) * np.pi / 6
    >>> lamps = np.stack([0.6 * np.cos(angles), 0.6 * np.sin(angles), np.full(12, 0.8)], axis=1)
    >>> seen = lamps @ np.array([[0.0, 0.1, 0.995]]).T
    >>> solve = lambda observations, lights: plain(observations, lights, np.inf)
    >>> model_misfit(seen, lamps, solve) < 1e-3, round(model_misfit(seen**2, lamps, solve))
    (True, 1)
    """
    if len(lights) < FEWEST:
        return 0.0
    lit = np.flatnonzero(observations.max(axis=0) > 0)
    if not lit.size:
        return 0.0
    some = lit[np.linspace(0, lit.size - 1, min(PIXELS, lit.size)).astype(int)]
    seen = np.ascontiguousarray(observations[:, some])
    directions = lights / np.linalg.norm(lights, axis=1, keepdims=True)
    aside = directions - directions.mean(axis=0)
    squares = []
    for axis in np.linalg.svd(aside, full_matrices=False)[2][:2]:
        order = np.argsort(aside @ axis, kind="stable")
        halves = order[: len(order) // 2], order[len(order) // 2 :]
        try:
            first, second = (solve(seen[np.sort(half)], lights[np.sort(half)]) for half in halves)
        except HarmonicFaceError:  # lamps that span space together, but not by halves
            continue
        angle = _angles(first.scaled, second.scaled)
        stated = first.confidence.astype(np.float64) ** 2 + second.confidence.astype(np.float64) ** 2
        told = np.isfinite(angle) & np.isfinite(stated)
        if told.any():
            squares.append(max(float(np.median(angle[told] ** 2) - np.median(stated[told])), 0.0))
    return float(np.sqrt(np.mean(squares))) if squares else 0.0


def _angles(first: Floats, second: Floats) -> Doubles:
    """Return the angles between vectors in degrees, NaN where one of them vanishes."""
    one, other = first.astype(np.float64), second.astype(np.float64)
    lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    cosines = np.einsum("pk,pk->p", one, other) / np.where(lengths > 0, lengths, np.nan)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))
