"""The illumination cone: a person's pictures under lamps in many directions, with attached and with cast shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.nonnegative_light import fibonacci_sphere
from harmonicface.appearance.shadows import shadowed_irradiance
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.lights import directional
from harmonicface.recognition.estimators.cone import NearestCone
from harmonicface.surfaces.surface import Surface

DIRECTIONS = 300  # on the whole sphere: 13 degrees apart
BEHIND = -0.2  # z of a direction from which a face that looks at the camera gets next to no light


class ConeAttached(NearestCone):
    r"""Nearest illumination cone with attached shadows (Georghiades, Belhumeur & Kriegman 2001).

    Its rays are rho max(n . w, 0) under single lamps w: evenly spread ones, or the cone's extreme rays, at which
    two pixels i, j come out of shadow together, w = +-(n_i x n_j) (Belhumeur & Kriegman 1998).

    Parameters
    ----------
    image_shape, registration
        See `SurfaceClassifier`.
    directions
        How many directions to spread over the sphere; those behind the face are left out. Of extreme rays, how many.
    rays
        "sampled" or "extreme".
    random_state
        Seed of the pairs of pixels that give extreme rays.

    Raises
    ------
    HarmonicFaceError
        Rays of another kind, fewer than one direction.

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = {name: hf.synthetic_person(seed, size=32) for name, seed in (("ada", 0), ("bob", 1))}
    >>> classifier = ConeAttached.from_surfaces(list(people), list(people.values()), directions=50)
    >>> photo = hf.render(people["bob"], hf.lights.directional([1.0, 1.0, 1.0]))
    >>> str(classifier.predict(photo.reshape(1, -1))[0])
    'bob'
    """

    def __init__(
        self,
        image_shape: tuple[int, int] | None = None,
        registration: bool = False,
        directions: int = DIRECTIONS,
        rays: str = "sampled",
        random_state: int = 0,
    ) -> None:
        super().__init__(image_shape, registration)
        self.directions = directions
        self.rays = rays
        self.random_state = random_state

    def _pictures(self, surface: Surface) -> Floats:
        if self.rays not in ("sampled", "extreme"):
            raise HarmonicFaceError(f'rays: expected "sampled" or "extreme", got {self.rays!r}')
        lamps = (
            front_directions(self.directions)
            if self.rays == "sampled"
            else extreme_directions(surface, self.directions, self.random_state)
        )
        return np.asarray(np.maximum(lamps @ surface.pixel_normals.T, 0) * surface.grey_albedo)


class ConeCast(NearestCone):
    """Nearest illumination cone with attached and cast shadows, sampled (Georghiades, Belhumeur & Kriegman 2001).

    Surfaces need depth or a scene; photographs give it by integrating their normals.

    Parameters
    ----------
    image_shape, registration
        See `SurfaceClassifier`.
    directions
        How many directions to spread over the sphere; those behind the face are left out.
    """

    _needs_depth = True

    def __init__(
        self,
        image_shape: tuple[int, int] | None = None,
        registration: bool = False,
        directions: int = DIRECTIONS,
    ) -> None:
        super().__init__(image_shape, registration)
        self.directions = directions

    def _pictures(self, surface: Surface) -> Floats:
        lamps = [directional(lamp) for lamp in front_directions(self.directions)]
        return np.stack([shadowed_irradiance(surface, lamp) for lamp in lamps]) * surface.grey_albedo


def front_directions(count: int) -> NDArray[np.float64]:
    """Return those of evenly spread directions that do not lie behind what faces the camera, (n, 3).

    Examples
    --------
    >>> front_directions(100).shape
    (60, 3)
    """
    towards = fibonacci_sphere(_validate.at_least(count, 1, "directions"))
    return np.asarray(towards[towards[:, 2] >= BEHIND])


def extreme_directions(surface: Surface, count: int, seed: int = 0) -> NDArray[np.float64]:
    """Return directions of lamps at which two pixels of a Surface come out of shadow together, (n, 3).

    The normals of two random pixels have two such directions, +-(n_i x n_j); pairs whose normals are parallel have
    none and are left out, so that n may be smaller than asked for.

    Examples
    --------
    >>> import harmonicface as hf
    >>> ada = hf.synthetic_person(0, size=32)
    >>> lamps = extreme_directions(ada, 4)
    >>> bool((abs(lamps @ ada.pixel_normals.T).min(axis=1) < 1e-6).all())
    True
    """
    pairs = -(-_validate.at_least(count, 1, "directions") // 2)
    normals = surface.pixel_normals.astype(np.float64)
    first, second = _validate.generator(seed, "random_state").integers(0, len(normals), (2, pairs))
    across = np.cross(normals[first], normals[second])
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    parallel = lengths[:, 0] < 1e-9
    if parallel.all():
        raise HarmonicFaceError("surface: expected normals that differ, got parallel ones")
    lamps = across[~parallel] / lengths[~parallel]
    return np.concatenate([lamps, -lamps])[:count]
