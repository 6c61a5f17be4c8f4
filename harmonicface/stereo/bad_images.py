"""Bad images: photographs that the others, through what they say of the surface, do not predict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.stereo.robust import unexplained

FEWEST = 12  # photographs: of fewer, a fit to most of them is no witness against the rest
PIXELS = 400  # that are asked: more change the means by less than the photographs differ
CEILING = 0.5  # of a pixel's brightness: what one pixel may contribute
UNNOTICED = 0.04  # of a pixel's brightness: photographs that leave less differ by little that matters
FIRST = 0.6  # of the photographs are believed at first
FARTHER = 1.35  # times what is left of its neighbours, and
DEVIATIONS = 5.0  # of the photographs that belong: a photograph that leaves more does not
UNSURE = 15.0  # photographs: with so many both bounds are twice as wide
MOST = 0.4  # of the photographs that may be left out: beyond, it cannot be told who belongs
ROUNDS = 6

Mask = NDArray[np.bool_]
Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BadImages:
    """Which photographs do not belong to the others.

    Parameters
    ----------
    left_out
        By index, each with its reason.
    unexplained
        (n,) mean absolute difference between photograph and prediction, over the pixels' brightness; empty if there
        are too few photographs.
    """

    left_out: dict[int, str]
    unexplained: Doubles

    def kept(self, count: int) -> Mask:
        """Return (n,) booleans of n photographs, true for those that belong."""
        return ~np.isin(np.arange(count), list(self.left_out))


def find_bad_images(
    observations: Floats,
    lights: Floats,
    saturation: float = np.inf,
    usable: Mask | None = None,
    seed: int | np.random.Generator = 0,
) -> BadImages:
    r"""Find photographs that do not belong: of another scene, displaced, blurred, spoilt in part, wrongly lit.

    Six tenths of the photographs, those that mixtures fitted to all explain best, tell what each of a few hundred
    pixels looks like under any lamp (`robust_normals`), and so what every photograph should show. A photograph's
    score is the logarithm of the mean absolute difference, in which no pixel counts for more than half of its
    brightness, plus 4 % of it, so that small differences do not tell. Lamps at the side leave more (shadows), so a
    parabola in the lamp's height that fits most scores is subtracted. Photographs whose score lies five deviations
    of the believed ones and a factor of 1.35 above them, both bounds wider for few photographs, are doubted, the
    others believed, and so on until nothing changes.

    Nothing is left out of fewer than twelve photographs, and nothing if more than four tenths are doubted: then it
    cannot be told which are the wrong ones.

    Parameters
    ----------
    observations
        (n, p) linear grey intensities.
    lights
        (n, 3) directions to the lamps times their brightness.
    saturation
        Observations that reach it are not used.
    usable
        (n, p) booleans, false for other observations not to use.
    seed
        Of the choice of pixels.

    Raises
    ------
    HarmonicFaceError
        No seed.

    Examples
    --------
    >>> generator = np.random.default_rng(0)
    >>> lamps = generator.normal(size=(20, 3)) + [0, 0, 3]
    >>> lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    >>> normals = generator.normal(size=(300, 3)) + [0, 0, 3]
    >>> images = np.maximum(lamps @ normals.T, 0) + 0.05 * generator.normal(size=(20, 300))
    >>> images[7] = images[7, ::-1]
    >>> find_bad_images(images, lamps).left_out
    {7: 'the other photographs explain it ... times worse than others under such lamps'}
    """
    generator = _validate.generator(seed, "seed")
    count = len(lights)
    if count < FEWEST:
        return BadImages({}, np.empty(0))
    allowed = observations < saturation if usable is None else usable & (observations < saturation)
    enough = np.flatnonzero((allowed.sum(axis=0) >= FEWEST) & (observations.max(axis=0) > 0))
    if not enough.size:
        return BadImages({}, np.empty(0))
    some = np.sort(generator.choice(enough, min(PIXELS, enough.size), replace=False))
    seen, trusted = observations[:, some], allowed[:, some]
    height = lights[:, 2] / np.linalg.norm(lights, axis=1)
    wider = 1 + UNSURE / count
    everybody = np.ones(count, bool)
    left = _left(seen, lights, everybody, trusted)
    excess = _excess(left, height, everybody)
    kept = excess <= np.quantile(excess, FIRST)
    for turn in range(ROUNDS):
        left = _left(seen, lights, kept, trusted)
        excess = _excess(left, height, kept)
        middle = np.median(excess[kept])
        spread = 1.48 * np.median(np.abs(excess[kept] - middle)) * (1.5 if turn == 0 else 1.0)  # the tail was cut off
        believed = excess <= middle + wider * max(np.log(FARTHER), DEVIATIONS * spread)
        if (believed == kept).all():
            break
        kept = believed
    if (~kept).mean() > MOST:
        return BadImages({}, left)
    return BadImages({int(i): _reason(np.exp(excess[i] - middle)) for i in np.flatnonzero(~kept)}, left)


def _left(seen: Floats, lights: Floats, kept: Mask, usable: Mask) -> Doubles:
    """Return what is left of each photograph on the average."""
    rest = np.minimum(np.abs(unexplained(seen, lights, kept, usable)), CEILING)
    return np.asarray((rest * usable).sum(axis=1, dtype=np.float64) / np.maximum(usable.sum(axis=1), 1))


def _excess(left: Doubles, height: Doubles, kept: Mask) -> Doubles:
    """Return scores less a parabola in the lamps' height that fits most of the kept ones (least absolute values)."""
    scores, basis = np.log(left + UNNOTICED), np.stack([np.ones_like(height), height, height**2], axis=1)
    weights = kept.astype(np.float64)
    rest = scores
    for _ in range(20):
        root = np.sqrt(weights)
        rest = scores - basis @ np.linalg.lstsq(basis * root[:, None], scores * root, rcond=None)[0]
        weights = kept / np.maximum(np.abs(rest), 0.02)
    return rest


def _reason(factor: float) -> str:
    return f"the other photographs explain it {factor:.2g} times worse than others under such lamps"
