"""What a gallery answers."""

from __future__ import annotations

from dataclasses import dataclass

from harmonicface.lighting.light import HarmonicLight


@dataclass(frozen=True)
class Candidate:
    """A person and how far the photograph is from her pictures."""

    name: str
    distance: float


@dataclass(frozen=True)
class Match:
    """Whose photograph it is, as far as the gallery can tell.

    Parameters
    ----------
    name
        The nearest person, or None for somebody unknown: when she is farther than the gallery's threshold and the
        next person is nearly as near (see `Gallery`).
    distance
        Of the nearest person: the sine of the angle between the photograph and her subspace, 0 to 1, on linear
        intensities over the gallery's pixels. Its square is the share of the photograph's energy that she does not
        explain.
    margin
        Distance of the second nearest person over that of the nearest, at least 1; 1 in a gallery of one.
    light
        The light that explains the photograph as one of the nearest person; None when she was enrolled from
        photographs, whose lights are unknown.
    candidates
        The nearest people, nearest first.
    """

    name: str | None
    distance: float
    margin: float
    light: HarmonicLight | None
    candidates: tuple[Candidate, ...]
