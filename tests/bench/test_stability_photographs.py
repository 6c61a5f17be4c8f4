"""The table of hard photographs: every case is there, and none is answered surely and wrongly."""

from __future__ import annotations

import re

import numpy as np
import pytest

from harmonicface.bench.stability.hard_photographs import hard_cases
from harmonicface.bench.stability.photographs import of_photographs
from harmonicface.bench.stability.plan import PHOTOGRAPHS
from harmonicface.bench.stability.row import Outcome
from harmonicface.bench.stability.runner import outcome
from harmonicface.stereo.photometric_stereo import photometric_stereo

SIDE = 24
# What refusals have to name, of known lamps and of unknown ones.
KNOWN = {
    "two images only": "expected at least 3",
    "all lamps in a plane with the camera": "near one plane",
    "one lamp for all photographs": "near one plane or one another",
    "NaN inside the mask": "finite intensities in the mask",
    "left and right confused in all": "left and right",
    "skies: two images only": "expected at least 3",
    "skies: one for all photographs": "no mixtures of the others",
}
UNKNOWN = {
    "two images only": "expected at least 3",
    "all lamps in a plane with the camera": "in one plane",
    "all lamps within a degree of a plane": "in one plane",
    "one lamp for all photographs": "near one another",
    "lamps within 5 degrees": "near one another",
    "a planar object": "nearly a plane",
    "a mask of 9 pixels": "mask: expected at least",
    "NaN inside the mask": "finite intensities in the mask",
    "constant images": "mixtures of two",
    "black images": "image 0 without",
    "one black image": "image 4 without",
}
# As good as without the difficulty, from known lamps: more must not cost less.
HARMLESS = (
    "all lamps on a cone", "a planar object", "a mask of 9 pixels", "black patches, with noise", "NaN outside the mask",
    "16 bits", "8 bits", "times 1e-12", "times 1e+12", "float32", "one black image", "one image of another scene",
    "one image moved by 1 pixel", "one direction wrong", "lamps of 1 : 100, told", "lamps of 1 : 100, not told",
)  # fmt: skip


@pytest.fixture(scope="module")
def outcomes() -> dict[tuple[str, str], Outcome]:
    """What is done with small photographs under known lamps and, of the quick cases, under unknown ones."""
    quick = {case.name for case in hard_cases(12) if case.quick}
    made = of_photographs(SIDE)
    rows = [row for row in PHOTOGRAPHS if row.solver.endswith("lights known")]
    rows += [row for row in PHOTOGRAPHS if row.solver.endswith("lamps unknown") and row.case in quick]
    return {(row.case, row.solver.split(", ")[1]): outcome(row, made[row.solver, row.case]) for row in rows}


def test_every_case_is_there(outcomes: dict[tuple[str, str], Outcome]) -> None:
    cases = hard_cases(12)
    assert {case.name for case in cases if case.known is not None} == {
        name for name, said in outcomes if said == "lights known"
    }
    assert len(cases) == len({case.name for case in cases}) > 40
    assert sum(said == "lamps unknown" for _, said in outcomes) > 25


def test_nothing_is_answered_surely_and_wrongly(outcomes: dict[tuple[str, str], Outcome]) -> None:
    assert [key for key, outcome in outcomes.items() if outcome.verdict == "wrong"] == []
    refused = [key for key, one in outcomes.items() if one.verdict == "refused" and one.planned.posed == "well"]
    assert refused == []


@pytest.mark.parametrize(("lights", "causes"), [("lights known", KNOWN), ("lamps unknown", UNKNOWN)])
def test_refusals_name_the_cause(outcomes: dict[tuple[str, str], Outcome], lights: str, causes: dict[str, str]) -> None:
    for name, cause in causes.items():
        outcome = outcomes[name, lights]
        assert outcome.verdict == "refused" and "\n" not in outcome.note
        assert re.search(cause, outcome.note), (name, outcome.note)


def test_what_is_refused_of_known_lights_is_what_tells_nothing(outcomes: dict[tuple[str, str], Outcome]) -> None:
    refused = {name for (name, said), one in outcomes.items() if said == "lights known" and one.verdict == "refused"}
    assert refused == set(KNOWN)


@pytest.mark.parametrize("name", HARMLESS)
def test_what_should_do_no_harm_does_none(outcomes: dict[tuple[str, str], Outcome], name: str) -> None:
    outcome = outcomes[name, "lights known"]
    assert on_average(outcome) < 0.6
    assert outcome.allowed is not None and outcome.allowed < 6.05  # three times 2 degrees, and rounding


def on_average(outcome: Outcome) -> float:
    found = re.search(r"([\d.]+) on average", outcome.note)
    assert found is not None, outcome
    return float(found[1])


def test_scale_and_type_change_nothing(outcomes: dict[tuple[str, str], Outcome]) -> None:
    for lights in ("lights known", "lamps unknown"):
        usual = on_average(outcomes["nothing hard", lights])
        known = lights == "lights known"
        for name in ("float32", *(("times 1e-12", "times 1e+12", "NaN outside the mask") if known else ())):
            assert on_average(outcomes[name, lights]) == pytest.approx(usual, abs=0.02)


@pytest.mark.parametrize(
    ("name", "left_out"),
    [("one image of another scene", 7), ("one image moved by 1 pixel", 5), ("one direction wrong", 3)],
)
def test_what_does_not_belong_is_left_out(outcomes: dict[tuple[str, str], Outcome], name: str, left_out: int) -> None:
    assert f"left out: {left_out}" in outcomes[name, "lights known"].note


def test_lamps_on_a_cone_are_not_made_equal_by_flattening_all_away() -> None:
    case = next(case for case in hard_cases(18) if case.name == "all lamps on a cone")
    found = photometric_stereo(case.images, None, case.mask, model="linear3", integration="none")
    cosines = np.einsum("pk,pk->p", found.surface.normals[case.mask], case.normals)
    median = float(np.median(np.degrees(np.arccos(np.clip(cosines, -1, 1)))))
    assert median < 5 and median < 3 * float(np.median(found.confidence[case.mask])) + 0.05
