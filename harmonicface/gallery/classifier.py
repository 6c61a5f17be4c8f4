"""A gallery as a scikit-learn classifier, so that ours stands in a table beside the methods of the literature."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.storage import DEFAULT_MODEL
from harmonicface.gallery.gallery import Gallery
from harmonicface.recognition.estimators.base import Codes, FaceClassifier
from harmonicface.recognition.estimators.image_table import as_images


class GalleryClassifier(FaceClassifier):
    """The people of a `Gallery`, each enrolled from her photographs; every photograph gets the first candidate's name.

    A classifier answers with one of the classes: whom the gallery would call unknown, it names all the same. The
    distance is minus the score of `Gallery.search_scores`.

    Parameters
    ----------
    image_shape
        (h, w) of the photographs, which are the rows of a table, at least 24 pixels a side for the default model.
    model
        As of `Gallery`.

    Attributes
    ----------
    gallery_
        The gallery; its people are called "0", "1", ... in the order of `classes_`.

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = [hf.synthetic_person(seed, size=48) for seed in (0, 1)]
    >>> known = [hf.render(person, hf.lights.natural(3)).ravel() for person in people]
    >>> classifier = GalleryClassifier((48, 48)).fit(known, ["ada", "bob"])
    >>> str(classifier.predict([hf.render(people[1], hf.lights.natural(4)).ravel()])[0])
    'bob'
    """

    def __init__(self, image_shape: tuple[int, int] | None = None, model: str = DEFAULT_MODEL) -> None:
        self.image_shape = image_shape
        self.model = model

    def fit(self, X: ArrayLike, y: ArrayLike, lights: ArrayLike | None = None) -> Self:
        """Enrol everybody from her photographs.

        Parameters
        ----------
        X
            (n, h * w) linear grey intensities, one photograph a row.
        y
            (n,) who is in each.
        lights
            (n, 3) directions to the light of each times its brightness, as of `Gallery.enroll`; unknown by default.
            In a pipeline or a search they are routed here after `set_fit_request(lights=True)`.

        Raises
        ------
        HarmonicFaceError
            Tables of other shapes, NaN, no `image_shape`, lights of another number, what `Gallery.enroll` refuses.
        """
        pixels, codes = self._training(X, y)
        towards = None if lights is None else np.asarray(lights, np.float64)
        if towards is not None and towards.shape != (len(pixels), 3):
            raise HarmonicFaceError(f"lights: expected shape ({len(pixels)}, 3), got {towards.shape}")
        self._enrol(as_images(pixels, self.image_shape), codes, towards)
        return self

    def _enrol(self, images: Floats, codes: Codes, lights: Floats | None) -> None:
        """Enrol each class."""
        self.gallery_ = Gallery(self.model)
        for code in range(len(self.classes_)):
            hers = codes == code
            source = images[hers][0] if hers.sum() == 1 and lights is None else images[hers]
            self.gallery_.enroll(str(code), source, None if lights is None else lights[hers])

    def _distances(self, pixels: Floats) -> Floats:
        return np.stack([-self.gallery_.search_scores(photo).scores for photo in as_images(pixels, self.image_shape)])
