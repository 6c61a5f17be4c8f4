"""Prefiltered environments: what a sphere of a material shows under a light, by harmonics or exactly."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, degrees
from harmonicface.lighting._clamped_cosine import sum_lobe
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.layouts import layout_named
from harmonicface.lighting.light import Light
from harmonicface.reflectance.filters import lambertian_filter

KEPT = 1 << 18  # numbers of harmonics of a map's directions that are kept for the next light


def irradiance_map(light: Light, size: int = 64, layout: str = "latlong", order: int | None = None) -> Floats:
    """Return the irradiance of every normal as a picture of the sphere, an irradiance environment map.

    With an order it costs the light's coefficients, as many products a pixel of the light, and as many a pixel of
    the map: for order 2 and a map of T pixels T / 9 times less than the integral over the half sphere a pixel
    (Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, section 3.1).

    Parameters
    ----------
    light
        Any light.
    size
        Rows of the map, at least 1.
    layout
        "latlong", "angular", "cube" or "mirrorball": where each normal is (see `EnvironmentMap`).
    order
        Of the harmonic series; 2 leaves about 1 % of error under natural light. Exact, by brute force, if not given.

    Returns
    -------
    array
        The shape of the layout, then (3,) for coloured light; a truncated series may be below 0 in places.

    Raises
    ------
    HarmonicFaceError
        No light, a size below 1 or beyond the memory, another layout, a negative order.

    Examples
    --------
    >>> from harmonicface.lighting.lights import ambient
    >>> irradiance_map(ambient(0.5), size=1, order=2).round(6)
    array([[0.5, 0.5]])
    """
    _require_light(light)
    if order is None:
        return light.irradiance(_directions(layout, size))
    return reflection_map(light, lambertian_filter(order), size, layout)


def reflected(light: Light, filter_: ArrayLike, directions: ArrayLike) -> Floats:
    r"""Return what a material shows in mirror directions R, by harmonics.

    .. math:: B(R) = \sum_{lm} f_l L_{lm} Y_{lm}(R)

    (Ramamoorthi & Hanrahan, A Signal-Processing Framework for Reflection, 2004, sections 5.2 and 5.3: a radially
    symmetric lobe about the reflected view is a filter on the light, whatever the normal; the horizon of the surface
    is left out.) With the Lambertian filter and R = n it is the irradiance.

    Parameters
    ----------
    light
        Any light.
    filter_
        (order + 1,) numbers f_l, as `phong_filter`, `microfacet_filter`, `lambertian_filter` return them.
    directions
        (..., 3) unit vectors R: the view mirrored by the normal; for `lambertian_filter` the normal itself.

    Returns
    -------
    array
        (...) or (..., 3) for coloured light.

    Raises
    ------
    HarmonicFaceError
        No light, a filter of another shape or not finite, directions that are not finite unit vectors.

    Examples
    --------
    >>> from harmonicface.lighting.lights import ambient
    >>> reflected(ambient(np.pi), [1.0, 0.5], [[0.0, 0.0, 1.0]]).round(6)  # a radiance of 1 from everywhere
    array([1.])
    """
    _require_light(light)
    factors = _factors(filter_)
    return _series(real_harmonics(directions, len(factors) - 1), factors, light)


def reflected_exactly(environment: EnvironmentMap, lobe: Callable[[Floats], Floats], directions: ArrayLike) -> Floats:
    r"""Return the same by brute force, without harmonics: the sum over all pixels of the light.

    .. math:: B(R) = \sum_i L_i \, \Delta\omega_i \, \mathrm{lobe}(R \cdot w_i)

    Parameters
    ----------
    environment
        The light as a map.
    lobe
        From an array of cosines to the lobe there, as `lambda cosines: phong_lobe(cosines, 50)`.
    directions
        (..., 3) unit vectors R.

    Returns
    -------
    array
        (...) or (..., 3) for coloured light.

    Raises
    ------
    HarmonicFaceError
        No environment map, directions that are not finite unit vectors, a lobe that is no function or whose values
        are not finite or not one a cosine.

    Examples
    --------
    >>> white = EnvironmentMap(np.ones((32, 64)))
    >>> def squared(cosines):
    ...     return 3 / (2 * np.pi) * np.maximum(cosines, 0) ** 2
    >>> reflected_exactly(white, squared, [[0.0, 0.0, 1.0]]).round(3)
    array([1.])
    """
    if not isinstance(environment, EnvironmentMap):
        raise HarmonicFaceError(f"environment: expected an EnvironmentMap, got {type(environment).__name__}")
    if not callable(lobe):
        raise HarmonicFaceError(f"lobe: expected a function of cosines, got {_validate.describe(lobe)}")

    def checked(cosines: Floats) -> Floats:
        values = _validate.finite(lobe(cosines), "lobe")
        if values.shape != cosines.shape:
            expected = f"a value for each cosine, shape {cosines.shape}"
            raise HarmonicFaceError(f"lobe: expected {expected}, got {_validate.describe(values)}")
        return values

    towards, strengths = environment.lamps()
    return sum_lobe(_validate.unit_normals(directions, "directions"), towards, strengths, checked)


def reflection_map(light: Light, filter_: ArrayLike, size: int = 64, layout: str = "latlong") -> Floats:
    """Return `reflected` in every direction as a picture of the sphere: the prefiltered environment map.

    Look it up in the mirror direction of the view to render a shiny surface of that material.

    Parameters
    ----------
    light
        Any light.
    filter_
        (order + 1,) numbers f_l of the material.
    size
        Rows of the map, at least 1.
    layout
        "latlong", "angular", "cube" or "mirrorball".

    Returns
    -------
    array
        The shape of the layout, then (3,) for coloured light; a truncated series may be below 0 in places.

    Raises
    ------
    HarmonicFaceError
        No light, a filter of another shape or not finite, a size below 1 or beyond the memory, another layout.

    Examples
    --------
    >>> from harmonicface.lighting.lights import ambient
    >>> reflection_map(ambient(np.pi), [1.0, 0.9, 0.7], size=2, layout="cube").shape
    (6, 2, 2)
    """
    _require_light(light)
    factors = _factors(filter_)
    order = len(factors) - 1
    name, rows = layout_named(layout).name, _validate.at_least(size, 1, "size")
    harmonics = (_kept_harmonics if count(order) * rows**2 <= KEPT else _harmonics)(name, rows, order)
    return _series(harmonics, factors, light)


def _require_light(light: object) -> None:
    if not isinstance(light, Light):
        raise HarmonicFaceError(f"light: expected a light, got {_validate.describe(light)}")


def _factors(filter_: ArrayLike) -> Floats:
    factors = _validate.finite(filter_, "filter_")
    if factors.ndim != 1 or factors.size == 0:
        raise HarmonicFaceError(f"filter_: expected shape (order + 1,), got {factors.shape}")
    return factors


def _series(harmonics: Floats, factors: Floats, light: Light) -> Floats:
    """Return the sum of f_l L_lm Y_lm."""
    order = len(factors) - 1
    weighted = (factors[degrees(order)] * light.coefficients(order).T).T.astype(harmonics.dtype)
    return np.asarray(np.tensordot(harmonics, weighted, (0, 0)))


def _harmonics(layout: str, size: int, order: int) -> Floats:
    return real_harmonics(_directions(layout, size), order)


_kept_harmonics = lru_cache(maxsize=4)(_harmonics)  # of small maps: they are the same for every light


def _directions(layout: str, size: int) -> Floats:
    chosen = layout_named(layout)
    return chosen.directions(chosen.shape(_validate.at_least(size, 1, "size")))
