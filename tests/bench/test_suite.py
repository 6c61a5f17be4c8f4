"""Every benchmark in a process of its own: what fails is told and stops nothing."""

from __future__ import annotations

import importlib.util
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

import harmonicface as hf
from harmonicface.bench.suite import benchmarks_in, run_one, run_suite

ROOT = Path(__file__).parents[2]
HEAD = "import json, os, subprocess, sys, time\nout = sys.argv[sys.argv.index('--json') + 1]\n"
RECORD = '[{"name": "a", "size": str("--quick" in sys.argv), "seconds": 0.5, "ratio": null}]'
WRITES = f"open(out, 'w').write(json.dumps({RECORD.replace('null', 'None')}))\n"
BENCHMARKS = {
    "good": f'"""How fast? Beside nothing.\n\nMore of it.\n"""\n{HEAD}{WRITES}print("skipped: one half")\n',
    "absent": f'{HEAD}print("much")\nprint("skipped: no data")\n',
    "broken": f"{HEAD}print('before')\nraise ValueError('on purpose')\n",
    "silent": f"{HEAD}print('nothing')\n",
    "strange": f"{HEAD}open(out, 'w').write('3')\n",
    "unreadable": "def (\n",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "benchmarks"
    made.mkdir()
    for name, text in BENCHMARKS.items():
        (made / f"{name}.py").write_text(text)
    return made


def test_what_becomes_of_each(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "silent.json").write_text("[]")  # of a run before
    said: list[str] = []
    ran = {
        one.name: one
        for one in run_suite(benchmarks_in(folder), tmp_path, lambda name: name == "good", 60, said.append)
    }
    assert {name: one.state for name, one in ran.items()} == {
        "absent": "skipped",
        "broken": "failed",
        "good": "done",
        "silent": "failed",
        "strange": "failed",
        "unreadable": "failed",
    }
    good = ran["good"]
    assert (good.question, good.about, good.said) == ("How fast? Beside nothing.", "More of it.", "skipped: one half")
    assert good.quick
    assert [record.size for record in good.records] == ["True"]
    assert 0 < good.seconds < 60
    assert ran["absent"].said == "skipped: no data"
    assert ran["absent"].question == "absent"
    assert "ValueError: on purpose" in ran["broken"].said
    assert "before" in ran["broken"].said
    assert ran["silent"].said == "wrote no records\nnothing"
    assert "expected a JSON list of records" in ran["strange"].said
    assert "SyntaxError" in ran["unreadable"].said
    assert said[0] == "[ 1/6] absent (in full)"
    assert "SKIPPED skipped: no data" in said[1]
    assert any("1 records" in line for line in said)


def test_what_takes_too_long_is_ended_with_all_that_it_started(tmp_path: Path) -> None:
    child = tmp_path / "child"
    code = f"import os, time; open({str(child)!r}, 'w').write(str(os.getpid())); time.sleep(600)"
    slow = tmp_path / "slow.py"
    slow.write_text(f"{HEAD}print('begun', flush=True)\nsubprocess.run([sys.executable, '-c', {code!r}])\n")
    ran = run_one(slow, tmp_path / "slow.json", False, 5.0)
    assert ran.state == "failed"
    assert ran.said == "ended after 5 s\nbegun"
    gone = Path(f"/proc/{child.read_text()}") if child.exists() else None
    for _ in range(50):
        if gone is None or not gone.exists() or ") Z " in (gone / "stat").read_text():
            break
        time.sleep(0.1)
    else:
        pytest.fail("the child lives on")


def test_names_choose(folder: Path, tmp_path: Path) -> None:
    assert [path.stem for path in benchmarks_in(folder, ["good", "broken"])] == ["broken", "good"]
    with pytest.raises(hf.HarmonicFaceError, match=r"expected one of absent, broken, .* got 'none'"):
        benchmarks_in(folder, ["none"])
    with pytest.raises(hf.HarmonicFaceError, match=r"expected benchmarks in .*, got none"):
        benchmarks_in(tmp_path)


@pytest.fixture
def script(folder: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("run_benchmarks", ROOT / "scripts" / "run_benchmarks.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "FOLDER", folder)
    return module


def test_the_script_fails_at_the_end_if_one_has_failed(
    script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "results"
    monkeypatch.setattr(sys, "argv", ["run_benchmarks", "--out", str(out), "broken", "good"])
    assert script.main() == 1
    assert sorted(path.name for path in out.iterdir()) == ["good.json", "index.html", "results.md"]
    said = capsys.readouterr()
    assert said.out.startswith("2 benchmarks (1 done, 1 failed), 1 measurements")
    assert "[ 2/2] good (quick)" in said.err
    monkeypatch.setattr(sys, "argv", ["run_benchmarks", "--out", str(out), "--full", "good", "absent"])
    assert script.main() == 0
    assert "[ 2/2] good (in full)" in capsys.readouterr().err


def test_the_script_refuses_in_one_line(
    script: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["run_benchmarks", "none"])
    with pytest.raises(SystemExit) as ended:
        script.main()
    assert ended.value.code == 1
    assert capsys.readouterr().err.startswith("benchmark: expected one of absent")


def test_what_is_run_in_full_exists(script: ModuleType) -> None:
    assert {f"{name}.py" for name in script.IN_FULL} <= {path.name for path in (ROOT / "benchmarks").iterdir()}
