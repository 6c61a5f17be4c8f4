"""Refinement: normals, albedo and lights together, each pixel for itself, from what a linear map of factors found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.stereo.linear_shape import unit
from harmonicface.stereo.positive_lights import positive_lights
from harmonicface.stereo.sky_cells import Singles, cell_flow, cell_shades

DETAIL = 0.06  # of the albedo: how far a pixel's scaled normal may be expected from the linear map's, 3.4 degrees
BLOCK = 1 << 13  # pixels whose light is held at once

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Refined:
    """Normals, albedo and lights after refinement, and how well they explain the photographs.

    Parameters
    ----------
    scaled
        (p, 3) albedo times normal.
    radiance
        (n, cells) of the sky.
    residual
        (p,) root mean square of photograph minus model.
    deviation
        (p,) standard error of the normal in degrees for these lights.
    cost
        Before the first round and after each; none is larger than the one before.
    """

    scaled: Doubles
    radiance: Doubles
    residual: Doubles
    deviation: Doubles
    cost: list[float]


def refine(
    photographs: Doubles, scaled: Doubles, radiance: Doubles, visibility: Singles | None, rounds: int = 2
) -> Refined:
    r"""Refine normals, albedo and lights together.

    .. math:: E(b, L) = \sum_{ix} (I_{ix} - b_x \cdot e_{ix}(n, V, L))^2
              + \frac{\sigma^2}{(0.06 \bar\rho)^2} \sum_x |b_x - \bar b_x|^2

    with e the irradiance vector (`cell_flow`), sigma the root mean square residual at the start and b-bar the start,
    which fixes the gauge. Each pixel takes a Gauss-Newton step where that lowers its own part of E, then lights are
    fitted again where that lowers the whole: E never grows. Visibility is what the start's depth leaves of the sky.

    Parameters
    ----------
    photographs
        (n, p) intensities.
    scaled
        (p, 3) albedo times normal to start from.
    radiance
        (n, cells) lights to start from.
    visibility
        (p, cells), None where nothing casts shadows.
    rounds
        How often pixels, then lights, are improved.
    """
    start, current = scaled, scaled.copy()
    rest = photographs - _model(current, radiance, visibility)
    tones = np.linalg.norm(start, axis=1)
    strength = float((rest**2).mean()) / (DETAIL * max(float(tones.mean()), 1e-12)) ** 2
    parts = (rest**2).sum(axis=0)
    cost = [float(parts.sum())]
    for _ in range(rounds):
        tried = _stepped(photographs, current, start, radiance, visibility, strength)
        now = ((photographs - _model(tried, radiance, visibility)) ** 2).sum(axis=0)
        now += strength * ((tried - start) ** 2).sum(axis=1)
        better = now < parts
        current, parts = np.where(better[:, None], tried, current), np.where(better, now, parts)
        held = strength * ((current - start) ** 2).sum(axis=1)
        shades = cell_shades(unit(current), visibility)
        lights = positive_lights(photographs, shades, np.linalg.norm(current, axis=1))
        again = ((photographs - _model(current, lights.radiance, visibility)) ** 2).sum(axis=0) + held
        if again.sum() < parts.sum():
            radiance, parts = lights.radiance, again
        cost.append(float(parts.sum()))
    residual = np.sqrt(((photographs - _model(current, radiance, visibility)) ** 2).mean(axis=0))
    return Refined(current, radiance, residual, _deviation(current, residual, radiance, visibility, strength), cost)


def _parts(count: int) -> list[slice]:
    return [slice(first, first + BLOCK) for first in range(0, count, BLOCK)]


def _seen(visibility: Singles | None, some: slice) -> Singles | None:
    return None if visibility is None else visibility[some]


def _model(scaled: Doubles, radiance: Doubles, visibility: Singles | None) -> Doubles:
    """Return the photographs that normals, albedo and lights give, (n, p)."""
    albedo = np.linalg.norm(scaled, axis=1)
    found = [
        radiance @ cell_shades(unit(scaled[some]), _seen(visibility, some)) * albedo[some]
        for some in _parts(len(scaled))
    ]
    return np.concatenate(found, axis=1)


def _stepped(
    photographs: Doubles,
    scaled: Doubles,
    start: Doubles,
    radiance: Doubles,
    visibility: Singles | None,
    strength: float,
) -> Doubles:
    """Return where a Gauss-Newton step takes each pixel."""
    found = []
    for some in _parts(len(scaled)):
        flow = cell_flow(unit(scaled[some]), radiance, _seen(visibility, some))
        normal = np.einsum("pni,pnj->pij", flow, flow) + strength * np.eye(3)
        right = np.einsum("pni,np->pi", flow, photographs[:, some]) + strength * start[some]
        found.append(np.linalg.solve(normal, right[..., None])[..., 0])
    return np.concatenate(found)


def _deviation(
    scaled: Doubles, residual: Doubles, radiance: Doubles, visibility: Singles | None, strength: float
) -> Doubles:
    """Return the standard error of normals across themselves, in degrees."""
    found = []
    count = len(radiance)
    for some in _parts(len(scaled)):
        normals = unit(scaled[some])
        flow = cell_flow(normals, radiance, _seen(visibility, some))
        inverse = np.linalg.inv(np.einsum("pni,pnj->pij", flow, flow) + strength * np.eye(3))
        across = np.trace(inverse, axis1=1, axis2=2) - np.einsum("pi,pij,pj->p", normals, inverse, normals)
        noise = residual[some] * np.sqrt(count / max(count - 3, 1))
        albedo = np.maximum(np.linalg.norm(scaled[some], axis=1), 1e-12)
        found.append(np.degrees(np.arctan(noise * np.sqrt(np.maximum(across, 0)) / albedo)))
    return np.concatenate(found)
