"""The images of a Surface in exact pictures to a high degree of light, and the images that models make do with."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harmonicface.appearance.gloss import view_directions
from harmonicface.appearance.principal_lights import HIGHEST_ORDER
from harmonicface.appearance.specular_shadows import open_share
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, degrees
from harmonicface.reflectance.filters import lambertian_filter, lambertian_weights
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.blockers import MeshBlocker
from harmonicface.surfaces.horizon_transport import horizon_transport
from harmonicface.surfaces.ray_transport import RAYS, direct_transport
from harmonicface.surfaces.scene import FineSamples
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

MODEL_ORDER = 6  # the highest degree of the images that a model is made of
PIXELS = 2048  # that stand for all: a model of 49 images fits 2 % of what it should not
EXACT_RAYS = 2048  # of the transport that models are compared with; theirs has 512
GLOSS_SHADOW_ORDER = 4  # of the transport that tells how much of a coat's lobe is open
FARTHEST = 200  # the degree above which nothing is counted
SOFT_EDGES = -2.75  # the power of the degree by which the energy of transport falls where pixels average over shadows
HARD_EDGES = -2.0  # and where they do not


@dataclass(frozen=True, eq=False)
class Images:
    """Harmonic images of some pixels of a Surface, a row a harmonic.

    Parameters
    ----------
    exact
        (169, q) images of what a photograph shows, to order 12, with the cast shadows and the gloss that there are.
    models
        (49, q) images that models are made of, by whether they have shadows and gloss.
    spectrum
        (201,) energy of a Surface's pictures by the degree of the light, sum over pixels and modes; above order 12 by
        the filters' closed form and, of cast shadows, by a power law.
    pixels
        How many pixels the Surface has; q of them stand for all.
    """

    exact: Array
    models: dict[tuple[bool, bool], Array]
    spectrum: Array
    pixels: int


def images_of(surface: Surface, shadows: bool, material: Material | None) -> Images:
    """Return the images of what photographs of a Surface show, and those of models.

    Raises
    ------
    HarmonicFaceError
        Shadows of a Surface with neither depth nor scene, albedo that is 0 everywhere.
    """
    albedo = surface.grey_albedo.astype(np.float64)
    if not albedo.any():
        raise HarmonicFaceError("surface: expected some albedo above 0, got 0 everywhere")
    albedo = albedo / albedo.max()
    some = _some_pixels(len(albedo))
    normals = surface.pixel_normals[some].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    weights = lambertian_weights(HIGHEST_ORDER)[:, None]
    plain = weights * real_harmonics(normals, HIGHEST_ORDER)
    few = count(MODEL_ORDER)
    reaching, modelled = _transports(surface, some) if shadows else (plain, plain[:few])
    own = albedo[some]
    exact, matte = own * reaching, own * plain
    spectrum = _extended(exact, shadows, None if surface.scene is not None else matte)
    models = {(False, False): matte[:few], (shadows, False): own * modelled}
    if material is not None:
        shine = _shine(surface, some, material) / surface.grey_albedo.max()
        seen = shine * _open(surface, some, material) if shadows else shine
        models[False, True] = models[False, False] + shine[:few]
        models[shadows, True] = models[shadows, False] + seen[:few]
        exact = exact + seen
        spectrum = spectrum + _shine_spectrum(seen, material)
    return Images(exact, models, spectrum, len(albedo))


def _some_pixels(pixels: int) -> NDArray[np.int64]:
    """Return which pixels stand for all, in their order."""
    if pixels <= PIXELS:
        return np.arange(pixels)
    edges = np.linspace(0, pixels, PIXELS + 1).astype(np.int64)
    return np.random.default_rng(0).integers(edges[:-1], edges[1:])  # one of each run of pixels


def _transports(surface: Surface, some: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the transport to some pixels, as exact as it gets, and to a model's order as a model has it."""
    if surface.scene is not None:
        samples = _samples_of(surface.scene.samples(surface.mask), some)
        blocker = MeshBlocker(surface.scene.caster, samples)
        exact = direct_transport(blocker, samples, HIGHEST_ORDER, EXACT_RAYS)
        return exact, direct_transport(blocker, samples, MODEL_ORDER, RAYS)
    if surface.depth is None:
        raise HarmonicFaceError("shadows: expected a Surface with depth or a scene to cast them, got one with neither")
    exact = horizon_transport(surface, HIGHEST_ORDER)[:, some].astype(np.float64)
    return exact, exact[: count(MODEL_ORDER)]


def _samples_of(samples: FineSamples, some: NDArray[np.int64]) -> FineSamples:
    """Return the samples of some pixels, which are numbered anew."""
    number = np.full(samples.pixels, -1)
    number[some] = np.arange(len(some))
    kept = np.flatnonzero(number[samples.pixel] >= 0)
    moved = np.zeros(len(samples.pixel), np.int64)
    moved[kept] = np.arange(len(kept))
    names = ("positions", "geometric", "normals", "albedo")
    parts = {name: getattr(samples, name)[kept] for name in names}
    return replace(samples, **parts, pixel=number[samples.pixel[kept]], slots=moved[samples.slots[some]])


def _shine(surface: Surface, some: NDArray[np.int64], material: Material) -> Array:
    r"""Return \pi F f_l Y_lm(R), the images of a coat that nothing hides, (169, q)."""
    normals, view = (array[some].astype(np.float64) for array in (surface.pixel_normals, view_directions(surface)))
    facing = np.einsum("pi,pi->p", normals, view)
    mirrored = _unit(2 * facing[:, None] * normals - view)
    factors = material.filter(HIGHEST_ORDER)[degrees(HIGHEST_ORDER)]
    strength = math.pi * material.reflectance(facing)
    return np.asarray(factors[:, None] * real_harmonics(mirrored, HIGHEST_ORDER) * strength)


def _open(surface: Surface, some: NDArray[np.int64], material: Material) -> Array:
    """Return the share of each pixel's lobe that nothing hides, (q,)."""
    normals, view = surface.pixel_normals.astype(np.float64), view_directions(surface)
    mirrored = _unit(2 * np.einsum("pi,pi->p", normals, view)[:, None] * normals - view)
    return np.asarray(open_share(surface, mirrored, material, GLOSS_SHADOW_ORDER)[some])


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _by_degree(images: Array) -> Array:
    """Return the energy of images, summed over pixels and modes, by degree."""
    return np.asarray(np.bincount(degrees(HIGHEST_ORDER), np.einsum("kp,kp->k", images, images)), np.float64)


def _extended(images: Array, shadows: bool, hard: Array | None) -> Array:
    r"""Return the energy by degree, above the order of the images as the cosine's filter or as edges have it.

    Where a pixel is lit or not, V^2 = V, and all of the energy is \sum T_lm A_l Y_lm(n), which converges fast.
    """
    known, beyond = _by_degree(images), np.arange(HIGHEST_ORDER + 1, FARTHEST + 1)
    if not shadows:
        energy = (2 * np.arange(FARTHEST + 1) + 1) * lambertian_filter(FARTHEST) ** 2
        law = known[0] / energy[0] * energy[beyond]
    elif hard is not None:
        left = max(float((images * hard).sum() - known.sum()), 0.0)
        law = left * beyond**HARD_EDGES / (beyond**HARD_EDGES).sum()
    else:
        last = np.arange(HIGHEST_ORDER - 2, HIGHEST_ORDER + 1)
        law = known[last].sum() / (last**SOFT_EDGES).sum() * beyond**SOFT_EDGES
    return np.concatenate([known, law])


def _shine_spectrum(images: Array, material: Material) -> Array:
    """Return the energy of a coat's images by degree."""
    energy = (2 * np.arange(FARTHEST + 1) + 1) * material.filter(FARTHEST) ** 2
    return np.asarray(_by_degree(images)[0] / energy[0] * energy)
