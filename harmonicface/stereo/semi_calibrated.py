"""Semi-calibrated stereo: the lamps' directions are known, their brightness is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.least_squares import scaled_normals

FEWEST = 4  # photographs: of three, any brightness explains everything
PIXELS = 2000  # that are asked: the brightness is the same for all of them
ROUNDS = 60
SETTLED = 1e-5  # relative change of a brightness
SHADOWED = 0.5  # of what is predicted
OUTLYING = 1.5  # deviations at which an observation has lost half of its weight
UNDETERMINED = 1e-5  # of the largest, where the smallest singular value of a round leaves the brightness open

Mask = NDArray[np.bool_]
Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Brightness:
    """How bright lamps in known directions are, against one another.

    Parameters
    ----------
    values
        (n,) their median is 1.
    error
        (n,) relative standard errors, if what the pixels leave is independent from pixel to pixel.
    """

    values: Doubles
    error: Doubles


def semi_calibrated(
    observations: Floats,
    directions: Floats,
    usable: Mask | None = None,
    seed: int | np.random.Generator = 0,
) -> Brightness:
    r"""Find the brightness of lamps from photographs of a mostly matte thing.

    A pixel that is lit shows :math:`I_{ip} = e_i \, l_i \cdot b_p`, so with a = 1 / e, up to one common factor,

    .. math:: \min_{e, b} \sum_{ip} w_{ip} (I_{ip} - e_i \, l_i \cdot b_p)^2

    (Cho, Matsushita, Tai & Kweon, Semi-Calibrated Photometric Stereo, 2020). The linear system in (a, b) of the first
    round, in which the b drop out, is solved by its smallest eigenvector; from there on brightness and pixels alternate
    with weights: 0 for what shows less than half of the prediction, and Cauchy's function of the pixel's residual over
    its median for highlights.

    Parameters
    ----------
    observations
        (n, p) linear grey intensities, n of at least 4.
    directions
        (n, 3) unit directions to the lamps.
    usable
        (n, p) booleans, false for saturated observations.
    seed
        Of the choice of pixels, of which 2000 are asked.

    Returns
    -------
    Brightness
        `lights = directions * values[:, None]` are what the solvers for known lights take.

    Raises
    ------
    HarmonicFaceError
        Fewer than four photographs, directions of another count, a photograph that is black where it is looked at,
        pixels whose normals are all alike: then any brightness is as good as any other.

    Examples
    --------
    >>> generator = np.random.default_rng(0)
    >>> lamps = generator.normal(size=(8, 3)) + [0, 0, 4]
    >>> lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    >>> pixels = generator.normal(size=(100, 3)) + [0, 0, 4]
    >>> brightness = np.array([1, 2, 0.5, 1, 1, 3, 0.3, 1.0])
    >>> semi_calibrated(brightness[:, None] * (lamps @ pixels.T), lamps).values.round(3)
    array([1. , 2. , 0.5, 1. , 1. , 3. , 0.3, 1. ])
    """
    generator = _validate.generator(seed, "seed")
    count = len(observations)
    lamps = _validate.directions(directions, "directions").astype(np.float64)
    if lamps.shape != (count, 3):
        raise HarmonicFaceError(f"directions: expected one a photograph, shape ({count}, 3), got {lamps.shape}")
    if count < FEWEST:
        raise HarmonicFaceError(
            f"images: expected at least {FEWEST} where the brightness of the lamps is unknown, got {count}"
        )
    total = observations.shape[1]
    some = np.sort(generator.choice(total, min(PIXELS, total), replace=False))
    seen = observations[:, some].astype(np.float64)
    trusted = np.ones(seen.shape, bool) if usable is None else usable[:, some]
    level = np.where(trusted, seen, 0).sum(axis=1) / np.maximum(trusted.sum(axis=1), 1)
    if not (level > 0).all():
        raise HarmonicFaceError(f"images: expected light in each, got a black image {int(level.argmin())}")
    seen = seen / level[:, None]
    seen = seen[:, seen.max(axis=0) > 0]
    values = _start(seen, lamps)
    return _refined(seen, lamps, trusted[:, observations[:, some].max(axis=0) > 0], values, level)


def _start(seen: Doubles, lamps: Doubles) -> Doubles:
    r"""Return the brightness that makes all photographs at once linear in the lamps.

    a_i I_ip = l_i . b_p for all i means that diag(I_p) a lies in the span of the lamps: a is the eigenvector of
    the smallest eigenvalue of `sum_p diag(I_p) (1 - L L^+) diag(I_p)` = `(1 - L L^+) * (I I')`, entry by entry.
    """
    basis = np.linalg.svd(lamps, full_matrices=False)[0]
    beyond = np.eye(len(lamps)) - basis @ basis.T
    values, vectors = np.linalg.eigh(beyond * (seen @ seen.T))
    if values[1] <= UNDETERMINED**2 * values[-1]:
        raise HarmonicFaceError(
            "intensities: expected normals of several directions to tell the brightness of the lamps, got pixels that"
            " any brightness explains: give the intensities"
        )
    inverse = vectors[:, 0] * np.sign(vectors[:, 0].sum())
    sound = inverse > 0.05 * np.median(inverse)  # shadows may turn a sign; the rounds begin at the level then
    return np.where(sound, 1 / np.where(sound, inverse, 1.0), 1 / np.median(np.abs(inverse)))


def _refined(seen: Doubles, lamps: Doubles, trusted: Mask, values: Doubles, level: Doubles) -> Brightness:
    """Alternate between pixels and brightness."""
    weights = trusted.astype(np.float64)
    predicted = rest = seen
    for _ in range(ROUNDS):
        scaled = scaled_normals(seen, values[:, None] * lamps, weights)[0]
        predicted = lamps @ scaled.T
        rest = seen - values[:, None] * predicted
        lit = trusted & (predicted > 0) & (seen > SHADOWED * values[:, None] * predicted)
        size = np.abs(rest)
        median = np.median(np.where(lit, size, np.nan), axis=0) if lit.all() else _median(size, lit)
        weights = lit / (1 + (size / (OUTLYING * (1.48 * median + 1e-9))) ** 2)
        square = np.einsum("np,np,np->n", weights, predicted, predicted)
        cross = np.einsum("np,np,np->n", weights, predicted, seen)
        following = np.where(square > 0, cross / np.where(square > 0, square, 1.0), values)
        following /= np.median(following)
        change = np.abs(following / values * np.median(values) - 1).max()
        values = following
        if change < SETTLED:
            break
    error = _error(values, lamps, predicted, rest, weights)
    whole = values * level
    return Brightness(whole / np.median(whole), error)


def _error(values: Doubles, lamps: Doubles, predicted: Doubles, rest: Doubles, weights: Doubles) -> Doubles:
    """Return relative standard errors of the brightness, the pixels free to follow it, their common factor fixed."""
    bright = values[:, None] * lamps
    normal = np.einsum("np,ni,nj->pij", weights, bright, bright, optimize=True)
    normal += 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3) + 1e-30 * np.eye(3)
    mixed = np.einsum("np,ni->pin", weights * predicted, bright)
    information = np.diag(np.einsum("np,np,np->n", weights, predicted, predicted))
    information -= np.einsum("pin,pim->nm", mixed, np.linalg.solve(normal, mixed), optimize=True)
    freedom = max(weights.sum() - 3 * weights.shape[1] - len(values), 1.0)
    noise = np.einsum("np,np,np->", weights, rest, rest) / freedom
    relative = information * np.outer(values, values)
    relative += np.trace(relative) / len(values)  # the same factor for all is no error
    return np.asarray(np.sqrt(noise * np.maximum(np.diag(np.linalg.pinv(relative, hermitian=True)), 0)))


def _median(size: Doubles, chosen: Mask) -> Doubles:
    """Return the median of the chosen entries of each column, 0 where there are none."""
    order = np.sort(np.where(chosen, size, np.inf), axis=0)
    middle = order[np.maximum(chosen.sum(axis=0) - 1, 0) // 2, np.arange(size.shape[1])]
    return np.where(np.isfinite(middle), middle, 0.0)
