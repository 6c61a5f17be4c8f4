"""Hayakawa's factorization: photographs under unknown lamps -> lights and scaled normals, up to a 3 x 3 matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.known.least_squares import scaled_normals

Doubles = NDArray[np.float64]

MIDDLE, BREADTH = 0.55, 0.25  # of a pixel's ranked photographs: below are shadows, above are highlights
FEWEST_RANKS = 6  # photographs that are left to every pixel, where there are so many
ROUNDS = 30
SETTLED = 1e-5  # of the lights, by which they still change
SAMPLE = 12_000  # pixels that tell the lights: more change nothing that their noise would show
LEAST_THIRD = 0.05  # the same, of what the factors explain: lamps within 12 degrees, or nearly in a plane, are below
UNRESOLVED = 1e-12  # of the largest eigenvalue of a lamp's equations: the smaller ones are rounding
LEAST_SHARE = 1e-4  # the third singular value over the first: below, the photographs tell of fewer directions

_ROWS, _COLUMNS = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 1, 2, 2])
_SQUARE = np.array([0, 1, 2, 1, 3, 4, 2, 4, 5])  # of the upper triangle, where each entry of the matrix is


@dataclass(frozen=True, eq=False)
class LinearFactors:
    """Photographs as `lights @ scaled.T` where neither shadow nor highlight is; any matrix may stand between.

    Parameters
    ----------
    lights
        (n, 3) directions times brightness, in an unknown frame: its columns are orthogonal, of length sqrt(n).
    scaled
        (p, 3) albedo times normal in the frame that belongs to it.
    weights
        (n, p) float32, 1 where an observation was used and 0 elsewhere.
    """

    lights: Doubles
    scaled: Doubles
    weights: NDArray[np.float32]


def linear_factors(observations: Floats, saturation: float | Floats = np.inf) -> LinearFactors:
    r"""Factorize photographs of a matte surface under distant lamps robustly into three unknown factors.

    `I_ip = l_i . b_p` where pixel p is lit (Hayakawa, Photometric stereo under a light source with arbitrary motion,
    1994). Each pixel's photographs are ranked by intensity, those of the middle ranks are used: the darkest may lie in
    shadow, the brightest in a highlight. From the leading singular vectors on,

    .. math:: \sum_{ip} w_{ip} (I_{ip} - l_i \cdot b_p)^2

    is minimized over all b and all l in turn.

    Parameters
    ----------
    observations
        (n, p) linear intensities, of lamps about equally bright (see `equalized`).
    saturation
        From there on an observation is not used; one for all, or (n, 1) for each photograph.

    Returns
    -------
    LinearFactors

    Raises
    ------
    HarmonicFaceError
        Fewer than three photographs or pixels, or photographs that are mixtures of one or two.

    Examples
    --------
    >>> random = np.random.default_rng(0)
    >>> lights, normals = random.uniform(0.2, 1, (8, 3)), random.uniform(0.2, 1, (50, 3))
    >>> found = linear_factors(lights @ normals.T)
    >>> bool(np.allclose(found.lights @ found.scaled.T, lights @ normals.T))
    True
    """
    count, pixels = observations.shape
    if count < 3 or pixels < 3:
        raise HarmonicFaceError(
            f"images: expected at least 3, of at least 3 pixels, for 3 unknown factors, got {count} of {pixels}"
        )
    weights = middle_ranks(observations)
    weights[observations >= saturation] = 0
    chosen = slice(None) if pixels <= SAMPLE else np.linspace(0, pixels - 1, SAMPLE).astype(int)
    seen, trust = observations[:, chosen].astype(np.float64), weights[:, chosen].astype(np.float64)
    lights = _start(seen)
    for _ in range(ROUNDS):
        before = lights
        scaled, _ = scaled_normals(seen, lights, trust)
        lights = _orthogonal(lights_of(seen, scaled, trust))
        # the frame may turn between rounds: what counts is the space that its columns span
        if np.linalg.norm(lights - before @ (before.T @ lights) / count) < SETTLED * np.sqrt(count):
            break
    scaled, _ = scaled_normals(observations, lights, weights)
    return LinearFactors(lights, scaled, weights)


def check_span(lights: Doubles, scaled: Doubles) -> None:
    """Refuse factors the third of which is so weak that shadows and noise outweigh it in any frame.

    Raises
    ------
    HarmonicFaceError
        Lamps near one another or near one plane, or a surface that is nearly flat.
    """
    triangle = np.linalg.qr(lights)[1]
    values = np.sqrt(np.maximum(np.linalg.eigvalsh(triangle @ (scaled.T @ scaled) @ triangle.T), 0.0))
    if values[0] < LEAST_THIRD * values[-1]:
        raise HarmonicFaceError(
            "images: expected unknown lamps from directions that span space on a surface that is not flat, got lamps"
            " that are near one another or near one plane, or nearly a plane: the third singular value is"
            f" {values[0] / values[-1]:.1%} of the first (at least {LEAST_THIRD:.0%})"
        )


def middle_ranks(observations: Floats) -> NDArray[np.float32]:
    """Return 1 for each pixel's photographs of middle rank and 0 for the darkest and brightest, (n, p).

    Examples
    --------
    >>> middle_ranks(np.arange(20.0)[:, None]).ravel().astype(int)
    array([0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0])
    """
    count = len(observations)
    order = np.argsort(observations, axis=0, kind="stable")
    rank = (np.arange(count) + 0.5) / count
    kept = np.abs(rank - MIDDLE) <= max(BREADTH, FEWEST_RANKS / (2 * count))
    weights = np.empty(observations.shape, np.float32)
    np.put_along_axis(weights, order, kept.astype(np.float32)[:, None], axis=0)
    return weights


def equalized(observations: Floats) -> tuple[Floats, Doubles]:
    """Divide photographs by their ninth decile, roughly the brightness of a lamp; return the deciles too.

    Pixels that face the lamp are the brightest ones of a photograph, whatever its direction, as long as there are some;
    a tenth of the pixels may lie in highlights.

    Raises
    ------
    HarmonicFaceError
        A photograph that is black in nine of ten pixels.
    """
    deciles = np.quantile(observations, 0.9, axis=1).astype(np.float64)
    if not (deciles > 0).all():
        dark = int(np.flatnonzero(deciles <= 0)[0])
        raise HarmonicFaceError(f"images: expected light on a tenth of the pixels at least, got image {dark} without")
    return observations / deciles[:, None], deciles


def lights_of(observations: Floats, scaled: Floats, weights: Floats) -> Doubles:
    """Return the (n, 3) lights that explain photographs of known scaled normals best by weighted least squares."""
    products = scaled[:, _ROWS] * scaled[:, _COLUMNS]
    matrices = (weights @ products)[:, _SQUARE].reshape(-1, 3, 3)
    right = (weights * observations) @ scaled
    # of a lamp that reaches too few pixels, the shortest vector that explains them
    return np.asarray((np.linalg.pinv(matrices, rcond=UNRESOLVED, hermitian=True) @ right[..., None])[..., 0])


def _start(observations: Floats) -> Doubles:
    """Return the leading three left singular vectors of photographs, times the root of their number."""
    values, vectors = np.linalg.eigh(observations @ observations.T)
    if values[-3] <= LEAST_SHARE**2 * values[-1]:
        share = np.sqrt(max(float(values[-3] / values[-1]), 0.0)) if values[-1] > 0 else 0.0
        raise HarmonicFaceError(
            "images: expected lights from directions that span space on a surface that is not flat, got photographs"
            f" that are mixtures of two (the third singular value is {share:.2g} of the first)"
        )
    return np.asarray(vectors[:, -3:] * np.sqrt(len(observations)))


def _orthogonal(lights: Doubles) -> Doubles:
    """Return orthogonal columns of length sqrt(n) that span the same."""
    return np.asarray(np.linalg.svd(lights, full_matrices=False)[0] * np.sqrt(len(lights)))
