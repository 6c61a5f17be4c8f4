from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.lights_file import read_intensities, read_lights_file, write_lights_file

UNIT = np.array([[0.0, 0, 1], [0.6, 0, 0.8], [0, -0.8, 0.6]])


def written(folder: Path, text: str) -> Path:
    path = folder / "lights.txt"
    path.write_text(text, encoding="utf-8")
    return path


def test_lines_of_directions_between_any_separators(tmp_path: Path) -> None:
    found = read_lights_file(written(tmp_path, "# a rig\n\n0 0 1\n0.6,0, 0.8 # right\n0;-0.8;0.6\n"))
    assert_allclose(found.directions, UNIT)
    assert found.intensities is None and found.coefficients is None and found.names is None and len(found) == 3


def test_brightness_follows_directions(tmp_path: Path) -> None:
    one = read_lights_file(written(tmp_path, "0 0 1 2.5\n0.6 0 0.8 4\n"))
    assert_allclose(one.intensities, [2.5, 4])
    three = read_lights_file(written(tmp_path, "0 0 1 1 2 3\n"))
    assert_allclose(three.intensities, [[1, 2, 3]])


def test_two_decimals_are_unit_length(tmp_path: Path) -> None:
    found = read_lights_file(written(tmp_path, "0.57 0.58 0.58\n"))
    assert_allclose(np.linalg.norm(found.directions), 1, rtol=1e-12)


def test_names_bring_lines_into_order(tmp_path: Path) -> None:
    found = read_lights_file(written(tmp_path, "b.png 0.6 0 0.8 3\na.png 0 0 1 2\nc.png 0 -.8 .6 1\n"))
    of = found.of(["a.png", "b.png"], "lights.txt")
    assert_allclose(of.directions, UNIT[:2])
    assert_allclose(of.intensities, [2, 3])


def test_directions_and_brightness_round_trip(tmp_path: Path) -> None:
    names = ["one photo.png", "two#.png", "three.png"]
    write_lights_file(tmp_path / "out.txt", names, UNIT * [[2.0], [3], [0.5]], comments=["found"])
    found = read_lights_file(tmp_path / "out.txt").of(names, "out.txt")
    assert_allclose(found.directions, UNIT, atol=1e-6)
    assert_allclose(found.intensities, [2, 3, 0.5], atol=1e-6)


@pytest.mark.parametrize("count", [4, 9])
def test_coefficients_round_trip(tmp_path: Path, count: int) -> None:
    lights = np.random.default_rng(0).normal(size=(3, count))
    write_lights_file(tmp_path / "out.txt", ["a", "b", "c"], lights)
    found = read_lights_file(tmp_path / "out.txt")
    assert found.directions is None and found.coefficients is not None and len(found) == 3
    assert_allclose(found.coefficients[:, :count], lights, atol=1e-6)
    assert (found.coefficients[:, count:] == 0).all()
    assert_allclose(found.of(["c"], "out.txt").coefficients[:, :count], lights[2:], atol=1e-6)


def test_what_was_left_out_is_a_comment(tmp_path: Path) -> None:
    lights = UNIT.copy()
    lights[1] = np.nan
    write_lights_file(tmp_path / "out.txt", ["a", "b", "c"], lights, {1: "it shows another thing"})
    assert "# b left out: it shows another thing" in (tmp_path / "out.txt").read_text()
    found = read_lights_file(tmp_path / "out.txt")
    assert found.names == ("a", "c")
    with pytest.raises(HarmonicFaceError, match=r"got none for b$"):
        found.of(["a", "b", "c"], "out.txt")
    with pytest.raises(HarmonicFaceError, match="got none for b and 1 others"):
        found.of(["b", "d"], "out.txt")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0 2\n", "line 1: expected a unit direction .* got one of length 2"),
        ("0 0 1\n0 0 0\n", "line 2: expected a unit direction .* got zero"),
        ("0 0 1 0\n", "line 1: expected intensities above 0"),
        ("0 0\n", "line 1: expected 3 or 4 or 6 or 9 finite numbers"),
        ("0 0 nan\n", "line 1: expected 3 or 4 or 6 or 9 finite numbers"),
        ("0 0 one\n", "line 1: expected 3 or 4 or 6 or 9 finite numbers"),
        ("0 0 1\n0 0 1 2\n", "line 2: expected a line like the first"),
        ("a 0 0 1\n0 0 1\n", "line 2: expected a line like the first"),
        ("a 0 0 1\na 0 0 1\n", "expected one line for each photograph, got two for a"),
        ("# nothing\n", "expected a line for each photograph, got none"),
    ],
)
def test_refuses_other_lines(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        read_lights_file(written(tmp_path, text))


def test_refuses_another_number_of_lines(tmp_path: Path) -> None:
    found = read_lights_file(written(tmp_path, "0 0 1\n0.6 0 0.8\n"))
    with pytest.raises(HarmonicFaceError, match="expected a line for each of 3 photographs, got 2 lines"):
        found.of(["a", "b", "c"], "lights.txt")


def test_refuses_what_is_no_text(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match="No such file"):
        read_lights_file(tmp_path / "none.txt")
    (tmp_path / "binary.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(HarmonicFaceError, match="a file that is no text"):
        read_lights_file(tmp_path / "binary.txt")


def test_intensities_of_one_or_three_colours(tmp_path: Path) -> None:
    assert_allclose(read_intensities(written(tmp_path, "2\n3\n")), [2, 3])
    assert_allclose(read_intensities(written(tmp_path, "1 2 3\n4 5 6\n")), [[1, 2, 3], [4, 5, 6]])
    with pytest.raises(HarmonicFaceError, match="line 2: expected intensities above 0"):
        read_intensities(written(tmp_path, "2\n-3\n"))


def test_refuses_to_write_what_is_no_light(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected shape \(2, 3\)"):
        write_lights_file(tmp_path / "out.txt", ["a", "b"], np.ones((2, 5)))
    with pytest.raises(HarmonicFaceError, match="expected a finite light other than 0 for b"):
        write_lights_file(tmp_path / "out.txt", ["a", "b"], [[0, 0, 1], [0, 0, 0]])
    assert not (tmp_path / "out.txt").exists()
