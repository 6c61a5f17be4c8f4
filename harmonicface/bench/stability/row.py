r"""A row of the stability table: what is planned, what a solver made of it, and the verdict.

A row is *right* if its error is within what the solver stated. Of solvers that round, that is

.. math:: \frac{|\hat x - x|}{|x|} \le C \, \kappa \, \varepsilon

with the condition number kappa that the solver reports (the problem's own where it reports none) and the distance
epsilon of neighbouring numbers at |x| in the least exact type that is involved. C is one number for all rows. The
roundings of m equations in n unknowns add up as sqrt(m n) of them do, almost never to more than three times as much
(Higham & Mary, A new approach to probabilistic rounding error analysis, 2019): 3 sqrt(m n) / 2 = 90 of epsilon for
m = 400 and n = 9, and C = 100. Of solvers that state a standard error it is three of these. A row is *refused* if the
solver ended in an error of the package, which gives the reason, or said that nothing is determined. All else is
*wrong*: another exception, a warning, NaN, an error larger than stated, a condition less than half of the true one, or
one that leaves not a digit where the plan says that the problem is well-posed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from harmonicface.bench.measure import Record

CONSTANT = 100.0
SURE = 3.0  # standard errors
NO_DIGIT = 1.0  # relative: any number is as good
UNDERSTATED = 2.0  # how many times too small a condition may be said to be
SCALES = ("times 1e-12", "times 1e+12")
Verdict = Literal["right", "refused", "wrong"]
Posed = Literal["well", "ill"]


@dataclass(frozen=True)
class Planned:
    """A row as it was written down before it was run.

    Parameters
    ----------
    solver
        The function that is tried.
    case
        The difficulty.
    posed
        "well" if there is one answer, which depends continuously on what is given, and enough digits to tell it; what
        is ill-posed in this sense, or no valid question, may be refused.
    quick
        Whether it takes less than about a second.
    """

    solver: str
    case: str
    posed: Posed
    quick: bool = True


def planned(solver: str, well: Sequence[str] = (), ill: Sequence[str] = (), slow: bool = False) -> tuple[Planned, ...]:
    """Return the rows of one solver."""
    return (
        *(Planned(solver, case, "well", not slow) for case in well),
        *(Planned(solver, case, "ill", not slow) for case in ill),
    )


@dataclass(frozen=True)
class Measured:
    """How far an answer is from the reference, and how far it is allowed to be.

    Parameters
    ----------
    error
        Relative to the reference, or as the note says.
    allowed
        The most that agrees with what the solver reports.
    condition
        The condition number; None where a standard error was stated instead.
    note
        What the error is of, who reported the condition.
    """

    error: float
    allowed: float
    condition: float | None = None
    note: str = ""


@dataclass(frozen=True)
class Refused:
    """A solver that returned, and said that its answer means nothing.

    Parameters
    ----------
    reason
        How it said so.
    """

    reason: str


Rows: TypeAlias = dict[str, Callable[[], Measured | Refused]]
Answers: TypeAlias = dict[tuple[str, str], Callable[[], Measured | Refused]]


def named(solver: str, rows: Rows) -> Answers:
    """Return rows by solver and case, from those of one solver by case."""
    return {(solver, case): row for case, row in rows.items()}


@dataclass(frozen=True)
class Outcome:
    """A row with what came of it.

    Parameters
    ----------
    planned
        The row.
    verdict
        "right", "refused" or "wrong".
    error, allowed, condition
        Of `Measured`; None where there is no answer.
    seconds
        Wall time.
    note
        The reason of a refusal, what was wrong, or what the error is of.
    """

    planned: Planned
    verdict: Verdict
    error: float | None
    allowed: float | None
    condition: float | None
    seconds: float
    note: str

    @property
    def record(self) -> Record:
        """The row as a record: its error in the unit of the note, its time with that of the reference."""
        allowed = "" if self.allowed is None else f"allowed {self.allowed:.1e}"
        condition = "" if self.condition is None else f"condition {self.condition:.1e}"
        note = "; ".join(part for part in (allowed, condition, self.note) if part)
        name = f"{self.planned.solver}: {self.planned.case}"
        return Record(name, f"{self.verdict}, {self.planned.posed}-posed", self.seconds, self.error, note=note)


def verdict_of(error: float, allowed: float, posed: Posed = "well") -> Verdict:
    """Return the verdict on an answer.

    Examples
    --------
    >>> verdict_of(1e-15, 1e-14), verdict_of(1e-3, 1e-14), verdict_of(float("nan"), 1.0)
    ('right', 'wrong', 'wrong')
    >>> verdict_of(0.5, 2.0, "ill"), verdict_of(0.5, 2.0, "well")
    ('right', 'wrong')
    """
    return "right" if error <= allowed and (posed == "ill" or allowed < NO_DIGIT) else "wrong"


def rounded(
    found: ArrayLike,
    expected: ArrayLike,
    condition: float = 1.0,
    dtype: DTypeLike = np.float64,
    note: str = "",
    scale: float | None = None,
) -> Measured:
    """Compare an answer with a reference of higher precision: the largest difference over the largest number.

    Parameters
    ----------
    found
        The answer.
    expected
        The reference, of the same shape.
    condition
        By how much the problem enlarges roundings.
    dtype
        The least exact type that is involved; at the end of its range its numbers are farther apart.
    note
        What the reader has to know.
    scale
        What errors are relative to; by default the largest number of the reference.

    Examples
    --------
    >>> same = rounded([1.0, 2.0], [1.0, 2.0])
    >>> same.error, round(same.allowed / np.finfo(float).eps)
    (0.0, 100)
    """
    right, ours = np.asarray(expected, np.longdouble), np.asarray(found)
    if ours.shape != right.shape:
        return Measured(np.inf, 0.0, condition, f"expected shape {right.shape}, got {ours.shape}")
    size = float(np.abs(right).max(initial=0.0)) if scale is None else scale
    if size == 0:
        return Measured(float(np.abs(ours).max(initial=0.0)), 0.0, condition, f"{note} (of 0, absolute)".lstrip())
    error = float(np.abs(ours - right).max(initial=0.0) / np.longdouble(size))
    return Measured(error, CONSTANT * condition * unit(size, dtype), condition, note)


def if_honest(measured: Measured, true_condition: float) -> Measured:
    """Return what was measured, with an infinite error if the condition is said to be less than half of what it is.

    Examples
    --------
    >>> if_honest(Measured(1e-15, 1e-14, 3.0), 5.0).error, if_honest(Measured(1e-15, 1e-14, 2.0), 5.0).error
    (1e-15, inf)
    """
    if measured.condition is None or measured.condition >= true_condition / UNDERSTATED:
        return measured
    said = f"condition said to be {measured.condition:.1e}, and it is {true_condition:.1e}"
    return Measured(np.inf, measured.allowed, measured.condition, said)


def unit(size: float, dtype: DTypeLike = np.float64) -> float:
    """Return the distance of neighbouring numbers of a type at a size, relative to it.

    Examples
    --------
    >>> unit(1.0), unit(5e-324)
    (2.220446049250313e-16, 1.0)
    """
    about: Any = np.finfo(dtype)
    return max(float(about.eps), float(np.longdouble(about.smallest_subnormal) / np.longdouble(size)))
