"""What a gallery answers."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.looks.explanation import Evidence, Explanation
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.placement import Placement

INTENSITIES, PATTERNS = "intensities", "patterns"  # what is compared


@dataclass(frozen=True)
class Candidate:
    """A person and how far the photograph is from her pictures.

    Parameters
    ----------
    name
        Who she is.
    distance
        0 to 1, in the match's domain.
    score
        What the default model ranks by: by how many deviations the photograph is more like her than like strangers.
        None for a model that ranks by distance, and for who did not come into the shortlist.
    shift
        Pixels of the photograph to the right and down by which it shows her displaced.
    source
        What she was enrolled from: "surface", "lit photographs", "photographs" (of unknown lights), "photograph".
    """

    name: str
    distance: float
    score: float | None = None
    shift: tuple[float, float] = (0.0, 0.0)
    source: str = ""


@dataclass(frozen=True)
class Search:
    """How many people stage one excluded on the way to its answer, which is that of a scan of everybody.

    Parameters
    ----------
    people
        How many there were.
    survivors
        How many of them no bound had excluded after each stage; empty where everybody was scanned.
    measured
        Of how many the exact distance was computed.
    """

    people: int
    survivors: tuple[int, ...]
    measured: int


@dataclass(frozen=True)
class Match:
    """Whose photograph it is, as far as the gallery can tell.

    Parameters
    ----------
    name
        The first candidate, or None for somebody unknown (see `Gallery`).
    distance
        Of the first candidate, 0 to 1. In the domain "intensities": the sine of the angle between the photograph and
        her subspace, on linear intensities over the gallery's pixels; its square is the share of the photograph's
        energy that she does not explain. In the domain "patterns": 1 minus the mean correlation of 12 x 12 blocks of
        local patterns, of the photograph and of her picture under its light; strangers are at about 0.8.
    margin
        Distance of the second candidate over that of the first; 1 in a gallery of one.
    light
        The light that explains the photograph as one of the first candidate; None when she was enrolled from
        photographs whose lights are unknown, and for a photograph without light.
    candidates
        The first people, best first.
    domain
        What is compared: "intensities", or "patterns" (the default model).
    reason
        Why nobody is named; None if somebody is.
    search
        Of how many people stage one read how much; only where `match` was asked to explain.
    evidence
        The photograph and the first candidate's pictures, for `explain`.
    """

    name: str | None
    distance: float
    margin: float
    light: HarmonicLight | None
    candidates: tuple[Candidate, ...]
    domain: str = INTENSITIES
    reason: str | None = None
    search: Search | None = field(default=None, compare=False)
    evidence: Evidence | None = field(default=None, repr=False, compare=False)

    def explain(self) -> Explanation:
        """Return what the first candidate accounts for in the photograph, what is left out, and why.

        It is computed when first asked for, by a fit that leaves out what hides her (`robust_fit`), and takes longer
        than a match with few people.

        Raises
        ------
        HarmonicFaceError
            A match that was not made by a gallery; photographs of fewer than 24 pixels a side.
        """
        return self._explanation

    @cached_property
    def motion(self) -> Placement | None:
        """How the photograph shows whom it names displaced (in its pixels), turned and grown.

        It is computed when first asked for. A shift of a few tenths, a turn of 0.3 degrees or a growth of 0.5 % may be
        none. None where nobody is named, and for models that compare intensities.
        """
        if self.name is None or self.evidence is None or self.evidence.where is None:
            return None
        return self.evidence.where.placement()

    @property
    def left_out(self) -> NDArray[np.bool_]:
        """The pixels of the photograph that the explanation leaves out, (h, w); see `explain`."""
        return self._explanation.left_out

    @cached_property
    def _explanation(self) -> Explanation:
        if self.evidence is None:
            raise HarmonicFaceError("explain: expected a match that a gallery made, got one made by hand")
        return self.evidence.explanation(self.motion)

    @property
    def source(self) -> str:
        """What the first candidate was enrolled from."""
        return self.candidates[0].source


@dataclass(frozen=True, eq=False)
class SearchScores:
    """What a search of the whole gallery finds, before anything is decided.

    Parameters
    ----------
    names
        Everybody, in the order of enrolment.
    scores
        (n,) larger is more alike: for the default model deviations above strangers, for the others minus the distance.
    distances
        (n,) 0 to 1, as in `Match`.
    shifts
        (n, 2) pixels of the photograph to the right and down by which it shows each person displaced.
    blocks
        Of how many 12 x 12 blocks the photograph has a pattern; None for the other models.
    """

    names: tuple[str, ...]
    scores: NDArray[np.float64]
    distances: NDArray[np.float64]
    shifts: NDArray[np.float64]
    blocks: int | None = None
