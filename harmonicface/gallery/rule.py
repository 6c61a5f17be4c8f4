"""Rule: the model of a gallery, and when it names somebody."""

from __future__ import annotations

import numpy as np

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.storage import DEFAULT_MODEL, DEFAULT_SHORTLIST
from harmonicface.recognition.models import SUBSPACE_MODELS

FARTHEST = 0.5  # beyond it a quarter of the photograph's energy is nobody's
DEFAULT_THRESHOLD = 0.1
DEFAULT_SCORE = 6.0
DEFAULT_MARGIN = 4 / 3


class Rule:
    """What a gallery compares and when it names the first candidate; the parameters are those of `Gallery`.

    Raises
    ------
    HarmonicFaceError
        An unknown model, a threshold outside its range, a margin below 1, a shortlist below 2.

    Examples
    --------
    >>> rule = Rule("harmonic9")
    >>> rule.is_known(0.08, 1.0), rule.is_known(0.2, 2.0), rule.is_known(0.2, 1.0)
    (True, True, False)
    """

    def __init__(
        self,
        model: str = DEFAULT_MODEL,
        threshold: float | None = None,
        margin: float = DEFAULT_MARGIN,
        shortlist: int = DEFAULT_SHORTLIST,
    ) -> None:
        if model not in (DEFAULT_MODEL, *SUBSPACE_MODELS):
            expected = f"one of {', '.join((DEFAULT_MODEL, *SUBSPACE_MODELS))}"
            raise HarmonicFaceError(f"model: expected {expected}, got {model!r}")
        self.model = model
        self.threshold = (DEFAULT_SCORE if self.by_score else DEFAULT_THRESHOLD) if threshold is None else threshold
        self.margin = margin
        self.shortlist = _validate.at_least(shortlist, 2, "shortlist")

    @property
    def by_score(self) -> bool:
        """Whether the threshold is a score, larger for more alike, rather than a distance."""
        return self.model == DEFAULT_MODEL

    @property
    def threshold(self) -> float:
        """The score from which the first candidate is named; without patterns, the distance up to which she is."""
        return self._threshold

    @threshold.setter
    def threshold(self, value: float) -> None:
        check = _validate.positive if self.by_score else _validate.fraction
        self._threshold = check(value, "threshold")

    @property
    def margin(self) -> float:
        """The ratio of the second distance to the first from which the nearest person is named."""
        return self._margin

    @margin.setter
    def margin(self, value: float) -> None:
        margin = np.inf if value == np.inf else _validate.positive(value, "margin")
        if margin < 1:
            raise HarmonicFaceError(f"margin: expected a number of at least 1, got {value}")
        self._margin = margin

    @property
    def ambient(self) -> bool:
        """Whether the pictures that stand for a Surface have one for ambient light."""
        return self.model != "linear3"

    def is_known(self, distance: float, margin: float) -> bool:
        """Say whether the nearest person is named: surely near, or clearly nearer than the next."""
        return distance <= self.threshold or (margin >= self.margin and distance <= FARTHEST)
