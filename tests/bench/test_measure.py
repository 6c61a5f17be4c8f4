from __future__ import annotations

import json
import platform
import sys
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench import measure
from harmonicface.bench.measure import Record, machine, read_records, write_records

ALONE = Record("load", "one mesh", 0.25, error=0.0, bytes=12, note="in pixels")
BESIDE = Record("match", "9 people", 0.003, error=1.5, peer="numpy", peer_seconds=0.002)
PROMISED = {"name", "size", "seconds", "bytes", "error", "peer", "peer_seconds", "ratio", "note"}
FIELDS = PROMISED | {"unit", "peer_error", "seed", "question", "call", "versions"}


def test_the_ratio_is_ours_over_the_peers() -> None:
    assert BESIDE.ratio == pytest.approx(1.5)
    assert ALONE.ratio is None


def test_records_are_written_as_a_list_of_the_promised_fields(tmp_path: Path) -> None:
    write_records(tmp_path / "records.json", [ALONE, BESIDE])
    records = json.loads((tmp_path / "records.json").read_text())
    assert [set(record) for record in records] == [FIELDS, FIELDS]
    assert (records[1]["ratio"], records[1]["peer"]) == (pytest.approx(1.5), "numpy")
    with pytest.raises(hf.HarmonicFaceError, match="cannot write"):
        write_records(tmp_path / "none" / "records.json", [ALONE])


def test_records_are_read_as_they_were_written(tmp_path: Path) -> None:
    write_records(tmp_path / "records.json", [ALONE, BESIDE])
    assert read_records(tmp_path / "records.json") == [ALONE, BESIDE]


def test_versions_are_those_of_what_was_timed() -> None:
    assert ALONE.versions == {"harmonicface": hf.__version__, "numpy": np.__version__}
    assert measure.version_of("no such package") == ""


@pytest.mark.parametrize("text", ["{", "3", "[3]", '[{"name": "a"}]'])
def test_what_holds_no_records_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "records.json").write_text(text)
    with pytest.raises(hf.HarmonicFaceError, match="expected a JSON list of records"):
        read_records(tmp_path / "records.json")


def test_records_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"cannot read .*none\.json: No such file"):
        read_records(tmp_path / "none.json")


def test_a_measurement_tells_where_it_was_taken() -> None:
    about = machine()
    assert about["python"] == platform.python_version()
    packages = about["packages"]
    assert isinstance(packages, dict)
    assert packages["harmonicface"] == hf.__version__
    assert packages["numpy"] == np.__version__
    assert about["processor"]
    assert isinstance(about["cores"], int)
    json.dumps(about)


def test_the_processor_has_a_name_without_proc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "is_file", lambda _: False)
    assert machine()["processor"] == (platform.processor() or platform.machine())


@pytest.mark.skipif(sys.platform != "linux", reason="the name is read from /proc/cpuinfo, which Linux has")
def test_a_processor_list_without_names(monkeypatch: pytest.MonkeyPatch) -> None:
    read, said = Path.read_text, ["model name\t: Analytical Engine: rev 2\n", "bogomips: 1\n"]

    def told(path: Path, *arguments: str, **options: str) -> str:
        return said.pop(0) if path == Path("/proc/cpuinfo") else read(path, *arguments, **options)

    monkeypatch.setattr(Path, "read_text", told)
    assert machine()["processor"] == "Analytical Engine: rev 2"
    assert machine()["processor"] == (platform.processor() or platform.machine())
