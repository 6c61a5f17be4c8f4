"""Harmonic images: the low-dimensional span of a matte surface's pictures under all distant light."""

from __future__ import annotations

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.from_surfaces import SurfaceSubspace
from harmonicface.recognition.models import harmonic9, harmonic_shadowed
from harmonicface.surfaces.surface import Surface


class Harmonic9(SurfaceSubspace):
    """Nearest span of nine harmonic images, with attached shadows (Basri & Jacobs 2003).

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = {name: hf.synthetic_person(seed, size=32) for name, seed in (("ada", 0), ("bob", 1))}
    >>> classifier = Harmonic9.from_surfaces(list(people), list(people.values()))
    >>> photo = hf.render(people["bob"], hf.lights.directional([1.0, 1.0, 1.0]))
    >>> str(classifier.predict(photo.reshape(1, -1))[0])
    'bob'
    """

    def _pictures(self, surface: Surface) -> Floats:
        return harmonic9(surface)


class HarmonicShadowed(SurfaceSubspace):
    """Nearest span of the 25 harmonic images of order 4 with cast shadows (see `models.harmonic_shadowed`).

    Surfaces need depth or a scene; photographs give it by integrating their normals.
    """

    _needs_depth = True

    def _pictures(self, surface: Surface) -> Floats:
        return harmonic_shadowed(surface)
