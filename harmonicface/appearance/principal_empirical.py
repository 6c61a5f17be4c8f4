"""Empirical principal components: many pictures are rendered and decomposed, to compare with the analytic ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh, svd
from scipy.special import roots_legendre

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.appearance._options import with_shadows
from harmonicface.appearance.principal_components import PrincipalComponents
from harmonicface.appearance.principal_lights import EXPECTED, NEGATIVE
from harmonicface.appearance.principal_options import NO_DIFFERENCE, checked_count, kept_components, pixel_weights
from harmonicface.appearance.render import render
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.grid import SphereGrid, sphere_grid
from harmonicface.harmonics.quadrature import synthesize
from harmonicface.io.colour import luminance
from harmonicface.lighting.as_light import as_light
from harmonicface.lighting.light import Light
from harmonicface.lighting.natural import natural
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

METHODS = ("gram", "svd")
ROUNDINGS = 8  # operations behind each number


@dataclass(frozen=True, eq=False)
class Sample:
    """Lights that stand for a distribution: lamps (n, 3) or whole lights, and the probability of each, (n,)."""

    probabilities: Array
    lamps: Array | None = None
    lights: Sequence[Light] = ()

    def all(self) -> Sequence[Light]:
        """Return the lights, lamps as such."""
        if self.lamps is None:
            return self.lights
        return [DirectionalLights(lamp[None], np.ones(1)) for lamp in self.lamps]


def empirical_pca(
    surface: Surface,
    n_components: int | float = 5,
    order: int = 4,
    lights: str | Light | Sequence[Light | str] | ArrayLike = "sphere",
    centered: bool = True,
    *,
    pictures: int = 1000,
    weights: ArrayLike | None = None,
    shadows: bool = False,
    bounces: int = 0,
    method: str = "gram",
    seed: int = 0,
) -> PrincipalComponents:
    """Return the principal components of many exact renderings: what `analytic_pca` has without them.

    Lamps stand on a grid and count by its quadrature weights, so that sums over them are integrals over the
    distribution: random ones would err by 5 % with 1,000 pictures. Every picture is exact: the clamped cosine itself,
    without harmonics.

    Parameters
    ----------
    surface, n_components, centered, weights, shadows, bounces
        As for `analytic_pca`.
    order
        To which the light of each component is told; nothing else depends on it.
    lights
        "sphere" or "frontal"; coefficients (k,) of a density of lamps; "natural"; a Light or several.
    pictures
        How many lamps the grid has at least, or how many natural environments are drawn.
    method
        "gram": eigenvectors of the products of pictures with each other, or of pixels with each other, whichever are
        fewer. "svd": the singular value decomposition of all pictures, dearer and exact where variances are below
        1e-7 of the largest.
    seed
        Of the natural environments.

    Returns
    -------
    PrincipalComponents
        Its total is that of the rendered pictures.

    Raises
    ------
    HarmonicFaceError
        Something else than these; lights whose pictures do not differ.

    Examples
    --------
    >>> import harmonicface as hf
    >>> from harmonicface.appearance.principal import analytic_pca
    >>> face = hf.synthetic_person(0, size=32)
    >>> rendered, analytic = empirical_pca(face), analytic_pca(face)
    >>> bool(abs(rendered.variances / analytic.variances - 1).max() < 0.01)
    True
    """
    if method not in METHODS:
        raise HarmonicFaceError(f"method: expected one of {', '.join(METHODS)}, got {method!r}")
    wanted = checked_count(n_components)
    sample = _sample(lights, _validate.at_least(pictures, 1, "pictures"), seed)
    each = pixel_weights(surface, weights)
    rendered = _rendered(surface, sample, with_shadows(shadows, bounces), bounces)
    shares = sample.probabilities
    eps = ROUNDINGS * float(np.finfo(rendered.dtype).eps)
    mean = (shares @ rendered) * bool(centered)
    rendered -= mean.astype(rendered.dtype)
    rendered *= np.sqrt(shares)[:, None].astype(rendered.dtype)
    if weights is not None:
        rendered *= np.sqrt(each).astype(rendered.dtype)
    total = float(np.einsum("np,np->", rendered, rendered, dtype=np.float64))
    if total <= eps**2 * float(each @ mean**2):  # rounding alone
        raise HarmonicFaceError(NO_DIFFERENCE)
    values, vectors = (_by_gram if method == "gram" else _by_svd)(rendered, wanted)
    kept = kept_components(values, total, wanted, eps if method == "gram" else len(values) * eps**2)
    combinations = vectors[:, :kept].T / np.sqrt(values[:kept, None])
    found = np.stack([_grey_coefficients(light, order) for light in sample.all()])
    mean_light = (shares @ found) * bool(centered)
    components = combinations.astype(rendered.dtype) @ rendered
    if weights is not None:
        components = np.divide(components, np.sqrt(each), out=np.zeros_like(components), where=each > 0)
    return PrincipalComponents(
        components=components.astype(surface.normals.dtype),
        variances=values[:kept],
        total=total,
        mean=mean.astype(surface.normals.dtype),
        lights=(combinations * np.sqrt(shares)) @ (found - mean_light),
        mean_light=mean_light,
        mask=surface.mask,
        weights=each.astype(surface.normals.dtype),
    )


def lamp_grid(lights: str | Array, directions: int) -> tuple[Array, Array]:
    """Return lamps on a grid, (n, 3), and their probabilities, (n,), for a distribution of lamps.

    Parameters
    ----------
    lights
        "sphere", "frontal", or harmonic coefficients (k,) of a density.
    directions
        How many lamps at least.

    Raises
    ------
    HarmonicFaceError
        A density that is negative in places, or nowhere above 0.
    """
    if isinstance(lights, str) and lights == "frontal":
        rows = int(np.ceil(np.sqrt(directions / 2)))
        z, across = roots_legendre(rows)
        grid = SphereGrid((z + 1) / 2, across * np.pi / (2 * rows), 2 * rows)
        return grid.directions, grid.weights / grid.weights.sum()
    grid = sphere_grid(int(np.ceil(np.sqrt(directions / 2))))
    density = np.ones(len(grid.weights)) if isinstance(lights, str) else synthesize(lights, grid).ravel()
    if not density.max() > 0 or density.min() < -NEGATIVE * density.max():
        got = f"{density.min():.4g} to {density.max():.4g}"
        raise HarmonicFaceError(f"lights: expected a density of at least 0, and above it somewhere, got {got}")
    shares = grid.weights * np.maximum(density, 0)
    return grid.directions[shares > 0], shares[shares > 0] / shares.sum()


def _sample(lights: str | Light | Sequence[Light | str] | ArrayLike, pictures: int, seed: int) -> Sample:
    """Return lights that stand for a distribution."""
    if isinstance(lights, str) and lights in ("sphere", "frontal"):
        lamps, shares = lamp_grid(lights, pictures)
        return Sample(shares, lamps)
    if isinstance(lights, str) and lights == "natural":
        rng = _validate.generator(seed, "seed")
        return Sample(np.full(pictures, 1 / pictures), lights=[natural(rng) for _ in range(pictures)])
    if isinstance(lights, (Light, str)):
        lights = [lights]
    if isinstance(lights, (list, tuple)) and lights and all(isinstance(one, (Light, str)) for one in lights):
        return Sample(np.full(len(lights), 1 / len(lights)), lights=[as_light(one) for one in lights])
    try:
        density = _validate.finite(lights, "lights").astype(np.float64)  # type: ignore[arg-type]
    except HarmonicFaceError:
        raise HarmonicFaceError(f"lights: expected {EXPECTED}, got {_validate.describe(lights)}") from None
    if density.ndim != 1 or density.size == 0:
        raise HarmonicFaceError(f"lights: expected lights that can be rendered, got {_validate.describe(density)}")
    lamps, shares = lamp_grid(density, pictures)
    return Sample(shares, lamps)


def _rendered(surface: Surface, sample: Sample, shadows: bool, bounces: int) -> Floats:
    """Return the masked pixels of a picture under each light, (n, p), grey."""
    number, dtype = len(sample.probabilities), surface.normals.dtype
    size = len(surface.pixel_normals)
    if sample.lamps is None or shadows:
        result: Floats = _memory.empty((number, size), dtype, f"{number} pictures of {size} pixels")
        for row, light in zip(result, sample.all(), strict=True):
            pixels = render(surface, light, shadows=shadows, bounces=bounces)[surface.mask]
            row[:] = luminance(pixels) if pixels.ndim == 2 else pixels
        return result
    _memory.require(number * size * dtype.itemsize, f"{number} pictures of {size} pixels")
    result = sample.lamps.astype(dtype) @ surface.pixel_normals.T
    np.maximum(result, 0, out=result)
    result *= surface.grey_albedo.astype(dtype)
    return result


def _by_gram(rendered: Floats, wanted: int | float) -> tuple[Array, Array]:
    """Return variances, largest first, and for each the unit vector (n,) by which the pictures combine."""
    count, size = rendered.shape
    products = (rendered @ rendered.T if count <= size else rendered.T @ rendered).astype(np.float64)
    last = len(products) - 1
    some = (max(0, last + 1 - wanted), last) if isinstance(wanted, int) else None
    values, vectors = eigh(products, subset_by_index=some, overwrite_a=True, check_finite=False)
    values, vectors = values[::-1], vectors[:, ::-1]
    if count > size:
        lit = values > 0
        values, vectors = values[lit], (rendered @ vectors[:, lit].astype(rendered.dtype)) / np.sqrt(values[lit])
    return values, vectors


def _by_svd(rendered: Floats, wanted: int | float) -> tuple[Array, Array]:
    """Return the same by the singular value decomposition of the pictures."""
    left, singular, _ = svd(rendered, full_matrices=False, check_finite=False)
    return singular.astype(np.float64) ** 2, left.astype(np.float64)


def _grey_coefficients(light: Light, order: int) -> Array:
    """Return the harmonic coefficients of a light as luminance."""
    found = light.coefficients(order).astype(np.float64)
    return np.asarray(luminance(found) if found.ndim == 2 else found)
