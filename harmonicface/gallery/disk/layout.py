"""Layout: how a gallery lies in a folder of named arrays, and what must hold of what is read from it.

A person is an entry by her name: `rows` (r, p) float32 or float16; `to_coefficients` float64, the (r, k) matrix one row
after the other; of the default model a `template` (1, h, w) float16; and the arrays of `search.packing` once there is
a shared basis. Of the folder are `mask` (h, w) and that `basis` (m, p) float64, and words about the gallery: `About`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.enrolment import SOURCES, Enrolment
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.names import checked_name
from harmonicface.gallery.rule import Rule
from harmonicface.gallery.search.index import Index
from harmonicface.gallery.search.packing import packed, sketch_kinds
from harmonicface.recognition.grid import grid
from harmonicface.recognition.patterns import SCALES, Template
from harmonicface.recognition.subspace import Subspace
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.version import Version

FORMAT, VERSION = "harmonicface gallery", "4"
DTYPES = ("float32", "float16")
TOGETHER = 64  # people who are sketched at once
ROWS, COEFFICIENTS, TEMPLATE, MASK, BASIS = "rows", "to_coefficients", "template", "mask", "basis"
# How far |q_k| of stored rows may be from 1, and their products from 0: float16 errs by half a unit of 2^-10 in each
# number, so by less than 2^-10 in a product of two rows; float32 rows are rounded from float64.
ORTHONORMAL = {"float32": 1e-5, "float16": 1.1e-3}


@dataclass(frozen=True)
class About:
    """What a folder says of its gallery.

    Parameters
    ----------
    model, threshold, margin, shortlist
        As of `Gallery`; a margin of None is infinite.
    dtype
        Of the rows, one of `DTYPES`.
    stops
        How many rows of the shared basis each stage of a search sees; empty as long as there is none.
    sample
        From how many people it was learned.
    """

    model: str
    threshold: float
    margin: float | None
    shortlist: int
    dtype: str = DTYPES[0]
    stops: tuple[int, ...] = ()
    sample: int = 0

    @classmethod
    def of(cls, rule: Rule, dtype: str = DTYPES[0]) -> About:
        """Describe a gallery without a shared basis."""
        margin = None if rule.margin == np.inf else rule.margin
        return cls(rule.model, rule.threshold, margin, rule.shortlist, dtype)

    @classmethod
    def read(cls, version: Version, path: str) -> About:
        """Return what a folder says, checked.

        Raises
        ------
        HarmonicFaceError
            No gallery, one of another version, or one that contradicts itself.
        """
        said = version.about
        if said.get("format") != FORMAT:
            raise HarmonicFaceError(f"{path:.300}: expected a {FORMAT}, got a folder of {said.get('format')!r:.80}")
        if said.get("version") != VERSION:
            expected, got = f"version {VERSION} of the gallery format in a folder", said.get("version")
            raise HarmonicFaceError(f"{path:.300}: expected {expected}, got {got!r:.40}")
        try:
            about = cls(**{name: said[name] for name in cls.__dataclass_fields__})
            about = cls(**{**asdict(about), "stops": tuple(about.stops)})
            about.rule()
            about._check(version)
        except (KeyError, TypeError, ValueError, AttributeError):
            expected = "a gallery that agrees with itself"
            raise HarmonicFaceError(f"{path:.300}: expected {expected}, got one that does not") from None
        return about

    def rule(self) -> Rule:
        """Return when somebody is named."""
        return Rule(self.model, self.threshold, np.inf if self.margin is None else self.margin, self.shortlist)

    def words(self) -> dict[str, Any]:
        """Return what is kept."""
        return {"format": FORMAT, "version": VERSION, **asdict(self), "stops": list(self.stops)}

    def kinds(self, frame: Frame) -> dict[str, Kind]:
        """Return what the arrays of a person are."""
        kinds = {
            ROWS: Kind(np.dtype(self.dtype), (frame.pixels,)),
            COEFFICIENTS: Kind(np.dtype(np.float64)),
        }
        if self.rule().by_score:
            kinds[TEMPLATE] = Kind(np.dtype(np.float16), grid(frame.shape))
        if self.stops:
            kinds |= {name: Kind(*kind) for name, kind in sketch_kinds(self.stops).items()}
        return kinds

    def _check(self, version: Version) -> None:
        """Refuse what the arrays contradict, by their headers alone; what they hold is looked at when it is read."""
        mask, stops = version.common[MASK], list(self.stops)
        agrees = (
            self.dtype in DTYPES
            and all(type(stop) is int and stop > 0 for stop in stops)
            and stops == sorted(set(stops))
            and type(self.sample) is int
            and self.sample >= 0
            and set(version.common) == ({MASK, BASIS} if stops else {MASK})
            and version.kinds == self.kinds(Frame.of(mask))
        )
        if agrees and stops:
            basis = version.common[BASIS]
            agrees = basis.dtype == np.float64 and basis.ndim == 2 and basis.shape[1] == mask.sum()
            agrees = agrees and basis.shape[0] == stops[-1]
        if not agrees:
            raise ValueError("the parts of the gallery contradict each other")


def entries_of(people: Iterable[tuple[str, Enrolment]], dtype: str, index: Index | None) -> Iterator[Entry]:
    """Yield people as they are kept.

    Parameters
    ----------
    people
        Names and what stands for each.
    dtype
        Of the gallery's rows.
    index
        In which everybody is sketched, by the rows as kept; None in a gallery without a shared basis.
    """
    left = iter(people)
    while some := list(islice(left, TOGETHER)):
        rows = [kept_rows(enrolled.subspace, dtype) for _, enrolled in some]
        sketched = [{} for _ in some] if index is None else [packed(one) for one in index.sketches(rows)]
        for (name, enrolled), hers, arrays in zip(some, rows, sketched, strict=True):
            arrays |= {ROWS: hers, COEFFICIENTS: enrolled.subspace.to_coefficients.reshape(-1)}
            if enrolled.template is not None:
                arrays[TEMPLATE] = enrolled.template.values[None]
            yield Entry(name, arrays, {"source": enrolled.source})


def kept_rows(subspace: Subspace, dtype: str) -> NDArray[np.floating[Any]]:
    """Return rows as they are kept; distances are those of the rows as kept."""
    return subspace.rows.astype(dtype, copy=False)


def enrolled_from(entry: Entry, frame: Frame, by_score: bool) -> Enrolment:
    """Return what stands for a person, checked.

    Raises
    ------
    HarmonicFaceError
        Rows that are not orthonormal, or of which there are none; coefficients that do not fit them; a template that
        is none; another source or name than people have.
    """
    rows, coefficients = entry.arrays[ROWS], entry.arrays[COEFFICIENTS]
    source = entry.about.get("source")
    checked_name(entry.key)
    _demand(source in SOURCES, entry.key, f"a source of {', '.join(SOURCES)}", f"{source!r:.40}")
    check_rows(rows, entry.key)
    fits = len(coefficients) > 0 and len(coefficients) % len(rows) == 0
    _demand(fits, entry.key, f"coefficients for each of {len(rows)} rows", f"{len(coefficients)} numbers")
    subspace = Subspace(np.asarray(rows, np.float32), coefficients.reshape(len(rows), -1))
    template = None
    if by_score:
        values = entry.arrays[TEMPLATE]
        seen = len(values) == 1 and bool((np.abs(values) <= len(SCALES)).all())
        _demand(seen, entry.key, "a template of patterns", "what is none")
        template = Template(values[0])
    return Enrolment(subspace, frame, str(source), template)


def check_rows(rows: NDArray[np.floating[Any]], name: str) -> float:
    """Refuse rows that are not orthonormal as far as their type can tell, NaN among them; return |Q Q^T - I|."""
    _demand(0 < len(rows) <= rows.shape[1], name, f"1 to {rows.shape[1]} rows", f"{len(rows)}")
    single = np.asarray(rows, np.float32)
    off = single @ single.T - np.eye(len(rows), dtype=np.float32)
    worst = float(np.abs(off).max())
    _demand(worst <= ORTHONORMAL[str(rows.dtype)], name, "orthonormal rows", f"some that are not, by {worst:.2g}")
    return float(np.linalg.norm(off))


def _demand(holds: bool, name: str, expected: str, got: str) -> None:
    """Refuse a person."""
    if not holds:
        raise HarmonicFaceError(f"{ascii(name)!s:.80}: expected {expected}, got {got}")
