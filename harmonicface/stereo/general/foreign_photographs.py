"""Foreign photographs: those that the others do not span, whatever light one combines from them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats

FACTORS = 9  # of the others, which combine to any photograph of the same thing but for sharp shadows
SPARE = 3  # others more than factors
FEWEST = 12  # photographs: fewer others do not span a hard sun
FOREIGN = 0.5  # of a photograph's root mean square outside: hard suns leave up to 0.45, another scene 0.35 to 0.75

Doubles = NDArray[np.float64]


def outside_the_others(photographs: Floats) -> Doubles:
    """Return how much of each photograph the leading nine factors of all others leave, 0 to 1, (n,).

    Only the (n, n) products of the photographs with each other are needed.

    Parameters
    ----------
    photographs
        (n, p) intensities, n of at least 5, none of them black.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> photographs = rng.uniform(size=(8, 2)) @ rng.uniform(size=(2, 500))
    >>> photographs[3] = rng.uniform(size=500)
    >>> int(outside_the_others(photographs).argmax())
    3
    """
    scaled = photographs / np.sqrt((photographs**2).mean(axis=1, keepdims=True))
    gram = (scaled @ scaled.T / scaled.shape[1]).astype(np.float64)
    count = len(gram)
    rank = max(1, min(FACTORS, count - 1 - SPARE))
    found = np.empty(count)
    for index in range(count):
        others = np.delete(np.arange(count), index)
        values, vectors = np.linalg.eigh(gram[np.ix_(others, others)])
        values, vectors = values[-rank:], vectors[:, -rank:]
        known = values > 1e-10 * values[-1]
        inside = (vectors[:, known].T @ gram[others, index]) ** 2 / values[known]
        found[index] = np.sqrt(max(1 - inside.sum(), 0.0))
    return found


def foreign_photographs(photographs: Floats) -> dict[int, str]:
    """Return which photographs show something else than the others, each with the reason.

    Only what is clear: a photograph under a light like no other's may leave as much as one of a similar thing.

    Parameters
    ----------
    photographs
        (n, p) intensities, none of them black. Of fewer than 12 nothing can be said.
    """
    if len(photographs) < FEWEST:
        return {}
    left = outside_the_others(photographs)
    return {
        int(index): f"{left[index]:.0%} of it is nothing that light on what the others show could be"
        for index in np.flatnonzero(left > FOREIGN)
    }
