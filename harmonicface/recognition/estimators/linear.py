"""Linear subspaces of three and four dimensions: a matte surface without shadows."""

from __future__ import annotations

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.from_surfaces import SurfaceSubspace
from harmonicface.recognition.estimators.projection import orthonormal
from harmonicface.recognition.models import ambient4, linear3
from harmonicface.surfaces.surface import Surface


class Linear3(SurfaceSubspace):
    """Nearest span of the three components of albedo times normal (Shashua 1997; Belhumeur & Kriegman 1998).

    Without lights, a person's span is that of the three principal directions of her photographs, about 0; then any
    table will do. With lights, photometric stereo finds it and leaves shadows out.

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = {name: hf.synthetic_person(seed, size=32) for name, seed in (("ada", 0), ("bob", 1))}
    >>> classifier = Linear3.from_surfaces(list(people), list(people.values()))
    >>> photo = hf.render(people["bob"], hf.lights.directional([0.1, 0.2, 1.0]))
    >>> str(classifier.predict(photo.reshape(1, -1))[0])
    'bob'
    """

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        self._stack([orthonormal(pixels[codes == code], 3) for code in range(len(self.classes_))])

    def _pictures(self, surface: Surface) -> Floats:
        return linear3(surface)


class Ambient4(SurfaceSubspace):
    """Nearest span of the same three pictures and the albedo, for ambient light (Koenderink & van Doorn 1997).

    Without lights, a person's span is that of the four principal directions of her photographs, about 0.
    """

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        self._stack([orthonormal(pixels[codes == code], 4) for code in range(len(self.classes_))])

    def _pictures(self, surface: Surface) -> Floats:
        return ambient4(surface)
