"""The stability table: what was planned is what is run, and no row is wrong."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from harmonicface.appearance.principal import analytic_pca
from harmonicface.appearance.principal_components import PrincipalComponents
from harmonicface.bench.stability import principal, search, transports
from harmonicface.bench.stability.plan import FAMILIES, plan
from harmonicface.bench.stability.row import CONSTANT, Measured, Outcome, Planned, Refused, rounded, unit, verdict_of
from harmonicface.bench.stability.runner import SOLVED_BY, outcome, outcomes, stability_records, summary
from harmonicface.errors import HarmonicFaceError

ARITHMETIC = [family for family in FAMILIES if family != "photographs"]  # those are in test_stability_photographs
WELL, ILL = Planned("solver", "case", "well"), Planned("solver", "case", "ill")


def test_the_plan_is_large_and_says_nothing_twice() -> None:
    rows = plan()
    assert len(rows) >= 120
    assert len({(row.solver, row.case) for row in rows}) == len(rows)
    assert sum(row.quick for row in rows) >= 120
    solvers = {row.solver for row in rows}
    assert {
        "real_harmonics", "rotate", "Subspace.distance", "estimate_light", "calibrated_stereo", "linear_factors",
        "leading_factors", "factor_light_field", "integrate_normals", "transport", "analytic_pca", "search", "bound",
    } <= solvers  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES)
def test_what_is_planned_is_what_is_run(family: str) -> None:
    assert set(SOLVED_BY[family]()) == {(row.solver, row.case) for row in FAMILIES[family]}


@pytest.mark.parametrize("family", ARITHMETIC)
def test_no_row_is_wrong_and_none_that_is_well_posed_is_refused(family: str) -> None:
    rows = list(outcomes(family, quick=True))
    assert [(row.planned, row.error, row.allowed, row.note) for row in rows if row.verdict == "wrong"] == []
    assert [row.planned for row in rows if row.verdict == "refused" and row.planned.posed == "well"] == []
    assert all(row.note and "\n" not in row.note for row in rows if row.verdict == "refused")
    # every refusal has to be of an ill-posed row, so that the plan bounds their share
    assert sum(row.planned.posed == "ill" for row in rows) < len(rows) / 2


def test_at_most_a_fifth_of_the_arithmetic_can_be_refused() -> None:
    rows = [row for family in ARITHMETIC for row in FAMILIES[family]]
    assert sum(row.posed == "ill" for row in rows) < len(rows) / 4
    hopeless = {"NaN", "an empty mask", "no albedo"}
    assert all(row.posed == "ill" for row in rows if row.case in hopeless)


def test_one_constant_for_all() -> None:
    assert CONSTANT == 100
    assert rounded(1.0, 1.0, 7.0).allowed == 700 * np.finfo(float).eps
    assert rounded(1.0, 1.0, 7.0, np.float32).allowed == 700 * np.finfo(np.float32).eps


@pytest.mark.parametrize(
    ("found", "expected", "error", "allowed"),
    [
        ([1.0, 2.0], [1.0, 2.0], 0.0, 2.2e-14),
        ([1.0, 2.1], [1.0, 2.0], 0.05, 2.2e-14),
        ([0.0], [0.0], 0.0, 0.0),
        ([1e-300], [0.0], 1e-300, 0.0),
        ([5e-324], [1e-323], 0.5, 50.0),
        ([1.0], [1.0, 2.0], np.inf, 0.0),
        ([np.nan], [1.0], np.nan, 2.2e-14),
    ],
)
def test_errors(found: list[float], expected: list[float], error: float, allowed: float) -> None:
    measured = rounded(found, expected)
    assert measured.error == pytest.approx(error, nan_ok=True)
    assert measured.allowed == pytest.approx(allowed, rel=0.02)


def test_neighbouring_numbers_are_farther_apart_at_the_end_of_the_range() -> None:
    assert unit(1.0) == np.spacing(1.0)
    assert unit(1e-320) == pytest.approx(np.spacing(1e-320) / 1e-320)
    assert unit(1e-40, np.float32) == pytest.approx(float(np.spacing(np.float32(1e-40))) / 1e-40)


@pytest.mark.parametrize(
    ("error", "allowed", "posed", "expected"),
    [
        (0.0, 0.0, "well", "right"),
        (2.0, 1.0, "well", "wrong"),
        (np.nan, 1.0, "ill", "wrong"),
        (1.0, np.inf, "well", "wrong"),
        (0.0, 1.0, "well", "wrong"),  # any answer would do
        (0.0, 1.0, "ill", "right"),
        (1.0, np.inf, "ill", "right"),
    ],
)
def test_verdicts(error: float, allowed: float, posed: str, expected: str) -> None:
    assert verdict_of(error, allowed, posed) == expected  # type: ignore[arg-type]


def fails(error: Exception) -> Measured:
    raise error


def warns() -> Measured:
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)
    return Measured(0.0, 1.0)


def test_exceptions_warnings_and_understatements_are_wrong() -> None:
    refused = outcome(ILL, lambda: fails(HarmonicFaceError("mask: expected more")))
    assert (refused.verdict, refused.note, refused.error) == ("refused", "mask: expected more", None)
    assert outcome(ILL, lambda: Refused("gain: infinite")).verdict == "refused"
    crashed = outcome(ILL, lambda: fails(ValueError("boom")))
    assert (crashed.verdict, crashed.note) == ("wrong", "ValueError: boom")
    assert outcome(ILL, warns).verdict == "wrong"
    assert outcome(WELL, lambda: Measured(1e-3, 1e-4, 1e6)).verdict == "wrong"
    assert outcome(WELL, lambda: Measured(1.0, np.inf, np.inf)).verdict == "wrong"
    assert outcome(WELL, lambda: Measured(1.0, np.inf, None)).verdict == "right"  # a standard error that nobody knows


def test_components_that_are_mixed_are_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """Orthonormal pictures with the right variances are not the components if they are turned among each other."""
    cosine, sine = np.cos(0.1), np.sin(0.1)

    def turned(*arguments: object) -> PrincipalComponents:
        found = analytic_pca(*arguments)  # type: ignore[arg-type]
        found.components[:2] = np.array([[cosine, sine], [-sine, cosine]]) @ found.components[:2]
        return found

    ball = Planned("analytic_pca", "a ball", "well")
    assert outcome(ball, principal.of_principal()[ball.solver, ball.case]).verdict == "right"
    monkeypatch.setattr(principal, "analytic_pca", turned)
    assert outcome(ball, principal.of_principal()[ball.solver, ball.case]).verdict == "wrong"


def test_somebody_else_at_the_right_distance_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    real = search.search

    def another(*arguments: object) -> object:
        found = real(*arguments)  # type: ignore[arg-type]
        return replace(found, people=tuple((person + 1) % search.PEOPLE for person in found.people))

    crowd = Planned("search", "a crowd", "well")
    assert outcome(crowd, search.of_search()[crowd.solver, crowd.case]).verdict == "right"
    monkeypatch.setattr(search, "search", another)
    assert outcome(crowd, search.of_search()[crowd.solver, crowd.case]).verdict == "wrong"


def test_transport_without_shadows_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    dent = Planned("transport of a dent", "times 1e-12", "well")
    assert outcome(dent, transports.of_transports()[dent.solver, dent.case]).verdict == "right"
    real = transports.transport
    monkeypatch.setattr(
        transports, "transport", lambda surface, order: real(replace(surface, depth=0 * surface.depth), order)
    )
    assert outcome(dent, transports.of_transports()[dent.solver, dent.case]).verdict == "wrong"


def test_records_and_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    made = [
        Outcome(WELL, "right", 1e-3, 2e-3, 4.0, 0.5, "relative"),
        Outcome(ILL, "refused", None, None, None, 0.5, "why"),
        Outcome(WELL, "right", 0.1, 20.0, 1e15, 0.5, ""),
    ]
    assert made[0].record.note == "allowed 2.0e-03; condition 4.0e+00; relative"
    assert (made[1].record.name, made[1].record.size, made[1].record.error) == (
        "solver: case",
        "refused, ill-posed",
        None,
    )
    assert summary(made) == {
        "rows": 3,
        "right": 2,
        "refused": 1,
        "wrong": 0,
        "refused though well-posed": 0,
        "right without a digit stated": 1,
    }
    monkeypatch.setattr("harmonicface.bench.stability.runner.FAMILIES", {"one": (), "two": ()})
    monkeypatch.setattr("harmonicface.bench.stability.runner.outcomes", lambda family, quick: iter(made))
    rows: list[Outcome] = []
    records = list(stability_records(rows, quick=True))
    assert rows == made + made
    assert [record.name for record in records[-3:]] == ["rows: one", "rows: two", "rows: all"]
    assert records[-1].size == "6 rows" and records[-1].note.startswith("4 right, 2 refused, 0 wrong")
