"""Principal components: fewer dimensions than the nine harmonic images, known without rendering a picture."""

from __future__ import annotations

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.from_surfaces import SurfaceSubspace
from harmonicface.recognition.models import subspace_model
from harmonicface.surfaces.surface import Surface


class Pca5(SurfaceSubspace):
    """Nearest span of five analytic principal components of the pictures under lamps in front (Ramamoorthi 2002).

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = {name: hf.synthetic_person(seed, size=32) for name, seed in (("ada", 0), ("bob", 1))}
    >>> classifier = Pca5.from_surfaces(list(people), list(people.values()))
    >>> photo = hf.render(people["bob"], hf.lights.directional([0.1, 0.2, 1.0]))
    >>> str(classifier.predict(photo.reshape(1, -1))[0]), classifier.rows_.shape
    ('bob', (10, 1024))
    """

    _model = "pca5"

    def _pictures(self, surface: Surface) -> Floats:
        return subspace_model(self._model)(surface)


class Pca3(Pca5):
    """Nearest span of three of them."""

    _model = "pca3"


class PcaAuto(Pca5):
    """Nearest span of as many of them as explain 99 % of the energy, which each person needs a number of her own of."""

    _model = "pca_auto"
