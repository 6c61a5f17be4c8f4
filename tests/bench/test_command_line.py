"""Benchmarks on the command line."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record


def records(quick: bool) -> Iterator[Record]:
    yield Record("a question", "small" if quick else "large", 0.5)


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str, needs: Path | None = None) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmark", *arguments])
    run_benchmark("What is asked?\n\nMore.", records, "less of it", needs)


def test_records_are_printed_and_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    run(monkeypatch, "--quick", "--json", str(tmp_path / "found.json"), needs=tmp_path)
    said = capsys.readouterr()
    assert said.err == "a question, small: 500 ms\n"
    assert said.out.split()[-4:] == ["question", "small", "500", "ms"]
    assert [record["size"] for record in json.loads((tmp_path / "found.json").read_text())] == ["small"]
    run(monkeypatch)
    assert "a question  large" in capsys.readouterr().out


def test_without_its_data_it_is_skipped(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    run(monkeypatch, "--json", str(tmp_path / "found.json"), needs=tmp_path / "none")
    assert capsys.readouterr().out == f"skipped: no real data in {tmp_path / 'none'} (set HARMONICFACE_DATA)\n"
    assert not (tmp_path / "found.json").exists()


def test_help_tells_what_is_asked(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        run(monkeypatch, "--help")
    said = capsys.readouterr().out
    assert "What is asked?" in said and "less of it" in said and "More." not in said
