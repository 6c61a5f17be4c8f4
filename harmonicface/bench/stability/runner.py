"""The runner: every planned row is run, nothing that was not planned is, and exceptions and warnings count."""

from __future__ import annotations

import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from harmonicface.bench.stability import factorization, harmonics, integration, inverse_light, photometric, projection
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
}


def outcomes(families: Iterable[str] | None = None, *, quick: bool = False) -> Iterator[Outcome]:
    """Run the rows of some families, or of all, and yield what came of each.

    Parameters
    ----------
    families
        Names of `FAMILIES`.
    quick
        Without the rows that take long.

    Examples
    --------
    >>> [outcome.verdict for outcome in outcomes(["rotation"])][:3]
    ['right', 'right', 'right']
    """
    for family in FAMILIES if families is None else families:
        solved = SOLVED_BY[family]()
        for planned in FAMILIES[family]:
            if planned.quick or not quick:
                yield outcome(planned, solved[planned.solver, planned.case])


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
    verdict = verdict_of(found.error, found.allowed, planned.posed)
    return Outcome(planned, verdict, found.error, found.allowed, found.condition, seconds, found.note)


def summary(rows: Iterable[Outcome]) -> dict[str, int]:
    """Count the verdicts, and the well-posed rows that were refused."""
    rows = list(rows)
    counts = Counter(row.verdict for row in rows)
    refused = sum(row.verdict == "refused" and row.planned.posed == "well" for row in rows)
    return {
        "rows": len(rows),
        "right": counts["right"],
        "refused": counts["refused"],
        "wrong": counts["wrong"],
        "well-posed and refused": refused,
    }
