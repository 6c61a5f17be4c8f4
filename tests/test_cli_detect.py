"""The command line: people found in ordinary photographs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import harmonicface as hf
from tests.command import Run, runner

ADA, EMMY = (hf.synthetic_person(seed, (96, 84)) for seed in (1, 2))
LAMPS = [[0, 0, 1], [0.5, 0.2, 1], [-0.4, 0.3, 1]]


def scene(person: hf.Surface, light: list[float], left: int = 90, top: int = 60) -> np.ndarray:
    """Return a photograph of a person in front of a grey wall."""
    photo = np.full((180, 240), 0.25)
    photo[top : top + 96, left : left + 84][person.mask] = 0.9 * hf.render(person, light)[person.mask]
    return photo


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], folder: Path) -> Run:
    monkeypatch.chdir(folder)
    return runner(monkeypatch, capsys)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Photographs of two people, on their side as a camera stores them for one of them, and of nobody."""
    for name, person in (("ada", ADA), ("emmy", EMMY)):
        for number, lamp in enumerate(LAMPS):
            hf.write_image(tmp_path / f"{name}{number}.png", scene(person, lamp, 60 + 20 * number, 40))
    hf.write_image(tmp_path / "query.png", scene(ADA, [0.2, -0.3, 1]))
    turned = Image.open(tmp_path / "query.png").transpose(Image.Transpose.ROTATE_90)
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise
    turned.save(tmp_path / "query.jpg", quality=95, exif=exif)
    hf.write_image(tmp_path / "wall.png", np.full((60, 90), 0.5))
    hf.write_image(tmp_path / "narrow.png", np.full((9, 90), 0.5))
    ADA.save(tmp_path / "ada.npz")
    return tmp_path


def test_people_are_enrolled_and_matched_where_they_are_found(run: Run) -> None:
    for name in ("ada", "emmy"):
        answer = run("enroll", "people.gallery", name, *(f"{name}{number}.png" for number in range(3)), "--detect")
        assert answer[0] == 0, answer
    assert hf.Gallery.open("people.gallery").mask.shape == (96, 84)
    code, out, _ = run("match", "people.gallery", "query.jpg", "--detect", "--json")
    assert code == 0
    (found,) = json.loads(out)["matches"]
    assert (found["name"], found["source"]) == ("ada", "photographs")
    middle = [found["face"][corner] + found["face"]["side"] / 2 for corner in ("left", "top")]
    np.testing.assert_allclose(middle, [132, 96], atol=10)
    code, out, _ = run("match", "people.gallery", "query.png", "--detect")
    assert out.startswith("query.png: a face of 1")
    assert (code, "seen by" in out, "query.png: " in out.splitlines()[1]) == (0, True, True)
    message = "size: expected the gallery's shape (96, 84), got 64"
    assert message in run("enroll", "people.gallery", "eve", "ada0.png", "--detect", "--size", 64)[2]


def test_faces_are_cut_out_at_a_size(run: Run) -> None:
    answer = run("enroll", "a.gallery", "ada", *(f"ada{n}.png" for n in range(3)), "--detect", "--size", 48)
    assert answer[0] == 0, answer
    assert hf.Gallery.open("a.gallery").mask.shape == (48, 48)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("wall.png", "wall.png: expected a face that looks at the camera, found none"),
        ("narrow.png", "narrow.png: photo: expected at least 24 pixels a side, got (9, 90)"),
        ("ada.npz", "detect: expected it with photographs only, got a mesh, points or Surface"),
    ],
)
def test_where_no_face_can_be_found(run: Run, source: str, message: str) -> None:
    code, out, err = run("enroll", "new.gallery", "ada", source, "--detect")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err
    assert not Path("new.gallery").exists()
    assert run("enroll", "people.gallery", "ada", "ada.npz")[0] == 0
    assert run("match", "people.gallery", "wall.png", "--detect")[::2] == (
        2,
        "harmonicface: wall.png: expected a face that looks at the camera, found none\n",
    )
