"""The command that prints the coefficients of an environment map."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.cli import main
from harmonicface.lighting.cube import FACES


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    monkeypatch.setattr(sys, "argv", ["harmonicface", "light", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    np.save(tmp_path / "sky.npy", np.random.default_rng(0).uniform(size=(8, 16, 3)))
    return tmp_path / "sky.npy"


def test_json_is_one_object(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], sky: Path) -> None:
    assert run(monkeypatch, sky, "--json") == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert list(found) == ["order", "coefficients"]
    assert found["order"] == 2
    np.testing.assert_allclose(found["coefficients"], hf.EnvironmentMap.load(sky).coefficients(), rtol=1e-15)
    assert printed.err == ""


def test_a_cube_a_higher_order_and_grey(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for index, face in enumerate(FACES):
        np.save(tmp_path / f"{face}.npy", np.full((4, 4), index + 1.0))
    assert run(monkeypatch, tmp_path, "--layout", "cube", "--order", 3, "--json") == 0
    found = np.array(json.loads(capsys.readouterr().out)["coefficients"])
    expected = hf.EnvironmentMap.load(tmp_path, layout="cube").coefficients(3)
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 3, axis=1), rtol=1e-15)


def test_the_table_names_degree_mode_and_colour(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], sky: Path
) -> None:
    assert run(monkeypatch, sky, "--order", 1) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line.split() for line in lines if line.split()[:1] in (["0"], ["1"])]
    assert [row[:2] for row in rows] == [["0", "0"], ["1", "-1"], ["1", "0"], ["1", "+1"]]
    expected = hf.EnvironmentMap.load(sky).coefficients(1)
    np.testing.assert_allclose([[float(cell) for cell in row[2:]] for row in rows], expected, rtol=1e-4)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--layout", "globe"], "layout: expected one of 'latlong', 'angular', 'cube', 'mirrorball', got 'globe'"),
        (["--layout", "angular"], "expected a square map (angular), got 16 x 8"),
        (["--order", "-1"], "order: expected an integer of at least 0"),
    ],
)
def test_bad_input_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], sky: Path, options: list[str], message: str
) -> None:
    assert run(monkeypatch, sky, *options) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert message in printed.err
