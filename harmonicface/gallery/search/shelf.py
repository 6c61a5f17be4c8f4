"""Shelf: some of a gallery's people, or all, where they are in files, ready to be searched."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.layout import ROWS
from harmonicface.gallery.disk.section import Section
from harmonicface.gallery.search.cascade import FURTHEST, Found, search, search_many
from harmonicface.gallery.search.crowd import Company
from harmonicface.gallery.search.limit import Limit
from harmonicface.gallery.search.packing import companies_of
from harmonicface.gallery.search.pixels import SINGLE, Pixels
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import ORTHONORMAL
from harmonicface.store.part import Part

Indices = NDArray[np.intp]
Units = NDArray[np.float64]


class Shelf:
    """People of some shards, ready to be searched; whom it finds are places in the whole gallery.

    What the first stage of a search reads of people with a sketch is copied into memory; everything else is read in
    the files when it is asked for. People without a sketch are scanned. One machine has one shelf of everybody; of
    several machines each has one of its own people, and the answers are `merged`.

    Parameters
    ----------
    sections
        Who is on it, in the order of enrolment.
    basis
        That of the sketches; None where nobody is sketched, or to scan everybody.
    stops
        How many rows of it each stage of the sketches has seen.

    Raises
    ------
    HarmonicFaceError
        A damaged shard; sketches, rows or a basis that do not fit each other.
    """

    def __init__(
        self, sections: Sequence[Section], basis: SharedBasis | None = None, stops: Sequence[int] = ()
    ) -> None:
        self.sections = tuple(section for section in sections if len(section))
        self._firsts = np.cumsum([0, *(len(section) for section in self.sections)])
        self.places = _joined([section.first_place + np.arange(len(section)) for section in self.sections])
        self._basis = basis
        sketched = [np.zeros(0, np.bool_), *(section.sketched for section in self.sections)]
        self._sketched = np.concatenate(sketched) & (basis is not None)
        self._defects = np.concatenate([np.zeros(0), *(section.defects() for section in self.sections)])
        if basis is not None and self.sections and basis.rows.shape[1] != self.sections[0].pixels:
            expected = f"a basis of {self.sections[0].pixels} pixels"
            raise HarmonicFaceError(f"basis: expected {expected}, got one of {basis.rows.shape[1]}")
        self._companies: tuple[Company, ...] = ()
        if self._sketched.any():
            pairs = zip(self.sections, self._firsts.tolist(), strict=False)
            self._companies = companies_of([section.pack(first) for section, first in pairs], stops)

    @classmethod
    def of_parts(
        cls,
        parts: Sequence[Part],
        first_places: Sequence[int],
        basis: SharedBasis | None = None,
        stops: Sequence[int] = (),
    ) -> Shelf:
        """Return a shelf of everybody in some shards.

        Parameters
        ----------
        parts
            Of one version of a gallery.
        first_places
            The place in the order of enrolment of the first person of each.
        basis, stops
            As of `Shelf`.

        Raises
        ------
        HarmonicFaceError
            As `Shelf`.
        """
        pairs = zip(parts, first_places, strict=True)
        return cls([Section(part, np.asarray(part.indices, np.intp), first) for part, first in pairs], basis, stops)

    def __len__(self) -> int:
        return int(self._firsts[-1])

    @property
    def nbytes(self) -> int:
        """Bytes that were copied into memory."""
        return sum(company.nbytes for company in self._companies) + self.places.nbytes + self._defects.nbytes

    def search(self, unit: Units, top: int | None = 1, distance: float = FURTHEST) -> Found:
        """Find the people nearest to a photograph: the answer of a scan of everybody.

        Parameters
        ----------
        unit
            (p,) pixels of a photograph, of unit length.
        top
            How many at most; None for all within the distance.
        distance
            Nobody farther than this, 0 to 1.
        """
        found = NOBODY
        if self._companies and self._basis is not None:
            found = search(self._companies, self._pixels, self._basis, unit, top, distance)
        return self._completed([found], unit[None], top, distance)[0]

    def search_many(self, units: Units, top: int | None = 1, distance: float = FURTHEST) -> list[Found]:
        """Find the people nearest to each of several photographs, (q, p): the answers of `search`."""
        found = [NOBODY] * len(units)
        if self._companies and self._basis is not None and len(units):
            found = search_many(self._companies, self._pixels, self._basis, units, top, distance)
        return self._completed(found, units, top, distance)

    def closeness(self, units: Units) -> NDArray[np.float32]:
        """Return |Q y|^2 of everybody for unit photographs, (n, q) from (q, p), by one pass over all rows.

        Raises
        ------
        HarmonicFaceError
            Rows with NaN or infinity.
        """
        result = np.empty((len(self), len(units)), np.float32)
        single = units.astype(np.float32)
        for section, first in zip(self.sections, self._firsts, strict=False):
            for some, found in section.closeness(single):
                result[first + some.start : first + some.start + len(found)] = found
        return result

    def rows(self, number: int) -> NDArray[np.floating]:
        """Return the rows of the person at a place of the shelf, as they are stored; raises as `Section.rows`."""
        place = int(np.searchsorted(self._firsts, number, side="right")) - 1
        return self.sections[place].rows(number - int(self._firsts[place]))

    def forget(self) -> None:
        """Give the memory of what was read of the files back to the system."""
        for section in self.sections:
            section.part.shard.forget()

    @property
    def _pixels(self) -> Pixels:
        """Everybody's rows, by their places on the shelf."""
        return Pixels(self.rows, self._defects, self.sections[0].pixels)

    def _completed(self, found: Sequence[Found], units: Units, top: int | None, distance: float) -> list[Found]:
        """Add those who have no sketch, and tell places in the gallery."""
        scanned = np.flatnonzero(~self._sketched)
        if len(scanned) and len(units):
            others = self._scanned(scanned, found, units, top, distance)
            found = [merged(both, top) for both in zip(found, others, strict=True)]
        return [
            Found(tuple(self.places[list(one.people)].tolist()), one.distances, one.survivors, one.measured)
            for one in found
        ]

    def _scanned(
        self, scanned: Indices, found: Sequence[Found], units: Units, top: int | None, distance: float
    ) -> list[Found]:
        """Search people without a sketch by one pass over their rows."""
        self._measure_defects(scanned)
        pixels, answers = self._pixels, []
        ranks = [np.diff(section.starts(ROWS))[section.indices] for section in self.sections]
        rank = np.concatenate(ranks)[scanned]
        # as of `Pixels.closeness`
        operations = (pixels.size + 2) * SINGLE
        rounding = 1.01 * operations / (1 - operations) * np.sqrt(rank) if operations < 1 else np.inf
        lengths = np.sqrt(self.closeness(units)[scanned].astype(np.float64)) + np.asarray(rounding)[..., None]
        bounds = np.square(lengths) / (1 - self._defects[scanned, None]) * (1 + 4 * (rank[:, None] + 4) * SINGLE)
        for number, (unit, one) in enumerate(zip(units, found, strict=True)):
            furthest = one.distances[-1] if top is not None and len(one.people) == top else distance
            limit = Limit(top, furthest, lambda who: pixels.distance(who, unit), pixels.size, int(rank.max()))  # noqa: B023
            for index in np.argsort(-bounds[:, number], kind="stable"):
                if bounds[index, number] < limit.closeness:
                    break
                limit.measure(int(scanned[index]))
            answer = limit.answer()
            people, distances = tuple(who for _, who in answer), tuple(far for far, _ in answer)
            answers.append(Found(people, distances, (len(limit.measured),), len(limit.measured)))
        return answers

    def _measure_defects(self, scanned: Indices) -> None:
        """Measure once how orthonormal the rows are of those for whom no sketch tells."""
        for number in scanned[np.isnan(self._defects[scanned])].tolist():
            rows = self.rows(number).astype(np.float64)
            defect = float(np.linalg.norm(rows @ rows.T - np.eye(len(rows)))) + rows.size * 2.0**-53
            if not defect <= ORTHONORMAL:
                place = int(np.searchsorted(self._firsts, number, side="right")) - 1
                name = self.sections[place].name(number - int(self._firsts[place]))
                raise HarmonicFaceError(
                    f"{name!r:.80}: expected orthonormal rows, got some that are not, by {defect:.2g}"
                )
            self._defects[number] = defect


NOBODY = Found((), (), (), 0)


def merged(answers: Sequence[Found], top: int | None) -> Found:
    """Return the answer of a whole gallery from those of its shelves.

    Parameters
    ----------
    answers
        To the same question, of shelves that have nobody in common.
    top
        How many people were asked for.

    Examples
    --------
    >>> merged([Found((7,), (0.2,), (3, 1), 2), Found((4,), (0.1,), (2,), 2)], 1)
    Found(people=(4,), distances=(0.1,), survivors=(5, 3), measured=4)
    """
    together = sorted(pair for one in answers for pair in zip(one.distances, one.people, strict=True))[:top]
    stages = max((len(one.survivors) for one in answers), default=0)
    counts = [one.survivors + one.survivors[-1:] * (stages - len(one.survivors)) for one in answers if one.survivors]
    survivors = tuple(sum(stage) for stage in zip(*counts, strict=True))
    people, distances = tuple(who for _, who in together), tuple(distance for distance, _ in together)
    return Found(people, distances, survivors, sum(one.measured for one in answers))


def _joined(arrays: Sequence[Indices]) -> Indices:
    """Return arrays one behind the other, also if there are none."""
    return np.concatenate([np.zeros(0, np.intp), *arrays])
