"""The table of hard photographs: every case is there, and none is answered surely and wrongly."""

from __future__ import annotations

import re

import numpy as np
import pytest

from harmonicface.bench import stereo_stability
from harmonicface.bench.hard_photographs import hard_cases
from harmonicface.bench.stereo_stability import Outcome, stability_records, stereo_outcomes, verdict_of
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
    return {(outcome.case, outcome.lights): outcome for outcome in stereo_outcomes(SIDE, quick=True)}


def test_every_case_is_there(outcomes: dict[tuple[str, str], Outcome]) -> None:
    cases = hard_cases(12)
    assert {case.name for case in cases if case.known is not None} == {
        name for name, said in outcomes if said == "known"
    }
    assert len(cases) == len({case.name for case in cases}) > 40
    assert sum(said == "unknown lamps" for _, said in outcomes) > 25


def test_nothing_is_answered_surely_and_wrongly(outcomes: dict[tuple[str, str], Outcome]) -> None:
    assert [key for key, outcome in outcomes.items() if outcome.verdict == "WRONG"] == []


@pytest.mark.parametrize(("lights", "causes"), [("known", KNOWN), ("unknown lamps", UNKNOWN)])
def test_refusals_name_the_cause(outcomes: dict[tuple[str, str], Outcome], lights: str, causes: dict[str, str]) -> None:
    for name, cause in causes.items():
        outcome = outcomes[name, lights]
        assert outcome.verdict == "refused" and "\n" not in outcome.note
        assert re.search(cause, outcome.note), (name, outcome.note)


def test_what_is_refused_of_known_lights_is_what_tells_nothing(outcomes: dict[tuple[str, str], Outcome]) -> None:
    assert {name for (name, said), one in outcomes.items() if said == "known" and one.verdict == "refused"} == set(
        KNOWN
    )


@pytest.mark.parametrize("name", HARMLESS)
def test_what_should_do_no_harm_does_none(outcomes: dict[tuple[str, str], Outcome], name: str) -> None:
    outcome = outcomes[name, "known"]
    assert outcome.error is not None and outcome.error < 0.6
    assert outcome.stated is not None and outcome.stated < 2


def test_scale_and_type_change_nothing(outcomes: dict[tuple[str, str], Outcome]) -> None:
    for lights in ("known", "unknown lamps"):
        usual = outcomes["nothing hard", lights].error
        for name in ("float32", *(("times 1e-12", "times 1e+12", "NaN outside the mask") if lights == "known" else ())):
            assert outcomes[name, lights].error == pytest.approx(usual, abs=0.02)


@pytest.mark.parametrize(
    ("name", "left_out"),
    [("one image of another scene", 7), ("one image moved by 1 pixel", 5), ("one direction wrong", 3)],
)
def test_what_does_not_belong_is_left_out(outcomes: dict[tuple[str, str], Outcome], name: str, left_out: int) -> None:
    assert f"left out: {left_out}" in outcomes[name, "known"].note


@pytest.mark.parametrize(
    ("median", "stated", "usual", "expected"),
    [
        (0.0, 0.0, None, "right"),
        (0.9, 0.3, 0.3, "right"),
        (1.0, 0.3, 0.3, "WRONG"),
        (1.0, 0.7, 0.3, "wider stated uncertainty"),
        (90.0, np.inf, 0.3, "wider stated uncertainty"),
    ],
)
def test_verdicts(median: float, stated: float, usual: float | None, expected: str) -> None:
    assert verdict_of(median, stated, usual) == expected


def test_records_have_the_verdict_and_the_error(monkeypatch: pytest.MonkeyPatch) -> None:
    made = [
        Outcome("one", "known", "right", 0.2, 0.1, 0.3, 1.0, "linear3"),
        Outcome("two", "unknown", "refused", None, None, None, 1.0, "why"),
    ]
    monkeypatch.setattr(stereo_stability, "stereo_outcomes", lambda quick: iter(made))
    one, two = stability_records(quick=True)
    assert one.error == 0.2 and one.note == "right (stated: 0.3 degrees at the median); linear3"
    assert (two.name, two.size, two.error, two.note) == ("two", "lights unknown", None, "refused; why")


def test_lamps_on_a_cone_are_not_made_equal_by_flattening_all_away() -> None:
    case = next(case for case in hard_cases(18) if case.name == "all lamps on a cone")
    found = photometric_stereo(case.images, None, case.mask, model="linear3", integration="none")
    cosines = np.einsum("pk,pk->p", found.surface.normals[case.mask], case.normals)
    median = float(np.median(np.degrees(np.arccos(np.clip(cosines, -1, 1)))))
    assert verdict_of(median, float(np.median(found.confidence[case.mask]))) == "right" and median < 5
