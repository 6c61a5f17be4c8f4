"""results.json has its schema; report.html needs nothing else."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

import harmonicface as hf
from harmonicface.bench.benchmark import BenchmarkResult, run_benchmark
from harmonicface.bench.contenders import METHODS
from harmonicface.bench.report import results, write_report
from harmonicface.bench.table import error_table, margin_table, model_records, model_table
from harmonicface.bench.tiers import TIERS

TIER_NAMES = [tier.name for tier in TIERS]


class Page(HTMLParser):
    """Collects tags, addresses, and the cells of tables."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.sources: list[str] = []
        self.links: list[str] = []
        self.tables: list[list[list[str]]] = []
        self._cell = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name == "src":
                self.sources.append(value or "")
            elif name in ("href", "data", "action", "poster", "srcset"):
                self.links.append(value or "")
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.tables[-1][-1].append("")
            self._cell = True

    def handle_endtag(self, tag: str) -> None:
        self._cell = self._cell and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self._cell:
            self.tables[-1][-1][-1] += data


@pytest.fixture(scope="module")
def folder(small_run: BenchmarkResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("out") / "new" / "report"
    assert write_report(small_run, target) == target / "report.html"
    return target


def test_two_files_and_no_other(folder: Path) -> None:
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "results.json"]


def test_the_page_needs_nothing_else(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags)
    assert page.links == []
    assert "http://" not in text
    assert "https://" not in text
    assert "@import" not in text
    assert "url(" not in text
    assert len(page.sources) == 5
    for source in page.sources:
        kind, data = source.split(",", 1)
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data, validate=True).startswith(b"\x89PNG")
    assert "$" not in text  # nothing was left unfilled


def test_the_page_holds_the_tables(folder: Path, small_run: BenchmarkResult) -> None:
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    tables = (error_table(small_run), model_table(small_run), margin_table(small_run))
    for table, (heads, rows) in zip(page.tables, tables, strict=True):
        assert table == [heads, *rows]
    assert [row[0] for row in page.tables[0][1:]] == list(METHODS)


def test_the_page_says_what_came_out(folder: Path, small_run: BenchmarkResult) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    right = 24 - next(sum(method.errors.values()) for method in small_run.methods if method.method == "harmonic9")
    assert f"Nine harmonic images rank the right person first in {right} of 24 photographs" in text
    for tier in TIERS:
        assert tier.about in text
    assert f"whom it would name among everybody is missing there in {small_run.missed} (24 of them" in text


def test_the_schema_of_the_results(folder: Path, small_run: BenchmarkResult) -> None:
    found = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    written = results(small_run)
    assert found == json.loads(json.dumps(written))
    assert (found["faces"], found["size"], found["seed"]) == (4, 24, 0)
    assert found["queries"] == dict.fromkeys(TIER_NAMES, 4)
    assert list(found["methods"]) == list(METHODS)
    for figures in found["methods"].values():
        assert set(figures) == {"errors", "error_percent", "ms_per_query", "enrolment_seconds", "bytes_per_person"}
        assert figures["error_percent"] == {tier: 25.0 * count for tier, count in figures["errors"].items()}
    assert {frozenset(margin) for margin in found["margins"].values()} == {frozenset({"median", "worst"})}
    refusals = {frozenset(rates) for rates in found["open_set"].values()}
    assert refusals == {frozenset({"enrolled_refused", "strangers_refused"})}
    assert list(found["margins"]) == list(found["open_set"]) == TIER_NAMES
    assert found["missed_by_shortlist"]["trials"] == 24
    assert (found["threshold"], found["margin"]) == (small_run.gallery.threshold, small_run.gallery.margin)
    assert set(found["machine"]) == {"processor", "cores", "python", "system", "packages"}
    assert found["machine"]["packages"]["harmonicface"] == hf.__version__


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures out: drawing them takes seconds."""
    for name in ("explanations_picture", "harmonics_picture", "lights_picture", "tradeoff_picture"):
        monkeypatch.setattr(f"harmonicface.bench.pictures.{name}", lambda *_: b"")


@pytest.mark.usefixtures("no_pictures")
def test_names_are_escaped(small_run: BenchmarkResult, tmp_path: Path) -> None:
    sly = replace(small_run, methods=[replace(small_run.methods[0], method="<b>&")])
    text = write_report(sly, tmp_path).read_text(encoding="utf-8")
    assert "<b>" not in text
    assert "&lt;b&gt;&amp;" in text


@pytest.mark.usefixtures("no_pictures")
def test_without_the_nine_images_the_headline_is_another(tmp_path: Path) -> None:
    page = write_report(run_benchmark(3, 24, 0, 1, methods=["correlation"]), tmp_path)
    assert "<h1>1 methods, 18 photographs</h1>" in page.read_text(encoding="utf-8")


def test_a_folder_that_cannot_be_made(small_run: BenchmarkResult, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(hf.HarmonicFaceError, match=r"cannot make the folder .*file"):
            write_report(small_run, folder)
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.usefixtures("no_pictures")
def test_a_page_in_the_way_stays(small_run: BenchmarkResult, tmp_path: Path) -> None:
    (tmp_path / "report.html").mkdir()
    with pytest.raises(hf.HarmonicFaceError, match=r"cannot write .*report\.html"):
        write_report(small_run, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "results.json"]


def test_the_front_of_models_under_natural_light(small_run: BenchmarkResult) -> None:
    heads, rows = model_table(small_run)
    table = {row[0]: dict(zip(heads[1:5], row[1:5], strict=True)) | {"memory": row[5]} for row in rows}
    assert list(table)[-1] == "harmonic9"  # the largest
    assert (table["harmonic9"]["of nine's"], table["harmonic9"]["memory"]) == ("100 %", "100 %")
    assert table["linear3"]["memory"] == "33 %"
    assert int(table["auto"]["memory"].removesuffix(" %")) <= 60
    assert table["auto"]["errors in natural light"].endswith(" of 4")
    records = model_records(small_run)
    assert {record.name for record in records} == set(table)
    errors = {method.method: method.errors["natural"] for method in small_run.methods}
    assert all(record.error == 25.0 * errors[record.name] for record in records)
    alone = replace(small_run, methods=[method for method in small_run.methods if method.method == "harmonic9"])
    assert model_table(alone)[1] == []
