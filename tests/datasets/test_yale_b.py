from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.datasets.yale_b import light_direction, load_yale_b, parse_people, subset_of
from harmonicface.errors import HarmonicFaceError

LIGHTS = ["A+000E+00", "A+035E+40", "A-060E-20"]


def write_pgm(path: Path, pixels: np.ndarray) -> None:
    height, width = pixels.shape
    path.write_bytes(b"P5\n%d %d\n255\n" % (width, height) + pixels.astype(np.uint8).tobytes())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two people, three photographs each, of grey level 10 times the person plus the photograph's index."""
    for person in (1, 3):
        (tmp_path / f"yaleB{person:02d}").mkdir()
        for index, light in enumerate(LIGHTS):
            write_pgm(
                tmp_path / f"yaleB{person:02d}" / f"yaleB{person:02d}_P00{light}.pgm",
                np.full((192, 168), 10 * person + index),
            )
    return tmp_path


def test_reads_photographs_lights_and_subsets(folder: Path) -> None:
    first, third = load_yale_b(folder)
    assert (first.number, third.number) == (1, 3)
    assert third.photographs.shape == (3, 192, 168)
    assert third.photographs.dtype == np.float32
    assert_allclose(third.photographs[:, 0, 0], np.array([30, 31, 32]) / 255, rtol=1e-6)
    azimuth, elevation = np.radians(35), np.radians(40)
    expected = [-np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)]
    assert_allclose(third.lights[1], expected, rtol=1e-12)
    assert_allclose(third.angles[1], np.degrees(np.arccos(np.cos(azimuth) * np.cos(elevation))), rtol=1e-12)
    assert_array_equal(third.subsets, [1, 3, 4])
    assert [file.name for file in third.files] == [f"yaleB03_P00{light}.pgm" for light in LIGHTS]


def test_reads_the_people_asked_for_in_that_order(folder: Path) -> None:
    assert [person.number for person in load_yale_b(folder, [3, 1])] == [3, 1]
    assert [person.number for person in load_yale_b(str(folder), people=iter([3]))] == [3]


def test_skips_what_is_no_photograph_with_a_known_light(folder: Path) -> None:
    person = folder / "yaleB01"
    write_pgm(person / "yaleB01_P00_Ambient.pgm", np.zeros((480, 640)))
    (person / "yaleB01_P00A+020E-40.pgm.bad").write_bytes(b"corrupt")
    (person / "yaleB01_P00.info").write_text("list of files")
    (person / "._yaleB01_P00A+000E+00.pgm").write_bytes(b"of the file system")
    (folder / "readme.txt").write_text("hello")
    assert len(load_yale_b(folder, [1])[0].photographs) == 3


def test_a_missing_photograph_is_no_error(folder: Path) -> None:
    (folder / "yaleB01" / "yaleB01_P00A+000E+00.pgm").unlink()
    first, third = load_yale_b(folder)
    assert (len(first.photographs), len(third.photographs)) == (2, 3)
    assert first.lights.shape == (2, 3)


def test_no_such_folder(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match=r"got no folder .*nowhere"):
        load_yale_b(tmp_path / "nowhere")


def test_nobody_in_the_folder(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected folders yaleB01, yaleB02, ... in .*, got none"):
        load_yale_b(tmp_path)


def test_a_person_who_is_not_there(folder: Path) -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected people that are in .* \(1,3\), got 2"):
        load_yale_b(folder, [1, 2])


def test_a_person_asked_for_twice(folder: Path) -> None:
    with pytest.raises(HarmonicFaceError, match="expected each number once, got 3 twice"):
        load_yale_b(folder, [3, 1, 3])


def test_a_person_without_photographs(folder: Path) -> None:
    (folder / "yaleB02").mkdir()
    with pytest.raises(HarmonicFaceError, match=r"expected photographs yaleB02_P00A.*got none"):
        load_yale_b(folder)


@pytest.mark.parametrize("name", ["face", "yaleB01_P00A+35E+40", "yaleB03_P00A+035E+40", "yaleB01_P01A+035E+40"])
def test_a_name_that_does_not_tell_the_light_or_tells_another_person(folder: Path, name: str) -> None:
    write_pgm(folder / "yaleB01" / f"{name}.pgm", np.zeros((192, 168)))
    with pytest.raises(HarmonicFaceError, match=re.escape(f"{name}.pgm")):
        load_yale_b(folder, [1])


def test_an_image_of_another_size(folder: Path) -> None:
    write_pgm(folder / "yaleB01" / "yaleB01_P00A+005E+10.pgm", np.zeros((480, 640)))
    with pytest.raises(
        HarmonicFaceError, match=r"expected a cropped grey image of shape \(192, 168\), got \(480, 640\)"
    ):
        load_yale_b(folder)


def test_a_colour_image(folder: Path) -> None:
    path = folder / "yaleB01" / "yaleB01_P00A+005E+10.pgm"
    path.write_bytes(b"P6\n168 192\n255\n" + bytes(168 * 192 * 3))
    with pytest.raises(HarmonicFaceError, match=r"got \(192, 168, 3\)"):
        load_yale_b(folder)


@pytest.mark.parametrize("length", [0, 6, 5000])
def test_an_image_cut_short(folder: Path, length: int) -> None:
    path = folder / "yaleB01" / "yaleB01_P00A+000E+00.pgm"
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(HarmonicFaceError, match=re.escape(str(path))) as error:
        load_yale_b(folder)
    assert "\n" not in str(error.value)


def test_plus_azimuth_lights_the_left_of_the_picture_and_plus_elevation_the_top() -> None:
    assert_allclose(light_direction(0, 0), [0, 0, 1], atol=1e-15)
    assert light_direction(35, 0)[0] < 0
    assert light_direction(0, 40)[1] > 0


@given(azimuth=st.floats(-180, 180), elevation=st.floats(-90, 90))
def test_directions_are_unit_vectors(azimuth: float, elevation: float) -> None:
    assert_allclose(np.linalg.norm(light_direction(azimuth, elevation)), 1, rtol=1e-12)


@pytest.mark.parametrize(
    ("angle", "subset"),
    [(0, 1), (12, 1), (12.01, 2), (25, 2), (25.01, 3), (51.5, 3), (51.6, 4), (77, 4), (77.1, 5), (180, 5)],
)
def test_subsets_have_the_published_bounds(angle: float, subset: int) -> None:
    assert subset_of(angle) == subset
    assert subset_of(float(np.degrees(np.arccos(np.cos(np.radians(angle)))))) == subset


@pytest.mark.parametrize("angle", [-1, 181, float("nan")])
def test_no_angle(angle: float) -> None:
    with pytest.raises(HarmonicFaceError, match="angle: expected degrees from 0 to 180, got"):
        subset_of(angle)


def test_people_are_numbers_and_ranges() -> None:
    assert parse_people("1-10") == list(range(1, 11))
    assert parse_people(" 7 , 1, 3 - 5") == [7, 1, 3, 4, 5]


@pytest.mark.parametrize("text", ["", "1-", "a", "1,,2", "0", "3-1", "-1", "1.5", "1-2-3", "1;2"])
def test_no_list_of_people(text: str) -> None:
    with pytest.raises(HarmonicFaceError, match="expected numbers and ranges such as 1,3,5-7, got"):
        parse_people(text)


def test_a_number_named_twice() -> None:
    with pytest.raises(HarmonicFaceError, match="expected each number once, got '1-5,3'"):
        parse_people("1-5,3")


@pytest.mark.data
def test_ten_people_have_the_published_numbers_of_photographs(data_dir: Path) -> None:
    people = load_yale_b(data_dir / "yaleb", parse_people("1-10"))
    counts = sum(np.bincount(person.subsets, minlength=6) for person in people)
    assert_array_equal(counts, [0, 70, 120, 120, 140, 190])


@pytest.mark.data
def test_the_light_is_where_the_photograph_is_bright(data_dir: Path) -> None:
    (person,) = load_yale_b(data_dir / "yaleb", [1])
    left_minus_right = person.photographs[:, :, :84].mean(axis=(1, 2)) - person.photographs[:, :, 84:].mean(axis=(1, 2))
    sideways = np.abs(person.lights[:, 0]) > 0.4
    assert (np.sign(left_minus_right) == -np.sign(person.lights[:, 0]))[sideways].all()


@pytest.mark.data
def test_corrupt_photographs_set_aside_are_counted_out(data_dir: Path) -> None:
    (person,) = load_yale_b(data_dir / "yaleb", [11])
    assert len(person.photographs) == len(person.files) == 60
