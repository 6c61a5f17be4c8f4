"""Every file in benchmarks/ has the same command line, table and records, and times what its rows name."""

from __future__ import annotations

import ast
import importlib
import json
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted((ROOT / "benchmarks").glob("*.py"))
FIELDS_OF_PEERS = {"peer", "peer_seconds"}
NAMING = {"call", "name", "peer", "peer_seconds", "versions"}  # of a record or a timing that is there
BEFORE_PEERS = 5  # name, size, seconds, error, bytes
BEFORE_SEED = 2  # records, json
PRINTERS = {"argparse.ArgumentParser", "print_records", "write_records", "print_table"}


def names_called(tree: ast.AST) -> list[tuple[str, ast.Call]]:
    """Return all calls, by the name that stands before the brackets."""
    return [(ast.unparse(node.func), node) for node in ast.walk(tree) if isinstance(node, ast.Call)]


def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_peer_comes_with_its_time_from_the_call_that_was_timed(path: Path) -> None:
    """A peer that is spelled out may be another one than was timed; `record` takes name and time together."""
    for name, call in names_called(parsed(path)):
        if name.rpartition(".")[2] == "Record":
            spelled = {keyword.arg for keyword in call.keywords} & FIELDS_OF_PEERS
            assert not spelled, f"line {call.lineno}: {spelled} in Record(...), expected record(..., peer=a Timing)"
            assert len(call.args) <= BEFORE_PEERS, f"line {call.lineno}: a peer by its place"
            assert None not in {keyword.arg for keyword in call.keywords}, f"line {call.lineno}: Record(**...)"
        if name.rpartition(".")[2] == "Timing":
            pytest.fail(f"line {call.lineno}: a Timing is made by timing, not by hand")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_what_was_timed_keeps_its_name(path: Path) -> None:
    """Neither is a name given to what is timed already, nor do `Record` and `Timing` go by another name."""
    tree = parsed(path)
    for name, call in names_called(tree):
        if name.rpartition(".")[2] in ("replace", "setattr", "__setattr__"):
            given = {keyword.arg for keyword in call.keywords} | {ast.unparse(each) for each in call.args[1:2]}
            assert not {one for one in given if one is not None and one.strip("'") in NAMING}, f"line {call.lineno}"
    renamed = [
        each for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for each in node.names if each.asname
    ]
    assert not [each.name for each in renamed if each.name in ("Record", "Timing", "replace", "record")]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_command_line_is_the_same(path: Path) -> None:
    tree = parsed(path)
    called = {name for name, _ in names_called(tree)}
    assert called & {"run_benchmark", "finish"}
    others = called & (PRINTERS - ({"print_table"} if path.stem == "inverse_light" else set()))
    assert not others, f"{others}: the command line and the table are those of bench.command_line"
    assert "finish" not in called or "benchmark_parser" in called
    about = ast.get_docstring(tree) or ""
    question, _, rest = about.partition("\n")
    assert len(question) > 20
    assert f"python benchmarks/{path.stem}.py [--quick]" in rest, "how it is run"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_seeds_are_said(path: Path) -> None:
    tree = parsed(path)
    text = path.read_text(encoding="utf-8")
    random = any(word in text for word in ("default_rng(", "random_state=", "seed=", "Random("))
    calls = names_called(tree)
    said = [keyword.arg for _, call in calls for keyword in call.keywords if keyword.arg == "seed"]
    said += ["seed" for name, call in calls if name == "finish" and len(call.args) > BEFORE_SEED]
    assert said or not random


@pytest.mark.skipif(sys.platform != "linux", reason="one platform is enough for a minute of measuring")
def test_rows_of_a_quick_run_name_what_can_be_found(tmp_path: Path) -> None:
    """Run a benchmark without data, and look up every name of a peer."""
    json_file = tmp_path / "materials.json"
    command = [sys.executable, str(ROOT / "benchmarks" / "materials.py"), "--quick", "--json", str(json_file)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    records = json.loads(json_file.read_text(encoding="utf-8"))
    assert all(record["seed"] is not None and record["unit"] and record["call"] for record in records)
    looked_up = set()
    for record in records:
        assert record["ratio"] == pytest.approx(record["seconds"] / record["peer_seconds"])
        function = record["peer"].partition(",")[0]
        if " of " in function:
            name, _, file = function.partition(" of ")
            assert f"def {name}(" in (ROOT / "benchmarks" / file).read_text(encoding="utf-8")
            continue
        assert callable(pkgutil.resolve_name(function))
        assert record["versions"][function.partition(".")[0]]
        looked_up.add(function)
    assert {"scipy.integrate.quad", "scipy.optimize.least_squares"} <= looked_up


def test_an_impostor_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a row names is called by something else: the row is not made."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    materials = importlib.import_module("materials")
    honest = materials._microfacet(4)
    assert honest.peer == "scipy.integrate.quad, degree by degree"
    real = materials.best

    def swapped(call: object, *arguments: object) -> object:
        if hasattr(call, "run") and call.run.__name__ == "adaptive":
            call.run = lambda: None
        return real(call, *arguments)

    monkeypatch.setattr(materials, "best", swapped)
    with pytest.raises(Exception, match=r"scipy\.integrate\.quad.*: expected a call of .*quad, got none"):
        materials._microfacet(4)
