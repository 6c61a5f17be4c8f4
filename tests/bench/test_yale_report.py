"""The report on Yale B stands alone."""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import harmonicface as hf
from harmonicface.bench.yale_b import evaluate_yale_b
from harmonicface.bench.yale_plots import by_error, overall, subsets_picture, time_picture
from harmonicface.bench.yale_report import write_yale_report
from harmonicface.bench.yale_result import Answers, YaleMethod, YaleResult

METHODS = ["correlation", "gradient_angle", "linear3", "default"]


@pytest.fixture(scope="module")
def result(yale_folder: Path) -> YaleResult:
    return evaluate_yale_b(yale_folder, train="frontal", methods=METHODS, noise=0.01, jpeg=80)


def test_the_page_holds_everything(result: YaleResult, tmp_path: Path) -> None:
    path = write_yale_report(result, tmp_path / "new")
    text = path.read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert "$" not in re.sub(r'"data:[^"]*"', "", text)
    for told in (
        "default: ",
        "noise of 1 % of white added and through JPEG of quality 80",
        "people 1 to 3",
        "one photograph; 39 photographs asked for",
        "Photographs that were learned from are not asked for.",
        "<dt>linear3</dt>",
        "RLS(LOG-DCT)",
        "Xie, Zheng",
        "on other photographs than ours",
        "<h2>Decisions</h2>",
        'alt="CMC"',
    ):
        assert told in text
    assert text.count("<figure>") >= 5
    found = json.loads((tmp_path / "new" / "results.json").read_text())
    assert found["left_out"].keys() == {"linear3"}
    assert (found["noise"], found["jpeg"], found["n"]["1"]) == (0.01, 80, 18)
    assert "processor" in found["machine"]


def test_why_errors_differ_is_said_of_the_published_photographs_alone(tmp_path: Path) -> None:
    counts = {"1": 70, "2": 120, "3": 120, "4": 140, "5": 190}
    none = dict.fromkeys(counts, 0)
    correlation = YaleMethod(dict.fromkeys(counts, 0.0), 1.0, none, counts)
    whole = YaleResult("yale-b", "subset1", list(range(1, 11)), counts, {"correlation": correlation})
    text = write_yale_report(whole, tmp_path).read_text(encoding="utf-8")
    assert "on the same photographs" in text and "Why some differ" in text
    for changed in ({"noise": 0.01}, {"jpeg": 50}, {"people": [*range(1, 10), 11]}):
        text = write_yale_report(replace(whole, **changed), tmp_path).read_text(encoding="utf-8")
        assert "on other photographs than ours" in text and "Why some differ" not in text


def test_photographs_that_were_missed_are_shown(result: YaleResult, tmp_path: Path) -> None:
    answers = result.methods["default"].answers
    assert answers is not None
    wrong = Answers(answers.queries, [(query.person + 1) % 3 for query in answers.queries])
    other = replace(result, methods={"default": YaleMethod.of(wrong, [0.001])}, left_out={})
    text = write_yale_report(other, tmp_path).read_text(encoding="utf-8")
    assert "default: 100.00 % of 39 photographs given to the wrong person" in text
    assert "39 photographs, the first 16 shown" in text
    assert "chosen on" not in text
    others = write_yale_report(replace(other, people=[1, 2, 6]), tmp_path).read_text(encoding="utf-8")
    assert "Settings of default were chosen on people 1 to 5; on the others alone its error is 100 % (75.3 to" in others
    assert "taken for yaleB02" in text
    assert "Left out" not in text
    none = write_yale_report(replace(other, train="subset12"), tmp_path).read_text(encoding="utf-8")
    assert "Published" not in none


def test_without_our_method_the_best_one_is_told(result: YaleResult, tmp_path: Path) -> None:
    methods = {name: method for name, method in result.methods.items() if name != "default"}
    text = write_yale_report(replace(result, methods=methods, noise=0.0, jpeg=None), tmp_path).read_text()
    assert f"<h1>{by_error(result)[0][0] if by_error(result)[0][0] != 'default' else by_error(result)[1][0]}: " in text
    assert "misses" not in text
    assert "<h2>Decisions</h2>" in text
    silent = {name: replace(method, answers=None) for name, method in methods.items()}
    assert "Decisions" not in write_yale_report(replace(result, methods=silent), tmp_path).read_text()
    assert "as they are." in text


def test_the_best_method_comes_first(result: YaleResult) -> None:
    errors = [overall(method) for _, method in by_error(result)]
    assert errors == sorted(errors)


def test_plots_are_pictures_that_depend_on_the_errors(result: YaleResult) -> None:
    for draw in (subsets_picture, time_picture):
        shown = np.asarray(Image.open(io.BytesIO(draw(result))))
        assert min(shown.shape[:2]) > 150
        other = {name: replace(method, wrong={"4": 9}, error_percent=dict.fromkeys(method.error_percent, 50.0))
                 for name, method in result.methods.items()}  # fmt: skip
        assert draw(replace(result, methods=other)) != draw(result)


def test_a_folder_that_cannot_be_made(result: YaleResult, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(hf.HarmonicFaceError, match="cannot make the folder"):
        write_yale_report(result, tmp_path / "file" / "report")
