"""Plots of decisions: they are pictures, and the figures beside them are those of the curves."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
from PIL import Image
from sklearn.metrics import top_k_accuracy_score

from harmonicface.bench.decision_plots import (
    cmc_picture,
    decision_section,
    det_picture,
    growth_picture,
    roc_picture,
    separated,
)
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.decision import error_curve
from harmonicface.recognition.identification import cumulative_match

RNG = np.random.default_rng(0)
PEOPLE = RNG.integers(0, 8, 60)
GOOD = RNG.uniform(0.5, 1, (60, 8)) - 0.5 * (np.arange(8) == PEOPLE[:, None])
BAD = RNG.uniform(0, 1, (60, 8))


def test_plots_are_pictures() -> None:
    curves = {name: error_curve(*separated(-one, PEOPLE)) for name, one in {"default": GOOD, "lbph": BAD}.items()}
    drawn = [
        roc_picture(curves),
        det_picture(curves),
        cmc_picture({"default": cumulative_match(-GOOD, PEOPLE)}),
        growth_picture(-BAD, PEOPLE),
    ]
    for png in drawn:
        with Image.open(io.BytesIO(png)) as picture:
            assert picture.size == (936, 572)
            assert len(np.unique(np.asarray(picture.convert("L")))) > 10
    assert roc_picture(curves) != roc_picture({"default": curves["default"]})


def test_the_section_has_a_row_a_method_and_four_plots() -> None:
    section = decision_section({"default": GOOD, "lbph": BAD}, PEOPLE)
    assert section.count("<img ") == 4
    rows = re.findall(r"<tr( class=ours)?><td>(\w+)</td><td>([\d.]+)</td>", section)
    assert [(bool(ours), name) for ours, name, _ in rows] == [(True, "default"), (False, "lbph")]
    assert float(rows[0][2]) < float(rows[1][2])
    first = 100 * top_k_accuracy_score(PEOPLE, -BAD, k=1, labels=range(8))
    assert f"<td>{first:.3g} % (" in section


def test_without_ours_the_first_is_shown() -> None:
    assert "lbph, at the threshold" in decision_section({"lbph": BAD}, PEOPLE)


def test_what_is_genuine_is_kept_apart() -> None:
    genuine, impostor = separated(GOOD, PEOPLE)
    assert genuine.shape == (60,) and impostor.shape == (60 * 7,)
    assert genuine.sum() + impostor.sum() == pytest.approx(GOOD.sum())


@pytest.mark.parametrize(
    ("distances", "people", "message"),
    [
        ({}, [0], "distances: expected those of at least one method, got none"),
        ({"a": np.ones((3, 1))}, [0, 0, 0], "distances: expected at least two people, so that there are impostors"),
        ({"a": np.ones((3, 2))}, [0, 1], "people: expected an index for each of 3 searches"),
        ({"a": np.full((1, 2), np.nan)}, [0], "scores: expected finite numbers"),
    ],
)
def test_bad_input(distances: dict, people: list, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        decision_section(distances, people)
