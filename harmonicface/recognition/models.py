"""Which pictures span a person's pictures: the subspace models, by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.principal import analytic_pca
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.auto_model import auto
from harmonicface.recognition.nine_lights import nine_points
from harmonicface.surfaces.surface import Surface

LAMPS = "frontal"  # what a camera's side of a face shows of lamps behind it is little
ENERGY = 0.99  # so that the mean square of the distance to them is that of 0.1, at which a gallery names a person


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


def principal(surface: Surface, n_components: int | float) -> Floats:
    """Return the span of the first principal components of pictures under one lamp in front, (25, p) of that rank.

    They are the 25 harmonic images of order 4, of each of which the light is projected onto the lights that the
    components are: so combining them to a photograph gives its light, as with the harmonic images themselves. The
    components are about 0 (Ramamoorthi 2002, but with the mean left in, since a photograph may be of any brightness).

    Parameters
    ----------
    surface
        Whose pictures.
    n_components
        How many; or a share of the energy of the pictures, of which the fewest that explain it are taken.
    """
    found = analytic_pca(surface, n_components, lights=LAMPS, centered=False)
    # float64 whatever the Surface is: their rank must not drown in rounding
    return np.asarray(np.linalg.pinv(found.lights) @ found.components.astype(np.float64))


SUBSPACE_MODELS: dict[str, Callable[[Surface], Floats]] = {
    "linear3": linear3,
    "ambient4": ambient4,
    "harmonic9": harmonic9,
    "pca3": partial(principal, n_components=3),
    "pca5": partial(principal, n_components=5),
    "pca_auto": partial(principal, n_components=ENERGY),
    "auto": auto,
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
