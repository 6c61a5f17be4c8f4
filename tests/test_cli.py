"""The command line: what each command does, and one line for whatever it cannot do."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import harmonicface as hf
from harmonicface.bench.contenders import METHODS
from tests.command import Run, runner

ADA, EMMY = hf.synthetic_people(2, 24, seed=1)
LAMPS = [hf.lights.from_angles(azimuth, elevation) for azimuth, elevation in ((0, 0), (40, 10), (-30, 20), (10, -30))]
WEDGE = """v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v 0 0 1
vn 0 0 1
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
"""


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(monkeypatch, capsys)


@pytest.fixture
def refused(run: Run) -> Callable[..., str]:
    """Run what cannot be done; return the one line that says why."""

    def called(*arguments: object) -> str:
        answer = run(*arguments)
        assert answer.code == 2
        assert answer.out == ""
        assert answer.err.endswith("\n")
        assert answer.err.count("\n") == 1, answer.err
        assert answer.err.startswith("harmonicface: ")
        return answer.err

    return called


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """Two people, photographs of them, a mesh, and files that are none of these."""
    ADA.save(tmp_path / "ada.npz")
    EMMY.save(tmp_path / "emmy.npz")
    for number, lamp in enumerate(LAMPS):
        hf.write_image(tmp_path / f"ada{number}.png", hf.render(ADA, lamp))
        hf.write_image(tmp_path / f"emmy{number}.png", hf.render(EMMY, lamp))
    hf.write_image(tmp_path / "small.png", np.ones((5, 4)))
    hf.write_image(tmp_path / "black.png", np.zeros((24, 24)))
    (tmp_path / "wedge.obj").write_text(WEDGE)
    np.savez(tmp_path / "other.npz", values=np.ones(3))
    (tmp_path / "text.png").write_text("a picture")
    yield tmp_path


@pytest.fixture
def people(run: Run, folder: Path) -> Path:
    assert run("enroll", folder / "people.gallery", "ada", folder / "ada.npz").code == 0
    assert run("enroll", folder / "people.gallery", "emmy", folder / "emmy.npz").code == 0
    return folder / "people.gallery"


def test_a_process_of_its_own_ends_in_one_line_and_code_two(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "from harmonicface.cli import main; main()", "match", "none.gallery", "none.png"]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert ended.returncode == 2
    assert ended.stdout == ""
    assert ended.stderr == "harmonicface: expected a gallery at none.gallery, got none\n"


def test_help_for_every_command(run: Run) -> None:
    whole = run("--help")
    assert whole.code == 0
    for command in ("bench", "enroll", "match", "images", "evaluate"):
        assert command in whole.out
        shown = run(command, "--help")
        assert shown.code == 0 and "((" not in shown.out
    assert run("evaluate", "yale-b", "--help").code == 0


@pytest.mark.parametrize("arguments", [["frobnicate"], ["images", "x.npz"], ["bench", "--faces", "many"]])
def test_what_the_parser_refuses(run: Run, arguments: list[str]) -> None:
    answer = run(*arguments)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("harmonicface: ")
    assert answer.err.count("\n") == 1


@pytest.mark.parametrize("group", ["gallery", "evaluate"])
def test_a_group_without_a_command_says_what_there_is(run: Run, group: str) -> None:
    answer = run(group)
    assert (answer.code, answer.err) == (2, "")
    assert "Commands" in answer.out


def test_enrolling_and_matching(run: Run, folder: Path, people: Path) -> None:
    assert hf.Gallery.open(people).names == ("ada", "emmy")
    answer = run("match", people, folder / "ada1.png", folder / "emmy1.png")
    assert (answer.code, answer.err) == (0, "")
    lines = answer.out.splitlines()
    assert lines[0].startswith(f"{folder / 'ada1.png'}: ada (")
    (score, distance, name), (next_score, _, next_name) = (line.split() for line in lines[1:3])
    assert (name, next_name) == ("ada", "emmy") and float(score) > float(next_score)
    assert lines[0].removeprefix(f"{folder / 'ada1.png'}: ").startswith(f"ada (score {score}, distance {distance}, ")
    assert lines[3].startswith(f"{folder / 'emmy1.png'}: emmy (")


def test_matching_as_one_json_object(run: Run, folder: Path, people: Path) -> None:
    answer = run("match", people, folder / "ada1.png", folder / "emmy1.png", "--json", "--top", 1)
    assert (answer.code, answer.err, answer.out.count("\n")) == (0, "", 1)
    found = json.loads(answer.out)
    assert set(found) == {"gallery", "matches"}
    expected = hf.Gallery.open(people).match(hf.read_image(folder / "ada1.png"), top=1)
    first = found["matches"][0]
    said = {"photo", "name", "reason", "source", "distance", "margin", "light", "motion", "candidates"}
    assert set(first) == said
    assert (first["reason"], first["source"]) == (None, "surface")
    assert expected.motion is not None
    assert first["motion"] == {part: getattr(expected.motion, part) for part in ("right", "down", "turn", "growth")}
    assert (first["photo"], first["name"]) == (str(folder / "ada1.png"), "ada")
    assert (first["distance"], first["margin"]) == (expected.distance, expected.margin)
    assert expected.light is not None
    assert first["light"] == expected.light.values.tolist()
    score = expected.candidates[0].score
    assert first["candidates"] == [{"name": "ada", "distance": expected.distance, "score": score, "source": "surface"}]
    assert found["matches"][1]["name"] == "emmy"


def test_somebody_unknown(run: Run, folder: Path, people: Path) -> None:
    hf.write_image(folder / "stripes.png", np.tile([0.1, 0.9], (24, 12)))
    answer = run("match", people, folder / "stripes.png")
    assert f"{folder / 'stripes.png'}: unknown (" in answer.out
    found = json.loads(run("match", people, folder / "stripes.png", "--json").out)["matches"][0]
    assert (found["name"], found["motion"]) == (None, None)
    assert answer.out.splitlines()[0].endswith(f"): {found['reason']}")


def test_enrolling_from_photographs(run: Run, folder: Path) -> None:
    gallery = folder / "photographed.gallery"
    answer = run("enroll", gallery, "ada", *(folder / f"ada{number}.png" for number in range(3)))
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == f"ada enrolled; {gallery} holds 1 person\n"
    answer = run("enroll", gallery, "emmy", *(folder / f"emmy{number}.png" for number in range(3)))
    assert answer.out == f"emmy enrolled; {gallery} holds 2 people\n"
    found = json.loads(run("match", gallery, folder / "ada0.png", "--json").out)["matches"][0]
    assert (found["name"], found["light"]) == ("ada", None)


def test_enrolling_from_photographs_under_known_lamps(run: Run, folder: Path) -> None:
    gallery, lamps = folder / "lit.gallery", folder / "lamps.txt"
    for name in ("ada", "emmy"):
        towards = [(f"{name}{number}.png", lamp.directions[0]) for number, lamp in enumerate(LAMPS)]
        lamps.write_text("".join(f"{photo} {x:.6f} {y:.6f} {z:.6f}\n" for photo, (x, y, z) in reversed(towards)))
        photographs = [folder / photo for photo, _ in towards]
        assert run("enroll", gallery, name, *photographs, "--lights", lamps).code == 0
    found = json.loads(run("match", gallery, folder / "ada0.png", "--json").out)["matches"][0]
    assert (found["name"], found["source"]) == ("ada", "lit photographs")


def test_enrolling_a_mesh_at_a_size(run: Run, folder: Path) -> None:
    assert run("enroll", folder / "meshes.gallery", "wedge", folder / "wedge.obj", "--size", 28).code == 0
    assert hf.Gallery.open(folder / "meshes.gallery").mask.shape == (28, 28)
    assert run("enroll", folder / "usual.gallery", "wedge", folder / "wedge.obj").code == 0
    assert hf.Gallery.open(folder / "usual.gallery").mask.shape == (64, 64)


def test_enrolling_a_mesh_before_a_pinhole_and_points(run: Run, folder: Path) -> None:
    gallery, pinhole = folder / "pinhole.gallery", ("--size", 32, "--intrinsics", "32,32,16,16", "--distance", 4)
    assert run("enroll", gallery, "wedge", folder / "wedge.obj", *pinhole).code == 0
    seen = hf.load_surface(folder / "wedge.obj", 32, intrinsics=(32, 32, 16, 16), distance=4)
    alone = hf.Gallery()
    alone.enroll("wedge", seen)
    photo = hf.render(seen, LAMPS[1])
    assert hf.Gallery.open(gallery).match(photo).distance == alone.match(photo).distance
    down, right = np.mgrid[-1:1:40j, -1:1:40j].reshape(2, -1)
    np.savetxt(folder / "points.xyz", np.column_stack([right, down, np.zeros((1600, 2)), -right / 2, np.ones(1600)]))
    assert run("enroll", gallery, "points", folder / "points.xyz", "--size", 32).code == 0
    assert hf.Gallery.open(gallery).names == ("wedge", "points")


def test_images_of_a_saved_surface(run: Run, folder: Path) -> None:
    out = folder / "new" / "pictures"
    answer = run("images", folder / "ada.npz", "--out", out)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == f"9 harmonic images, pictures of the surface, surface.npz and surface.html are in {out}\n"
    modes = ["l0_m+0", "l1_m-1", "l1_m+0", "l1_m+1", "l2_m-2", "l2_m-1", "l2_m+0", "l2_m+1", "l2_m+2"]
    names = [f"harmonic_{number:02d}_{mode}.png" for number, mode in enumerate(modes)]
    parts = ["normals.png", "albedo.png", "depth.png", "mask.png", "surface.npz", "surface.html"]
    assert sorted(path.name for path in out.iterdir()) == sorted([*names, *parts])
    assert "<h1>ada.npz</h1>" in (out / "surface.html").read_text(encoding="utf-8")
    saved = hf.load_surface(out / "surface.npz")
    np.testing.assert_array_equal(saved.normals, ADA.normals)
    np.testing.assert_array_equal(saved.albedo, ADA.albedo)
    pictures = hf.harmonic_images(ADA)
    for name, image in zip(names, pictures, strict=True):
        shown = np.asarray(Image.open(out / name)).astype(int)
        assert shown.shape == (24, 24, 3)
        red_over_blue = (shown[..., 0] - shown[..., 2])[ADA.mask]
        strong = np.abs(image) > 0.1 * np.abs(pictures).max()
        assert (np.sign(red_over_blue[strong]) == np.sign(image[strong])).all()


def test_images_of_a_mesh(run: Run, folder: Path) -> None:
    out = folder / "pictures"
    answer = run("images", folder / "wedge.obj", "--out", out, "--order", 1, "--size", 32, "--frame=-2,-2,2,2")
    assert answer.out.startswith("4 harmonic images, ")
    surface = hf.load_surface(out / "surface.npz")
    assert surface.shape == (32, 32)
    np.testing.assert_allclose(surface.mask.mean(), 0.25, atol=0.02)
    assert not surface.mask[16, 26]
    turned = run(
        "images", folder / "wedge.obj", "--out", out, "--size", 32, "--rotation", "0,0,45", "--frame=-2,-2,2,2"
    )
    assert turned.code == 0
    assert hf.load_surface(out / "surface.npz").mask[16, 26]  # within the corner that was turned there
    camera = ("--size", 32, "--intrinsics", "32,32,16,16", "--distance", 4)
    assert run("images", folder / "wedge.obj", "--out", out, *camera).code == 0
    seen = hf.load_surface(folder / "wedge.obj", 32, intrinsics=(32, 32, 16, 16), distance=4)
    np.testing.assert_array_equal(hf.load_surface(out / "surface.npz").depth, seen.depth)


@pytest.mark.parametrize(("options", "bounces"), [(["--shadows"], 0), (["--bounces", 1], 1)])
def test_images_with_shadows(run: Run, folder: Path, options: list[object], bounces: int) -> None:
    out = folder / "pictures"
    answer = run("images", folder / "ada.npz", "--out", out, "--order", 1, *options)
    assert (answer.code, answer.err) == (0, "")
    saved = hf.load_surface(out / "surface.npz")
    expected = hf.harmonic_images(ADA, 1, shadows=True, bounces=bounces)
    np.testing.assert_allclose(hf.harmonic_images(saved, 1, bounces=bounces, shadows=True), expected, atol=1e-6)
    assert bounces in saved.transports
    assert (out / "ambient_occlusion.png").exists()


def test_images_of_a_black_surface_are_white(run: Run, folder: Path) -> None:
    hf.Surface(ADA.normals, np.zeros_like(ADA.albedo), ADA.mask).save(folder / "black.npz")
    assert run("images", folder / "black.npz", "--out", folder / "pictures").err == ""
    shown = np.asarray(Image.open(folder / "pictures" / "harmonic_00_l0_m+0.png"))
    assert shown[ADA.mask].min() > 240


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["ada0.png"], "expected a mesh (.glb .obj .ply .stl), points with normals"),
        (["other.npz"], "expected a saved Surface, got a file without"),
        (["text.npz"], "expected a saved Surface, got no file"),
        (["none.obj"], "expected a mesh"),
        (["."], "expected a mesh (.glb .obj .ply .stl)"),
        (["wedge.obj", "--size", "0"], "size: expected pixels"),
        (["wedge.obj", "--frame", "1,2"], "frame: expected 4 comma-separated numbers, got '1,2'"),
        (["wedge.obj", "--frame", "5,5,6,6"], "frame"),
        (["wedge.obj", "--rotation", "1,x,3"], "rotation: expected 3 comma-separated numbers, got '1,x,3'"),
        (["wedge.obj", "--rotation", "nan,0,0"], "rotation: expected finite numbers"),
        (["wedge.obj", "--texture", "small.png"], "expected texture coordinates"),
        (["wedge.obj", "--flip-texture"], "flip_texture: expected a texture to flip"),
        (["ada.npz", "--size", "32"], "expected no view of a saved Surface, got size"),
        (["ada.npz", "--rotation", "0,0,0"], "expected no view of a saved Surface, got rotation"),
        (["ada.npz", "--order", "-1"], "order: expected an integer of at least 0, got int -1"),
        (["ada.npz", "--bounces", "-1"], "bounces: expected an integer of at least 0, got int -1"),
    ],
)
def test_images_of_what_is_no_surface(
    refused: Callable[..., str], folder: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], message: str
) -> None:
    monkeypatch.chdir(folder)
    assert message in refused("images", *options, "--out", "pictures")
    assert not Path("pictures").exists()


@pytest.mark.parametrize("out", ["small.png", "small.png/below"])
def test_images_where_there_is_no_folder(
    refused: Callable[..., str], folder: Path, monkeypatch: pytest.MonkeyPatch, out: str
) -> None:
    monkeypatch.chdir(folder)
    assert f"cannot make the folder {out}: " in refused("images", "ada.npz", "--out", out)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["people.gallery", "ada", "ada.npz"], "name: expected one that is not in the gallery yet, got 'ada', who is"),
        (["people.gallery", "", "ada.npz"], "name: expected 1 to 200 printable characters"),
        (["people.gallery", "new", "none.npz"], "expected a saved Surface, got no file none.npz"),
        (["people.gallery", "new", "other.npz"], "other.npz: expected a saved Surface"),
        (["people.gallery", "new", "wedge.obj"], "surface: expected the gallery's shape (24, 24), got (64, 64)"),
        (["people.gallery", "new", "black.png"], "images: expected a picture with something in it"),
        (
            ["people.gallery", "new", "ada0.png", "small.png"],
            "small.png: expected the size of ada0.png, (24, 24), got (5",
        ),
        (["people.gallery", "new", *["small.png"] * 3], "photographs: expected the gallery's shape (24, 24)"),
        (["people.gallery", "new", *["ada.npz"] * 3], "ada.npz: expected an image"),
        (
            ["people.gallery", "new", *["ada0.png"] * 3, "--size", "9"],
            "expected the options of a view with one mesh only",
        ),
        (
            ["people.gallery", "new", *["ada0.png"] * 3, "--flip-texture"],
            "expected the options of a view with one mesh",
        ),
        (["people.gallery", "new", "wedge.obj", "--distance", "4"], "distance: expected intrinsics beside it"),
        (
            ["people.gallery", "new", "wedge.obj", "--intrinsics", "1,2"],
            "intrinsics: expected 4 comma-separated numbers, got '1,2'",
        ),
        (["people.gallery", "new", "ada.npz", "--lights", "none.txt"], "none.txt"),
        ([".", "new", "ada.npz"], "expected a gallery at ., got a folder that is none"),
        (["small.png", "new", "ada.npz"], "small.png: expected a whole file of named arrays"),
        (["none/people.gallery", "new", "ada.npz"], "expected a folder none, got none"),
    ],
)
def test_people_who_cannot_be_enrolled(
    refused: Callable[..., str], people: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.chdir(people.parent)
    before = {one: one.is_file() and one.read_bytes() for one in Path().rglob("*")}
    assert message in refused("enroll", *arguments)
    assert {one: one.is_file() and one.read_bytes() for one in Path().rglob("*")} == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.gallery", "ada0.png"], "expected a gallery at none.gallery, got none"),
        ([".", "ada0.png"], "expected a gallery at ., got a folder that is none"),
        (["ada0.png", "ada0.png"], "expected a whole file of named arrays, got a damaged or foreign one"),
        (["people.gallery", "none.png"], "none.png: expected an image"),
        (["people.gallery", "text.png"], "text.png: expected"),
        (["people.gallery", "wedge.obj"], "wedge.obj: expected an image"),
        (["people.gallery", "small.png"], "small.png: photo: expected the gallery's shape (24, 24), got (5, 4)"),
        (["people.gallery", "ada0.png", "--top", "0"], "top: expected an integer of at least 1, got int 0"),
    ],
)
@pytest.mark.parametrize("json_too", [[], ["--json"]], ids=["", "json"])
def test_what_cannot_be_matched(
    refused: Callable[..., str],
    people: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    message: str,
    json_too: list[str],
) -> None:
    monkeypatch.chdir(people.parent)
    assert message in refused("match", *arguments, *json_too)


SMALL = ["--faces", 3, "--size", 24, "--queries", 1]


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the report's pictures out: drawing them takes seconds."""
    for name in ("explanations_picture", "harmonics_picture", "lights_picture", "tradeoff_picture"):
        monkeypatch.setattr(f"harmonicface.bench.pictures.{name}", lambda *_: b"")


@pytest.mark.usefixtures("no_pictures")
def test_the_main_job(run: Run, tmp_path: Path) -> None:
    answer = run("bench", *SMALL, "--out", tmp_path / "report")
    assert answer.code == 0
    for method in METHODS:
        assert f"\n{method} " in answer.out
    assert answer.out.rstrip().endswith("report.html")
    assert "photographs for the gallery" in answer.err
    assert (tmp_path / "report" / "report.html").is_file()
    assert set(json.loads((tmp_path / "report" / "results.json").read_text())["methods"]) == set(METHODS)


@pytest.mark.usefixtures("no_pictures")
def test_the_main_job_as_one_json_object_and_again_the_same_errors(run: Run, tmp_path: Path) -> None:
    found = []
    for _ in range(2):
        options = ("--methods", "harmonic9, lbph", "--seed", 4, "--json", "--out", tmp_path)
        answer = run("bench", *SMALL, *options)
        assert (answer.code, answer.out.count("\n")) == (0, 1)
        found.append(json.loads(answer.out))
    assert found[0].keys() == json.loads((tmp_path / "results.json").read_text()).keys()
    assert list(found[0]["methods"]) == ["harmonic9", "lbph"]
    assert found[0]["seed"] == 4
    for method in ("harmonic9", "lbph"):
        assert found[0]["methods"][method]["errors"] == found[1]["methods"][method]["errors"]
    assert found[0]["margins"] == found[1]["margins"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--faces", 1], "faces: expected an integer of at least 2, got int 1"),
        (["--size", 3], "size: expected an integer of at least 16, got int 3"),
        (["--seed", -1], "seed: expected an integer of at least 0, got int -1"),
        (["--queries", 0], "queries: expected an integer of at least 1, got int 0"),
        (["--methods", "magic"], "method: expected one of correlation, "),
        (["--methods", ""], "method: expected one of correlation, "),
    ],
)
def test_a_job_that_cannot_be_done(refused: Callable[..., str], tmp_path: Path, options: list, message: str) -> None:
    assert message in refused("bench", *SMALL, *options, "--out", tmp_path / "report")


def test_a_report_that_cannot_be_written_is_known_before_the_work(refused: Callable[..., str], folder: Path) -> None:
    assert "cannot make the folder" in refused("bench", "--faces", 1000, "--out", folder / "small.png")


@pytest.fixture(scope="module")
def yale(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two synthetic people under four lamps each, in the files of Yale B."""
    root = tmp_path_factory.mktemp("yale")
    for number, surface in enumerate(hf.synthetic_people(2, (192, 168), seed=3), start=1):
        (root / f"yaleB{number:02d}").mkdir()
        for azimuth, elevation in ((0, 0), (10, 0), (-5, 10), (35, 15)):
            picture = hf.render(surface, hf.lights.from_angles(-azimuth, elevation))
            levels = np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)
            name = f"yaleB{number:02d}_P00A{azimuth:+04d}E{elevation:+03d}.pgm"
            Image.fromarray(levels).save(root / f"yaleB{number:02d}" / name)
    return root


def test_evaluating(run: Run, yale: Path) -> None:
    answer = run("evaluate", "yale-b", yale, "--methods", "harmonic9,correlation")
    assert answer.code == 0
    rows = [line.split() for line in answer.out.splitlines()]
    assert ["method", "subset", "1", "subset", "3", "ms"] in rows
    assert [row[:3] for row in rows if row and row[0] == "harmonic9"] == [["harmonic9", "0.00", "0.00"]]


def test_evaluating_all_methods(run: Run, yale: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harmonicface.commands.evaluation.YALE_METHODS", ("linear3", "correlation"))
    for options in (("--methods", "all"), ()):
        found = json.loads(run("evaluate", "yale-b", yale, *options, "--json").out)
        assert list(found["methods"]) == ["linear3", "correlation"]


def test_evaluating_as_one_json_object(run: Run, yale: Path) -> None:
    answer = run("evaluate", "yale-b", yale, "--people", "1-2", "--methods", "harmonic9", "--json")
    assert (answer.code, answer.out.count("\n")) == (0, 1)
    found = json.loads(answer.out)
    assert {"protocol", "train", "people", "n", "methods"} < set(found)
    assert (found["protocol"], found["train"], found["people"]) == ("yale-b", "subset1", [1, 2])
    assert found["n"] == {"1": 6, "2": 0, "3": 2, "4": 0, "5": 0}
    nine = found["methods"]["harmonic9"]
    assert {"error_percent", "ms_per_query"} < set(nine)
    assert nine["error_percent"] == {"1": 0.0, "3": 0.0}


def test_evaluating_one_photograph_a_person(run: Run, yale: Path, tmp_path: Path) -> None:
    options = ("--train", "frontal", "--methods", "default,linear3", "--noise", "0.01", "--jpeg", "50")
    answer = run("evaluate", "yale-b", yale, *options, "--out", tmp_path / "report", "--json")
    assert (answer.code, answer.out.count("\n")) == (0, 1)
    found = json.loads(answer.out)
    assert (found["n"]["1"], list(found["methods"]), found["noise"], found["jpeg"]) == (4, ["default"], 0.01, 50)
    assert "left out: linear3: yaleB01: images: expected at least 3 under different lights" in answer.err
    assert (tmp_path / "report" / "report.html").is_file()
    printed = run("evaluate", "yale-b", yale, *options, "--out", tmp_path / "report").out
    assert "Published beside ours" in printed and "report.html" in printed.replace("\n", "")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--people", "rubbish"], "people: expected numbers and ranges such as 1,3,5-7, got 'rubbish'"),
        (["--people", "1"], "people: expected at least two to tell apart, got 1"),
        (["--people", "1,7"], "expected people that are in"),
        (
            ["--train", "magic"],
            "train: expected one of subset1, subset12, nine-lights, frontal, random-half, got 'magic'",
        ),
        (["--methods", "magic"], "method: expected one of correlation, "),
        (["--noise", "-1"], "noise: expected"),
        (["--jpeg", "101"], "jpeg: expected a quality from 1 to 100, got 101"),
    ],
)
def test_what_cannot_be_evaluated(refused: Callable[..., str], yale: Path, options: list[str], message: str) -> None:
    assert message in refused("evaluate", "yale-b", yale, *options)
    assert message in refused("evaluate", "yale-b", yale, *options, "--json")


def test_evaluating_what_is_not_there(refused: Callable[..., str], tmp_path: Path) -> None:
    assert "got no folder" in refused("evaluate", "yale-b", tmp_path / "none")
    assert "expected folders yaleB01" in refused("evaluate", "yale-b", tmp_path)


def test_a_message_of_several_lines_is_printed_as_one(
    refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(**_: object) -> None:
        raise hf.HarmonicFaceError("expected\n  this,\tgot that")

    monkeypatch.setattr("harmonicface.cli.app", failing)
    assert refused() == "harmonicface: expected this, got that\n"


def test_a_new_gallery_takes_a_mask_and_an_old_one_does_not(run: Run, folder: Path, people: Path) -> None:
    inside = np.zeros((24, 24), np.float32)
    inside[4:-4, 4:-4] = 1
    hf.write_image(folder / "mask.png", inside, transfer="linear")
    hf.synthetic_person(3, 24).save(folder / "third.npz")
    assert run("enroll", folder / "new.gallery", "c", folder / "third.npz", "--mask", folder / "mask.png").code == 0
    mask = hf.Gallery.open(folder / "new.gallery").mask
    assert mask is not None
    assert (mask == (inside > 0)).all()
    answer = run("enroll", people, "c", folder / "third.npz", "--mask", folder / "mask.png")
    assert answer.code == 2
    assert "mask: expected it with a new gallery only" in answer.err


def test_linear_photographs_may_be_said_to_be_linear(run: Run, folder: Path, people: Path) -> None:
    as_srgb, as_linear = (
        json.loads(run("match", people, folder / "ada1.png", "--transfer", transfer, "--json").out)["matches"][0]
        for transfer in ("srgb", "linear")
    )
    assert as_srgb["distance"] != as_linear["distance"]
    assert run("match", people, folder / "ada1.png", "--transfer", "gamma").code == 2


def test_an_error_names_the_photograph_and_keeps_the_answers_before_it(run: Run, folder: Path, people: Path) -> None:
    answer = run("match", people, folder / "ada1.png", folder / "small.png")
    assert answer.code == 2
    assert answer.out.startswith(f"{folder / 'ada1.png'}: ada")
    assert answer.err.startswith(f"harmonicface: {folder / 'small.png'}: photo: expected the gallery's shape")


def test_darkness_is_unknown(run: Run, folder: Path, people: Path) -> None:
    answer = run("match", people, folder / "black.png")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"{folder / 'black.png'}: unknown")


def test_one_photograph_enrols(run: Run, folder: Path, people: Path) -> None:
    alone = folder / "alone.gallery"
    assert run("enroll", alone, "ada", folder / "ada0.png").code == 0
    assert run("enroll", alone, "emmy", folder / "emmy0.png").code == 0
    assert run("match", alone, folder / "ada1.png").out.splitlines()[1].endswith("ada")


def test_two_enrolments_at_once_lose_nobody(folder: Path, people: Path) -> None:
    names = [f"extra {index}" for index in range(3)]
    start = [sys.executable, "-c", "from harmonicface.cli import main; main()", "enroll", str(people)]
    writers = [subprocess.Popen([*start, name, str(folder / "ada.npz")], stdout=subprocess.DEVNULL) for name in names]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    assert set(names) <= set(hf.Gallery.open(people).names)
