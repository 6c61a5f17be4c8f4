"""The runner: every planned row is run, nothing that was not planned is, and exceptions and warnings count."""

from __future__ import annotations

import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from harmonicface.bench.measure import Record
from harmonicface.bench.stability import (
    factorization,
    harmonics,
    horizons,
    integration,
    inverse_light,
    photographs,
    photometric,
    principal,
    projection,
    search,
    surfaces,
    transports,
)
from harmonicface.bench.stability.plan import FAMILIES
from harmonicface.bench.stability.row import Answers, Measured, Outcome, Planned, Refused, verdict_of
from harmonicface.errors import HarmonicFaceError

SOLVED_BY: dict[str, Callable[[], Answers]] = {
    "harmonics": harmonics.of_harmonics,
    "rotation": harmonics.of_rotations,
    "projection": projection.of_projection,
    "inverse light": inverse_light.of_inverse_light,
    "stereo under known lights": photometric.of_known_lights,
    "stereo under unknown lights": photometric.of_unknown_lights,
    "factorization of photographs": factorization.of_photographs,
    "factorization of light fields": factorization.of_light_fields,
    "integration": integration.of_integration,
    "surfaces and transport": lambda: {
        **surfaces.of_surfaces(),
        **transports.of_transports(),
        **horizons.of_horizons(),
    },
    "analytic principal components": principal.of_principal,
    "search": search.of_search,
    "photographs": photographs.of_photographs,
}


def outcomes(family: str, *, quick: bool = False) -> Iterator[Outcome]:
    """Run the rows of a family and yield what came of each.

    Parameters
    ----------
    family
        One of `FAMILIES`.
    quick
        Without the rows that take long.

    Examples
    --------
    >>> next(outcomes("rotation")).verdict
    'right'
    """
    solved = SOLVED_BY[family]()
    for planned in FAMILIES[family]:
        if planned.quick or not quick:
            yield outcome(planned, solved[planned.solver, planned.case])


def stability_records(rows: list[Outcome], *, quick: bool = False) -> Iterator[Record]:
    """Run everything; yield a record of each row, then the counts of each family and of all.

    Parameters
    ----------
    rows
        Is filled with what came of the rows.
    quick
        Without the rows that take long.
    """
    counts = []
    for family in FAMILIES:
        start = len(rows)
        for row in outcomes(family, quick=quick):
            rows.append(row)
            yield row.record
        counts.append(_counted(family, rows[start:]))
    yield from counts
    yield _counted("all", rows)


def _counted(what: str, rows: Sequence[Outcome]) -> Record:
    """Return a record of how many rows have which verdict."""
    said = ", ".join(f"{number} {name}" for name, number in summary(rows).items() if name != "rows")
    return Record(f"rows: {what}", f"{len(rows)} rows", sum(row.seconds for row in rows), note=said)


def outcome(planned: Planned, answer: Callable[[], Measured | Refused]) -> Outcome:
    """Run one row."""
    start = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = answer()
    except HarmonicFaceError as error:
        found = Refused(str(error))
    except Exception as error:  # whatever it is, the solver did not say what is wrong with its input
        seconds = time.perf_counter() - start
        return Outcome(planned, "wrong", None, None, None, seconds, f"{type(error).__name__}: {error}")
    seconds = time.perf_counter() - start
    if isinstance(found, Refused):
        return Outcome(planned, "refused", None, None, None, seconds, found.reason)
    # a condition may not leave no digit where the problem is well-posed; that a standard error is unknown may be true
    strict = planned.posed if found.condition is not None else "ill"
    verdict = verdict_of(found.error, found.allowed, strict)
    return Outcome(planned, verdict, found.error, found.allowed, found.condition, seconds, found.note)


def summary(rows: Sequence[Outcome]) -> dict[str, int]:
    """Count the verdicts, the well-posed rows that were refused, and answers of which no digit was stated."""
    counts = Counter(row.verdict for row in rows)
    return {
        "rows": len(rows),
        "right": counts["right"],
        "refused": counts["refused"],
        "wrong": counts["wrong"],
        "refused though well-posed": sum(row.verdict == "refused" and row.planned.posed == "well" for row in rows),
        "right without a digit stated": sum(
            row.verdict == "right" and row.condition is not None and row.allowed is not None and row.allowed >= 1
            for row in rows
        ),
    }
