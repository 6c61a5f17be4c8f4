import json

import numpy as np
import pytest
from typer.testing import CliRunner

from harmonicface.bench.benchmark import run_benchmark
from harmonicface.bench.crowds import SYNTHETIC, Crowd, ict_crowd
from harmonicface.cli import app
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.ict import ict_people
from harmonicface.people.synthetic import synthetic_people


def refusal(*arguments):
    return str(CliRunner().invoke(app, ["bench", "--faces", "2", *map(str, arguments)]).exception)


def test_the_benchmark_asks_for_the_crowd_that_it_is_given():
    drawn = []

    def draw(count, size, seed):
        drawn.append((count, size, seed))
        return synthetic_people(count, size, seed + 100)

    mine = run_benchmark(2, 16, 5, 1, ["harmonic9"], crowd=Crowd("mine", draw))
    usual = run_benchmark(2, 16, 5, 1, ["harmonic9"])
    assert drawn == [(22, 16, 5)]
    assert (mine.crowd, usual.crowd) == ("mine", SYNTHETIC.name)
    assert not np.array_equal(mine.people[0].surface.normals, usual.people[0].surface.normals)


def test_another_albedo():
    with pytest.raises(HarmonicFaceError, match="albedo: expected one of grey, uniform, got 'colour'"):
        ict_crowd("anywhere", "colour")


def test_a_crowd_needs_its_model(tmp_path):
    with pytest.raises(HarmonicFaceError, match="expected the ICT face model"):
        ict_crowd(tmp_path)


def test_the_command_says_what_is_missing(tmp_path):
    assert "expected the ICT face model" in refusal("--ict", tmp_path, "--out", tmp_path)
    assert "expected it with --ict only" in refusal("--albedo", "grey", "--out", tmp_path)


@pytest.mark.data
def test_ict_people_without_the_heads_behind_them(data_dir):
    folder = data_dir / "heads/ICT-FaceKit/FaceXModel"
    crowd = ict_crowd(folder, "uniform")
    (person,) = crowd.draw(1, 24, 3)
    (whole,) = ict_people(folder, 1, 24, 3, albedo="uniform")
    assert crowd.name == "ict, uniform albedo" and ict_crowd(folder).name == "ict"
    assert person.scene is None
    assert np.array_equal(person.normals, whole.normals) and np.array_equal(person.albedo, whole.albedo)


@pytest.mark.data
def test_the_command_recognizes_ict_people(data_dir, tmp_path):
    folder = data_dir / "heads/ICT-FaceKit"
    arguments = ["bench", "--faces", "3", "--size", "16", "--queries", "1", "--methods", "harmonic9", "--json"]
    done = CliRunner().invoke(app, [*arguments, "--ict", str(folder), "--out", str(tmp_path)])
    answer = json.loads(done.stdout)
    assert answer["people"] == "ict"
    assert answer["methods"]["harmonic9"]["errors"]["frontal"] == 0
    assert "3 people (ict) at 16" in (tmp_path / "report.html").read_text(encoding="utf-8")
