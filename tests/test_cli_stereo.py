"""The command `stereo`: photographs to a folder, and one line for whatever it cannot do."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from harmonicface.cli import main
from harmonicface.io.lights_file import read_lights_file
from harmonicface.io.meshes import read_mesh
from harmonicface.surfaces.surface import Surface

SIZE, RADIUS = 48, 20.0
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE]
X, Y = (COLUMNS - SIZE / 2 + 0.5) / RADIUS, (SIZE / 2 - 0.5 - ROWS) / RADIUS
MASK = X**2 + Y**2 < 0.9
NORMALS = np.stack([X, Y, np.sqrt(np.maximum(1 - X**2 - Y**2, 0.05))], axis=2)
NORMALS /= np.linalg.norm(NORMALS, axis=2, keepdims=True)
LAMPS = np.array(
    [[0, 0, 1], [0.5, 0, 0.8], [-0.5, 0.2, 0.8], [0, 0.6, 0.8], [0.1, -0.6, 0.8], [0.4, 0.4, 0.8], [-0.4, -0.4, 0.8]]
)
LAMPS /= np.linalg.norm(LAMPS, axis=1, keepdims=True)
EXPECTED = {
    "normals.npy", "normals.png", "albedo.png", "depth.png", "residual.png", "confidence.png", "relit.png", "mask.png",
    "surface.npz", "mesh.glb", "lights.txt", "results.json", "report.html",
}  # fmt: skip


@dataclass
class Answer:
    code: int
    out: str
    err: str


Run = Callable[..., Answer]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    def called(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["harmonicface", "stereo", *map(str, arguments)])
        capsys.readouterr()
        code = 0
        try:
            main()
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        said = capsys.readouterr()
        return Answer(code, said.out, said.err)

    return called


def photographs(folder: Path, colour: bool = True, shape: np.ndarray = NORMALS) -> Path:
    """Write 16-bit photographs of a ball of two colours before black, and a lights file."""
    folder.mkdir(parents=True, exist_ok=True)
    albedo = np.where(X[..., None] > 0, [0.6, 0.4, 0.2], [0.2, 0.4, 0.6]) * MASK[..., None]
    for number, lamp in enumerate(LAMPS):
        picture = albedo * np.maximum(shape @ lamp, 0)[..., None]
        stored = np.rint(picture * 65535).astype(np.uint16)
        cv2.imwrite(str(folder / f"photo_{number}.png"), stored[..., ::-1] if colour else stored[..., 1])
    np.savetxt(folder / "lights.txt", LAMPS, header="x y z")
    return folder


@pytest.fixture(scope="session")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return photographs(tmp_path_factory.mktemp("photographs") / "ball")


def mean_angle(folder: Path) -> float:
    found = np.load(folder / "normals.npy")
    seen = MASK & found.any(axis=2)
    return float(np.degrees(np.arccos(np.clip((found * NORMALS).sum(axis=2)[seen], -1, 1))).mean())


def test_a_folder_with_its_lights(run: Run, ball: Path, tmp_path: Path) -> None:
    answer = run(ball, "--out", tmp_path / "out")
    assert answer.code == 0, answer.err
    assert "Determined:" in answer.out and "lights.txt" in answer.out and "Report: " in answer.out
    assert {file.name for file in (tmp_path / "out").iterdir()} == EXPECTED
    assert mean_angle(tmp_path / "out") < 0.2
    surface = Surface.load(tmp_path / "out" / "surface.npz")
    assert surface.albedo.ndim == 3 and surface.depth is not None
    inner = X**2 + Y**2 < 0.4
    ratio = surface.albedo[inner & (X > 0.1)] / [0.6, 0.4, 0.2]
    assert np.ptp(ratio) < 0.02 * ratio.mean()
    mesh = read_mesh(tmp_path / "out" / "mesh.glb")
    assert len(mesh.vertices) == surface.mask.sum() and len(mesh.textures) == 1
    found = read_lights_file(tmp_path / "out" / "lights.txt")
    np.testing.assert_allclose(found.directions, LAMPS, atol=1e-5)


def test_its_lights_file_is_taken_again(run: Run, ball: Path, tmp_path: Path) -> None:
    run(ball, "--out", tmp_path / "one")
    answer = run(ball, "--out", tmp_path / "two", "--lights", tmp_path / "one" / "lights.txt")
    assert answer.code == 0, answer.err
    np.testing.assert_allclose(
        np.load(tmp_path / "two" / "normals.npy"), np.load(tmp_path / "one" / "normals.npy"), atol=1e-4
    )


def test_json_is_one_object(run: Run, ball: Path, tmp_path: Path) -> None:
    answer = run(ball, "--out", tmp_path, "--json")
    told = json.loads(answer.out)
    assert (
        told["model"] == "linear3" and told["ambiguity"]["name"] == "none" and told["photographs"][0] == "photo_0.png"
    )
    assert set(told["files"]) == EXPECTED and len(told["lights"]) == 7
    stored = json.loads((tmp_path / "results.json").read_text())
    assert stored["residual_rms"] == told["residual_rms"] < 1e-3


def test_the_page_needs_no_other_file_and_says_what_is_open(run: Run, ball: Path, tmp_path: Path) -> None:
    run(ball, "--out", tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "<img" in page and 'src="' in page and 'src="data:image/png' in page
    assert page.count('src="') == page.count('src="data:image/png')
    assert "What was determined" in page and "What was not" in page and "The distance to the camera" in page
    assert "$" not in page.replace("$0", "")


@pytest.mark.parametrize(
    "options",
    [
        ("--method", "least-squares"),
        ("--integration", "bilateral", "--mesh", "obj,ply"),
        ("--integration", "weighted", "--pixel-size", "0.5"),
        ("--integration", "none"),
        ("--intrinsics", "300,300,24,24", "--distance", "2"),
        ("--mask", "all"),
        ("--reduce", "2"),
        ("--register",),
        ("--saturation", "0.9", "--transfer", "linear"),
    ],
)
def test_every_option_gives_a_ball(run: Run, ball: Path, tmp_path: Path, options: tuple[str, ...]) -> None:
    answer = run(ball, "--out", tmp_path / "out", *options)
    assert answer.code == 0, answer.err
    surface = Surface.load(tmp_path / "out" / "surface.npz")
    middle = tuple(length // 2 for length in surface.shape)
    assert surface.normals[middle][2] > 0.98
    assert (surface.depth is None) == ("none" in options)
    kinds = {"obj", "ply"} if "obj,ply" in options else set() if "none" in options else {"glb"}
    assert {file.suffix[1:] for file in (tmp_path / "out").glob("mesh.*")} - {"mtl", "png"} == kinds
    if "--distance" in options:
        assert surface.depth is not None and np.nanmean(surface.depth) == pytest.approx(-2, rel=0.01)
    if "--pixel-size" in options:
        assert surface.pixel_size == 0.5


def test_diligent_style_lights(run: Run, ball: Path, tmp_path: Path) -> None:
    place = tmp_path / "rig"
    place.mkdir()
    np.savetxt(place / "light_directions.txt", LAMPS)
    np.savetxt(place / "light_intensities.txt", np.ones((7, 3)))
    answer = run(ball, "--out", tmp_path / "out", "--lights", place)
    assert answer.code == 0, answer.err
    assert mean_angle(tmp_path / "out") < 0.2


def test_a_chrome_ball_tells_the_lights(run: Run, ball: Path, tmp_path: Path) -> None:
    chrome = tmp_path / "chrome"
    chrome.mkdir()
    rows, columns = np.mgrid[:200, :200] + 0.5
    across, up = (columns - 100) / 90, (100 - rows) / 90
    toward = np.sqrt(np.maximum(1 - across**2 - up**2, 0))
    reflected = np.stack([2 * toward * across, 2 * toward * up, 2 * toward**2 - 1], axis=-1)
    disc = across**2 + up**2 < 1
    for number, lamp in enumerate(LAMPS):
        photo = np.where(disc & (reflected @ lamp > np.cos(np.radians(3))), 255, 0).astype(np.uint8)
        cv2.imwrite(str(chrome / f"chrome_{number}.png"), photo)
    cv2.imwrite(str(chrome / "mask.png"), (255 * disc).astype(np.uint8))
    answer = run(ball, "--out", tmp_path / "out", "--ball", chrome)
    assert answer.code == 0, answer.err
    assert "the chrome ball" in answer.out
    assert mean_angle(tmp_path / "out") < 1
    answer = run(ball, "--out", tmp_path / "out", "--ball", chrome, "--circle", "100,100,90")
    assert answer.code == 0, answer.err
    (chrome / "chrome_6.png").unlink()
    answer = run(ball, "--out", tmp_path / "out", "--ball", chrome)
    assert answer.code == 2 and "expected a photograph of the ball for each of 7, got 6" in answer.err


def test_the_script_is_the_command(ball: Path, tmp_path: Path) -> None:
    script = Path(__file__).parents[1] / "scripts" / "photometric_stereo.py"
    done = subprocess.run(
        [sys.executable, script, ball, "--out", tmp_path / "out", "--mask", "none.png"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2 and "none.png" in done.stderr and "No such file" in done.stderr
    assert "Traceback" not in done.stderr


def bad(folder: Path, what: str) -> tuple[object, ...]:
    """Return arguments that ask for something wrong."""
    photos = photographs(folder / "photos")
    lights = photos / "lights.txt"
    if what == "sizes":
        cv2.imwrite(str(photos / "photo_3.png"), np.zeros((SIZE, SIZE + 2), np.uint8))
    elif what == "few":
        return photos / "photo_0.png", photos / "photo_1.png"
    elif what == "few known":
        np.savetxt(folder / "two.txt", LAMPS[:2])
        return photos / "photo_0.png", photos / "photo_1.png", "--lights", folder / "two.txt"
    elif what == "length":
        np.savetxt(lights, LAMPS[:5])
    elif what == "unit":
        np.savetxt(lights, 3 * LAMPS)
    elif what == "zero":
        np.savetxt(lights, LAMPS * (np.arange(7) != 2)[:, None])
    elif what == "empty mask":
        cv2.imwrite(str(photos / "mask.png"), np.zeros((SIZE, SIZE), np.uint8))
    elif what == "mask size":
        cv2.imwrite(str(photos / "mask.png"), np.full((SIZE, SIZE + 1), 255, np.uint8))
    elif what == "nine":
        return photos, "--unknown", "--model", "harmonic9"
    elif what == "intensities":
        np.savetxt(folder / "e.txt", np.ones(3))
        return photos, "--intensities", folder / "e.txt"
    elif what == "twice told":
        np.savetxt(lights, np.column_stack([LAMPS, np.ones(7)]))
        np.savetxt(folder / "e.txt", np.ones(7))
        return photos, "--intensities", folder / "e.txt"
    return (photos,)


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("sizes", "photo_3.png: expected 48 x 48 pixels as photo_0.png has, got 50 x 48"),
        ("few", "expected at least 3"),
        ("few known", "expected at least 3"),
        ("length", "expected a line for each of 7 photographs, got 5 lines"),
        ("unit", "line 1: expected a unit direction (brightness goes into a fourth number), got one of length 3"),
        ("zero", "line 3: expected a unit direction (brightness goes into a fourth number), got zero"),
        ("empty mask", "expected a mask with white in it, got an empty one"),
        ("mask size", "expected a mask of 48 x 48 pixels as the photographs have, got 49 x 48"),
        ("nine", "expected at least 9, as many as harmonic9 has unknowns a pixel, got 7"),
        ("intensities", "expected a line for each of 7 photographs, got 3 lines"),
        ("twice told", "intensities: expected them once"),
    ],
)
def test_bad_photographs_end_in_one_line(run: Run, tmp_path: Path, what: str, message: str) -> None:
    answer = run(*bad(tmp_path, what), "--out", tmp_path / "out")
    assert answer.code == 2
    [line] = [line for line in answer.err.splitlines() if line.startswith("harmonicface: ")]
    assert message in line
    assert "Traceback" not in answer.err and answer.out == ""


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--unknown", "--lights", "x"), "expected one of --lights, --ball, --unknown, got --lights"),
        (("--lights", "x", "--ball", "y"), "got --lights and --ball"),
        (("--distance", "2"), "distance: expected --intrinsics with it"),
        (("--pixel-size", "2", "--intrinsics", "9,9,9,9"), "pixel-size: expected none beside --intrinsics"),
        (("--mesh", "stl"), "mesh: expected glb, obj, ply, got 'stl'"),
        (("--circle", "1,2"), "circle: expected 3 comma-separated numbers"),
        (("--circle", "24,24,9"), "expected a lamp's highlight"),
        (("--integration", "best"), "integration: expected one of"),
        (("--method", "best"), "method: expected one of"),
        (("--model", "best"), "model: expected one of"),
        (("--reduce", "0"), "reduce: expected an integer of at least 1"),
        (("--saturation", "0"), "saturation: expected a number above 0"),
        (("--lights", "none.txt"), "none.txt: expected a text file of lights, got No such file or directory"),
    ],
)
def test_bad_options_end_in_one_line(
    run: Run, ball: Path, tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    answer = run(ball, "--out", tmp_path / "out", *options)
    assert answer.code == 2
    assert message in answer.err and "Traceback" not in answer.err and answer.out == ""


def test_a_thing_before_no_background(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "wall"
    folder.mkdir()
    for number, lamp in enumerate(LAMPS):
        cv2.imwrite(str(folder / f"{number}.png"), np.full((20, 24), round(40000 * lamp[2]), np.uint16))
    np.savetxt(folder / "lights.txt", LAMPS)
    answer = run(folder, "--out", tmp_path / "out", "--mask", "bright")
    assert answer.code == 2 and "expected a thing that stands out from a dark background, got none" in answer.err
    answer = run(folder, "--out", tmp_path / "out")
    assert answer.code == 0 and "no part of the picture stands out" in answer.out
    answer = run(folder, "--out", tmp_path / "out", "--lights", tmp_path)
    assert answer.code == 2 and "expected lights.txt or light_directions.txt in the folder, got neither" in answer.err
    (tmp_path / "file").write_text("")
    answer = run(folder, "--out", tmp_path / "file")
    assert answer.code == 2 and "cannot make the folder" in answer.err
