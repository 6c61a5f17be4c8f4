"""Which pictures span a person's pictures: the subspace models, by name."""

from __future__ import annotations

from collections.abc import Callable

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.nine_lights import nine_points
from harmonicface.surfaces.surface import Surface


def linear3(surface: Surface) -> Floats:
    """Return albedo times the three components of the normal: no shadows (Hayakawa 1994; Shashua 1997), (3, p)."""
    return harmonic_images(surface, order=1)[1:]


def ambient4(surface: Surface) -> Floats:
    """Return the same and the albedo, for ambient light (Koenderink & van Doorn 1997), (4, p)."""
    return harmonic_images(surface, order=1)


def harmonic9(surface: Surface) -> Floats:
    """Return the nine harmonic images, with attached shadows (Basri & Jacobs 2003), (9, p)."""
    return harmonic_images(surface, order=2)


def harmonic_shadowed(surface: Surface) -> Floats:
    """Return the 25 harmonic images of order 4 with the shadows that the Surface casts on itself, (25, p).

    Order 2 does for attached shadows, whose light is all but gone from degree 4 on; a cast shadow has an edge, and
    needs more (Lee, Ho & Kriegman 2005 report nine). The Surface needs depth or a scene.
    """
    return harmonic_images(surface, order=4, shadows=True)


SUBSPACE_MODELS: dict[str, Callable[[Surface], Floats]] = {
    "linear3": linear3,
    "ambient4": ambient4,
    "harmonic9": harmonic9,
    "harmonic_shadowed": harmonic_shadowed,
    "nine_points_simulated": nine_points,
}
WITH_DEPTH = ("harmonic_shadowed",)  # what casts shadows


def subspace_model(name: str) -> Callable[[Surface], Floats]:
    """Return the model of that name.

    Raises
    ------
    HarmonicFaceError
        There is no model of that name.
    """
    if name not in SUBSPACE_MODELS:
        raise HarmonicFaceError(f"model: expected one of {', '.join(SUBSPACE_MODELS)}, got {name!r}")
    return SUBSPACE_MODELS[name]
