"""Enrolment by camera: the Surface of a synthetic person from photographs of her, lights known or not."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.appearance.render import render
from harmonicface.appearance.sensor import photograph
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.light import Light
from harmonicface.lighting.lights import directional
from harmonicface.lighting.natural import natural
from harmonicface.stereo.photometric_stereo import photometric_stereo
from harmonicface.surfaces.surface import Surface

ENROLMENTS = {
    "geometry": "normals and albedo as a scanner gives them",
    "stereo": "seven photographs, one from the front and six 40° around it, lamps known",
    "unknown": "twelve photographs under natural light of which nothing is known",
}
RIG_TILT = 40.0  # degrees between the camera's axis and the six lamps around it
UNKNOWN_LIGHTS = 12


@dataclass(frozen=True, eq=False)
class Enrolled:
    """People as one way of enrolment sees them.

    Parameters
    ----------
    surfaces
        A Surface for each; None where photometric stereo refused.
    degrees
        (people,) mean angle between the normals and the true ones; NaN where it refused.
    seconds
        What a person took at the median, photographs not counted.
    refusals
        Why there is no Surface, by index.
    """

    surfaces: list[Surface | None]
    degrees: NDArray[np.float64]
    seconds: float
    refusals: dict[int, str]


def enrol_by(
    kind: str,
    surfaces: Sequence[Surface],
    seed: int,
    tell: Callable[[int, int], None] = lambda *_: None,
) -> Enrolled:
    """Return people as photometric stereo, or a scanner, sees them.

    Parameters
    ----------
    kind
        "geometry": as they are. "stereo": by seven photographs under known lamps, one exposure for all. "unknown": by
        twelve photographs under random environments, each exposed for itself, with Basri and Jacobs' nine harmonics.
        Noise of 1 %, saturation and 8 bits are in all photographs; the mask is the person's.
    surfaces
        The people.
    seed
        The same seed gives the same photographs.
    tell
        Is told how many are done, and of how many.

    Raises
    ------
    HarmonicFaceError
        Another kind.
    """
    if kind not in ENROLMENTS:
        raise HarmonicFaceError(f"enroll: expected one of {', '.join(ENROLMENTS)}, got {kind!r}")
    if kind == "geometry":
        return Enrolled(list(surfaces), np.zeros(len(surfaces)), 0.0, {})
    found: list[Surface | None] = []
    degrees, times, refusals = np.full(len(surfaces), np.nan), [], {}
    for index, surface in enumerate(surfaces):
        rng = np.random.default_rng([seed, 3, list(ENROLMENTS).index(kind), index])
        images, lamps = _rig(surface, rng) if kind == "stereo" else (_environments(surface, rng), None)
        start = time.perf_counter()
        try:
            model = "linear3" if kind == "stereo" else "harmonic9"
            result = photometric_stereo(images, lamps, surface.mask, model=model, integration="none")  # type: ignore[arg-type]
            seen = result.surface
            found.append(seen)
            degrees[index] = mean_angle(seen, surface)
        except HarmonicFaceError as error:
            found.append(None)
            refusals[index] = str(error)
        times.append(time.perf_counter() - start)
        tell(index + 1, len(surfaces))
    return Enrolled(found, degrees, float(np.median(times)), refusals)


def mean_angle(found: Surface, truth: Surface) -> float:
    """Return the mean angle between two Surfaces' normals in degrees, over the mask that both have."""
    both = found.mask & truth.mask
    cosines = np.einsum("pk,pk->p", found.normals[both], truth.normals[both].astype(found.normals.dtype))
    return float(np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean())


def rig() -> NDArray[np.float64]:
    """Return the directions of the seven known lamps."""
    tilt, around = np.radians(RIG_TILT), np.linspace(0, 2 * np.pi, 6, endpoint=False)
    ring = [[np.sin(tilt) * np.cos(a), np.sin(tilt) * np.sin(a), np.cos(tilt)] for a in around]
    return np.array([[0.0, 0.0, 1.0], *ring])


def _rig(surface: Surface, rng: np.random.Generator) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Photograph somebody under seven lamps with one exposure."""
    lamps = rig()
    height, width = surface.shape
    tall = np.concatenate([render(surface, directional(lamp)) for lamp in lamps])  # one picture: one exposure
    return np.asarray(photograph(tall, rng).reshape(len(lamps), height, width), np.float32), lamps


def _environments(surface: Surface, rng: np.random.Generator) -> NDArray[np.float32]:
    """Photograph somebody in twelve places."""
    lights: list[Light] = [natural(rng) for _ in range(UNKNOWN_LIGHTS)]
    return np.stack([photograph(render(surface, light), rng) for light in lights]).astype(np.float32)
