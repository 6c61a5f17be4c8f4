"""Analytic principal components: what random light does to a Surface, without rendering a picture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance._options import with_shadows
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.principal_components import PrincipalComponents
from harmonicface.appearance.principal_lights import HIGHEST_ORDER, POWER_ORDER, Lights, light_statistics
from harmonicface.appearance.principal_options import checked_count, kept_components, pixel_weights
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count, degrees
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

ROUNDINGS = 8  # operations behind each number
BLOCK = 1 << 11  # pixels whose harmonic images stay in the cache
SAME = 1e-28  # of the light's mean square: a variance of rounding alone
DIFFERENT = "lights: expected lights that differ"


def analytic_pca(
    surface: Surface,
    n_components: int | float = 5,
    order: int = 4,
    lights: Lights = "sphere",
    centered: bool = True,
    *,
    weights: ArrayLike | None = None,
    shadows: bool = False,
    bounces: int = 0,
) -> PrincipalComponents:
    r"""Return the principal components of all pictures of a Surface under a distribution of distant lights.

    With the harmonic images B, (k, p), a picture is L B, so that the covariance of pictures is B^T C B with the
    covariance C = S S^T of the light's coefficients: its eigenvectors come from the k x k matrix of the same
    eigenvalues,

    .. math:: S^T B B^T S \, v_j = \lambda_j v_j, \qquad u_j = B^T S v_j / \sqrt{\lambda_j}

    and no picture is rendered. For lamps over the whole sphere C is the identity over 4 pi, but for degree 0, which is
    the same for every lamp and goes with the mean (Ramamoorthi, Analytic PCA Construction for Theoretical Analysis of
    Lighting Variability in Images of a Lambertian Object, 2002; the eigenvalues go as the squares of the filter, not,
    as in Modeling Illumination Variation with Spherical Harmonics, 2005, as the filter). Few components do because a
    camera sees half of the normals at most, on which harmonics are no longer independent.

    Parameters
    ----------
    surface
        What is seen; its albedo as luminance. For shadows it needs depth or a scene.
    n_components
        How many at most: fewer come where the pictures vary in fewer ways (a wall has one normal). A share above 0 and
        below 1: the fewest that explain so much of the total.
    order
        The highest degree of light, 0 to 12. Order 4 leaves out 0.2 % of the energy of a lamp, order 2 leaves 0.8 %.
    lights
        "sphere", "frontal", "natural", a Light or several, a density or a covariance: see `light_statistics`.
    centered
        Take the mean picture out; otherwise the components are about 0, which spans the pictures themselves best.
    weights
        (h, w) numbers of at least 0: by how much each pixel counts, not all 0 in the mask. By default all alike.
    shadows, bounces
        With cast shadows, and with light thrown back: see `transport`.

    Returns
    -------
    PrincipalComponents
        Its total counts all degrees of light; with shadows those up to `order` only.

    Raises
    ------
    HarmonicFaceError
        Something else than these; lights that do not differ where the mean is taken out, or light nothing; a share that
        this order does not reach; variances outside the range of numbers.

    Examples
    --------
    >>> import harmonicface as hf
    >>> found = analytic_pca(hf.synthetic_person(0, size=64))
    >>> found.components.shape[0], bool(found.explained[:3].sum() > 0.9)
    (5, True)
    """
    if not isinstance(surface, Surface):
        raise HarmonicFaceError(f"surface: expected a Surface, got {_validate.describe(surface)}")
    if not isinstance(centered, (bool, np.bool_)):
        raise HarmonicFaceError(f"centered: expected True or False, got {_validate.describe(centered)}")
    wanted = checked_count(n_components)
    if count(order) > count(HIGHEST_ORDER):
        raise HarmonicFaceError(f"order: expected 0 to {HIGHEST_ORDER}, got {order}")
    casting = with_shadows(shadows, bounces)
    statistics = light_statistics(lights)
    rows, known = count(order), order if casting else max(order, POWER_ORDER)
    each = pixel_weights(surface, weights)
    images = harmonic_images(surface, known, casting, bounces)
    brightness = _scale(images, "albedo: expected some above 0")
    images *= 1 / brightness
    variation = statistics.variation(known, bool(centered))
    strength = _scale(variation, DIFFERENT)
    variation = variation / strength
    gram = _gram(images, None if weights is None else each)
    total = float((variation * gram).sum())
    if not casting:
        total += _above(gram, statistics.tail(known, bool(centered)) / strength)
    root = _square_root(variation[:rows, :rows])
    if strength <= SAME * np.abs(statistics.moment).max() or root.size == 0:
        raise HarmonicFaceError(f"{DIFFERENT} up to order {order}, got lights that are all the same")
    values, vectors = eigh(root.T @ gram[:rows, :rows] @ root)
    values, vectors = values[::-1], vectors[:, ::-1]
    rounding = max(float(np.finfo(np.float64).eps), ROUNDINGS * float(np.finfo(surface.normals.dtype).eps) ** 2)
    kept = kept_components(values, total, wanted, ROUNDINGS * len(values) * rounding)
    with np.errstate(over="ignore", under="ignore"):
        unit = strength * brightness * brightness
    if not (values[kept - 1] * unit > 0 and np.isfinite(total * unit)):
        raise HarmonicFaceError("variances: expected albedo and light within the range of numbers, got some beyond it")
    combinations = ((root @ vectors[:, :kept]) / np.sqrt(values[:kept])).T
    mean_light = statistics.mean[:rows] * bool(centered)
    dtype = images.dtype
    pictures = _combined(np.vstack([combinations, mean_light]).astype(dtype), images[:rows])
    return PrincipalComponents(
        components=pictures[:-1],
        variances=values[:kept] * unit,
        total=total * unit,
        mean=pictures[-1] * dtype.type(brightness),
        lights=combinations / brightness,
        mean_light=mean_light,
        mask=surface.mask,
        weights=each.astype(dtype),
    )


def _scale(array: Floats, expected: str) -> float:
    """Return the power of 2 next to the largest size in an array, which divides it without rounding.

    Raises
    ------
    HarmonicFaceError
        All is 0, or beyond the range of numbers.
    """
    largest = max(float(array.max()), -float(array.min()))
    if not 0 < largest < np.inf:
        raise HarmonicFaceError(f"{expected} and within the range of numbers, got {largest:.4g} at most")
    return math.ldexp(1.0, math.frexp(largest)[1])


def _gram(images: Floats, weights: Array | None) -> Array:
    """Return the sums over pixels of products of images, times weights if there are any, (k, k), in float64."""
    total = np.zeros((len(images), len(images)))
    for first in range(0, images.shape[1], BLOCK):
        some = images[:, first : first + BLOCK].astype(np.float64)
        total += some @ some.T if weights is None else (some * weights[first : first + BLOCK]) @ some.T
    return total


def _combined(factors: Floats, images: Floats) -> Floats:
    """Return combinations of images, (n, p), in blocks: small products do not wait for other threads to wake up."""
    result = np.empty((len(factors), images.shape[1]), images.dtype)
    for first in range(0, images.shape[1], BLOCK):
        some = np.s_[:, first : first + BLOCK]
        result[some] = factors @ images[some]
    return result


def _square_root(matrix: Array) -> Array:
    """Return S with S S^T = the matrix, (k, r); directions without variance are left out."""
    values, vectors = eigh(matrix)
    some = values > ROUNDINGS * np.finfo(np.float64).eps * len(values) * values[-1]
    return np.asarray(vectors[:, some] * np.sqrt(values[some]))


def _above(gram: Array, tail: Array) -> float:
    r"""Return the variance of degrees above an order, \sum w \rho^2 tail(n), from row 0 of B B^T.

    That row holds the sums of w \rho^2 Y_lm(n) of each degree that the surface reflects.
    """
    degree = degrees(POWER_ORDER)
    factors = lambertian_filter(POWER_ORDER)[degree]
    seen = factors != 0
    sums = gram[0, : len(degree)][seen] / factors[seen] * np.sqrt(4 / np.pi)  # A_0 Y_00 = sqrt(pi) / 2
    return float(sums @ tail[seen])
