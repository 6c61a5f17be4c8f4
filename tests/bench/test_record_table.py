"""The one table: its columns, in a terminal and in Markdown."""

from __future__ import annotations

import pytest

from harmonicface.bench.measure import Record
from harmonicface.bench.record_table import markdown, print_records, record_table
from harmonicface.bench.spelling import spelled_bytes, spelled_error, spelled_seconds, three_figures

ALONE = Record("load", "one mesh", 0.25, error=0.0, bytes=2048, note="in [bold]pixels")
BESIDE = Record("match", "9 people", 0.003, error=1.5, peer="numpy.dot", peer_seconds=0.002, peer_error=3.0, unit="%")


def test_columns_that_nothing_fills_are_left_out() -> None:
    heads, rows = record_table([ALONE])
    assert dict(zip(heads, rows[0], strict=True)) == {
        "#": "1", "what": "load", "of what": "one mesh", "time": "250 ms", "error": "0", "memory": "2 KiB",
        "note": "in [bold]pixels",
    }  # fmt: skip
    heads, rows = record_table([ALONE, BESIDE])
    assert " ".join(heads) == "# what of what time error in memory beside its time its error ratio note"
    assert rows[1][6:11] == ["", "numpy.dot", "2 ms", "3", "1.5"]


def test_records_are_printed_with_their_notes_below(capsys: pytest.CaptureFixture[str]) -> None:
    print_records([ALONE, BESIDE], "two records")
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == "two records"
    assert " ".join(lines[1].split()) == "# what of what time error in memory beside its time its error ratio"
    assert lines[-1] == "  1  in [bold]pixels"
    assert any(line.startswith("2  match  9 people") for line in lines)
    print_records([BESIDE])
    assert "numpy.dot" in capsys.readouterr().out


def test_what_is_long_is_broken_and_not_cut(capsys: pytest.CaptureFixture[str]) -> None:
    print_records([Record("a question " * 20, "s", 1.0, peer="module." * 30, peer_seconds=1.0)])
    said = capsys.readouterr().out
    assert said.count("question") == 20
    assert said.replace(" ", "").replace("\n", "").count("module.") >= 15
    assert "…" not in said


def test_cells_of_markdown_end_where_they_end() -> None:
    text = markdown(["what", "time"], [["a|b\nc<d", "1 s"]])
    assert text.splitlines() == ["| what | time |", "|---|--:|", "| a\\|b c&lt;d | 1 s |"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(None, ""), (0.0, "0 ns"), (2.5e-9, "2.5 ns"), (1.5e-6, "1.5 µs"), (0.0999, "99.9 ms"), (1234.0, "1234 s")],
)
def test_times(seconds: float | None, text: str) -> None:
    assert spelled_seconds(seconds) == text


@pytest.mark.parametrize(("count", "text"), [(None, ""), (0, "0 B"), (3 << 30, "3 GiB"), (-2048, "-2 KiB")])
def test_memory(count: int | None, text: str) -> None:
    assert spelled_bytes(count) == text


@pytest.mark.parametrize(("error", "text"), [(None, ""), (1e-16, "1.0e-16"), (0.00123, "0.00123"), (455.4, "455")])
def test_errors(error: float | None, text: str) -> None:
    assert spelled_error(error) == text


def test_large_numbers_have_exponents() -> None:
    assert three_figures(2.5e6) == "2.5e+06"
