"""Bars and tables in a terminal."""

from __future__ import annotations

import pytest

from harmonicface.bench.console import print_table, progress


def test_a_table_fits_eighty_columns(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    heads = ["method", "frontal", "side", "several", "natural", "noise", "extreme", "ms", "KiB"]
    print_table("Wrong answers", heads, [["eigenfaces_minus3", *["100.0"] * 6, "12.34", "1234"]])
    lines = capsys.readouterr().out.splitlines()
    assert max(len(line.rstrip()) for line in lines) <= 80
    assert lines[-1].split() == ["eigenfaces_minus3", *["100.0"] * 6, "12.34", "1234"]


def test_bars_stay_off_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    with progress() as tell:
        tell("counting", 1, 2)
        tell("counting", 2, 2)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "counting" in captured.err


def test_nothing_is_printed_where_nothing_is_done(capsys: pytest.CaptureFixture[str]) -> None:
    with progress():
        pass
    assert capsys.readouterr() == ("", "")
