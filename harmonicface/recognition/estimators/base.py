"""What the classifiers share: tables checked once, and a distance for every candidate from which all answers come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

T = TypeVar("T")
Codes = NDArray[np.intp]


class FaceClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """A scikit-learn classifier that tells for every photograph how far each person is.

    A subclass learns in `_learn` and compares in `_distances`. Photographs are the rows of a table, float32 or float64
    as they come; anything else becomes float64.

    Attributes
    ----------
    classes_
        (c,) the names, sorted.
    n_features_in_
        How many numbers a photograph has.
    """

    _least_features = 1

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Learn people from their photographs.

        Parameters
        ----------
        X
            (n, p), one photograph a row.
        y
            (n,) who is in each.

        Raises
        ------
        HarmonicFaceError
            Tables of other shapes, NaN, names that are no classes, what the method cannot learn from.
        """
        pixels, codes = self._training(X, y)
        self._learn(pixels, codes)
        return self

    def predict_distances(self, X: ArrayLike) -> Floats:
        """Return how far each photograph is from each person, (n, c), in the order of `classes_`; smaller is nearer.

        Raises
        ------
        HarmonicFaceError
            Another number of features than was learned, NaN.
        """
        check_is_fitted(self)
        return self._distances(_one_line(lambda: self._table(X, reset=False)))

    def decision_function(self, X: ArrayLike) -> Floats:
        """Return minus the distances, (n, c); for two people (n,), above 0 where the second one is nearer."""
        distances = self.predict_distances(X)
        if distances.shape[1] == 2:
            return np.asarray(distances[:, 0] - distances[:, 1])
        return -distances

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """Return the nearest person for each photograph, (n,); the first one of several equally near."""
        nearest = self.predict_distances(X).argmin(axis=1)
        return np.asarray(self.classes_[nearest])

    @property
    def _telling_from_few(self) -> bool:
        """Whether two features are enough to tell classes apart."""
        return False

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        """Learn from checked photographs (n, p), the classes' numbers (n,) beside them."""
        raise NotImplementedError

    def _distances(self, pixels: Floats) -> Floats:
        """Return distances (n, c) of checked photographs (n, p)."""
        raise NotImplementedError

    def _training(self, X: ArrayLike, y: ArrayLike) -> tuple[Floats, Codes]:
        """Check what is learned from; set the classes."""

        def checked() -> tuple[Floats, Codes]:
            pixels, names = self._table(X, y)
            check_classification_targets(names)
            self.classes_, codes = np.unique(names, return_inverse=True)
            return pixels, codes

        return _one_line(checked)

    def _table(self, X: ArrayLike, y: ArrayLike | str | None = "no_validation", reset: bool = True) -> Any:
        """Let scikit-learn check a table, and names where they belong to it."""
        kinds, least = [np.float64, np.float32], self._least_features if reset else 1
        return validate_data(self, X, y, dtype=kinds, ensure_min_features=least, reset=reset)

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.classifier_tags.poor_score = not self._telling_from_few
        return tags


def _one_line(check: Callable[[], T]) -> T:
    """Run a check of scikit-learn, and tell in one line what it tells in several."""
    try:
        return check()
    except ValueError as problem:
        raise HarmonicFaceError(" ".join(str(problem).split())) from problem
