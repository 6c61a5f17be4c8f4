"""The command that shows a face under another light."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.relight import relight
from harmonicface.reflectance.materials import Microfacet, Phong
from tests.command import Run, runner

ADA = hf.synthetic_person(2, 24)
STEP = 1.5 / 255  # of a stored picture's slope toward linear light, half a step
MAP = np.random.default_rng(0).uniform(size=(8, 16, 3)).astype(np.float32)
WEDGE = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], folder: Path) -> Run:
    monkeypatch.chdir(folder)
    return runner(monkeypatch, capsys, "relight")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A person, a mesh, an environment and photographs."""
    ADA.save(tmp_path / "ada.npz")
    (tmp_path / "wedge.obj").write_text(WEDGE)
    np.save(tmp_path / "sky.npy", MAP)
    np.save(tmp_path / "disc.npy", np.ones((16, 16), np.float32))
    np.save(tmp_path / "photo.npy", hf.render(ADA, [1, 0, 2]))
    hf.write_image(tmp_path / "small.png", np.ones((5, 4)))
    hf.write_image(tmp_path / "photo.png", 0.5 * hf.render(ADA, [1, 0, 2]))
    (tmp_path / "text.hdr").write_text("a picture")
    return tmp_path


def assert_shown(path: Path, expected: np.ndarray) -> None:
    """Compare a written picture with what it should show, to the steps of eight bits."""
    shown = hf.read_image(path)
    expected = np.clip(expected if expected.ndim == 3 else np.repeat(expected[..., None], 3, axis=2), 0, 1)
    shown = shown if shown.ndim == 3 else np.repeat(shown[..., None], 3, axis=2)
    assert_allclose(shown, expected, atol=STEP)


@pytest.mark.parametrize(
    ("options", "light", "settings"),
    [
        (["--light", "1,2,3"], [1, 2, 3], {}),
        (["--light", "grace"], "grace", {}),
        (["--light=-1,0,1", "--light", "st_peters"], [[-1, 0, 1], "st_peters"], {}),
        (["--light", "sky.npy"], hf.EnvironmentMap(MAP), {"order": 8}),
        (["--light", "sky.npy", "--order", 2], hf.EnvironmentMap(MAP), {"order": 2}),
        (["--light", "sky.npy", "--exact"], hf.EnvironmentMap(MAP), {}),
        (["--light", "sky.npy", "--light", "0,0,1"], [hf.EnvironmentMap(MAP), [0, 0, 1]], {"order": 8}),
        (["--light", "sky.npy", "--shadows"], hf.EnvironmentMap(MAP), {"order": 4, "shadows": True}),
        (["--light", "disc.npy", "--layout", "angular"], hf.EnvironmentMap(np.ones((16, 16)), "angular"), {"order": 8}),
        (["--light", "1,2,3", "--order", 2, "--shadows"], [1, 2, 3], {"order": 2, "shadows": True}),
        (["--light", "1,2,3", "--shadows"], [1, 2, 3], {"shadows": True}),
        (["--light", "1,2,3", "--order", 2, "--bounces", 1], [1, 2, 3], {"order": 2, "bounces": 1}),
        (["--light", "1,2,3", "--shininess", 20], [1, 2, 3], {"material": Phong(20, 0.04)}),
        (["--light", "1,2,3", "--shininess", 5, "--gloss", 0.5], [1, 2, 3], {"material": Phong(5, 0.5)}),
        (["--light", "1,2,3", "--roughness", 0.3], [1, 2, 3], {"material": Microfacet(0.3)}),
        (
            ["--light", "1,2,3", "--roughness", 0.3, "--gloss", 0.5],
            [1, 2, 3],
            {"material": Microfacet(0.3, strength=0.5)},
        ),
    ],
    ids=lambda value: repr(value) if isinstance(value, list) else "",
)
def test_pictures_of_a_face(
    run: Run, folder: Path, options: list[object], light: object, settings: dict[str, object]
) -> None:
    code, out, err = run("ada.npz", *options, "--out", "relit.png", "--exposure", 0.3)
    assert (code, out, err) == (0, "relit.png: exposure 0.3\n", "")
    assert_shown(folder / "relit.png", 0.3 * hf.render(ADA, light, **settings))  # type: ignore[arg-type]


def test_light_is_turned(run: Run, folder: Path) -> None:
    assert run("ada.npz", "--light", "0,0,1", "--rotate-light", "90,0,0", "--out", "a.png", "--exposure", 1)[0] == 0
    assert_shown(folder / "a.png", hf.render(ADA, [1, 0, 0]))


def test_of_a_hundred_pixels_one_is_white_unless_told_otherwise(run: Run, folder: Path) -> None:
    code, out, _ = run("ada.npz", "--light", "1,1,1", "--out", "a.jpg")
    picture = hf.render(ADA, [1, 1, 1])
    factor = 1 / np.quantile(picture[ADA.mask], 0.99)
    assert (code, out) == (0, f"a.jpg: exposure {factor:.4g}\n")


def test_a_face_without_light_is_black(run: Run, folder: Path) -> None:
    code, out, err = run("ada.npz", "--light", "0,0,-1", "--out", "a.png")
    assert (code, out, err) == (0, "a.png: exposure 1\n", "")
    assert not hf.read_image(folder / "a.png").any()


def test_a_photograph_under_another_light(run: Run, folder: Path) -> None:
    photo = np.load(folder / "photo.npy")
    known = ("--photo", "photo.npy", "--photo-light", "1,0,2")
    assert run("ada.npz", *known, "--light=-1,0,2", "--out", "a.png", "--exposure", 0.5)[0] == 0
    assert_shown(folder / "a.png", 0.5 * relight(photo, ADA, [-1, 0, 2], [1, 0, 2]))
    code, out, _ = run("ada.npz", "--photo", "photo.npy", "--light=-1,0,2", "--out", "b.png")
    expected = relight(photo, ADA, [-1, 0, 2])
    factor = photo[ADA.mask].mean() / expected[ADA.mask].mean()
    assert (code, out) == (0, f"b.png: exposure {factor:.4g}\n")
    assert_shown(folder / "b.png", factor * expected)


def test_a_photograph_with_shadows_goes_by_exact_sums(run: Run, folder: Path) -> None:
    photo, sky = np.load(folder / "photo.npy"), hf.EnvironmentMap(MAP)
    usual = ("ada.npz", "--photo", "photo.npy", "--light", "sky.npy", "--exposure", 0.1)
    assert run(*usual, "--shadows", "--out", "a.png")[0] == 0
    assert_shown(folder / "a.png", 0.1 * relight(photo, ADA, sky, shadows=True))
    assert run(*usual, "--out", "b.png")[0] == 0
    assert_shown(folder / "b.png", 0.1 * relight(photo, ADA, sky, order=8))


def test_a_photograph_under_coloured_light_stays_as_bright(run: Run, folder: Path) -> None:
    assert run("ada.npz", "--photo", "photo.png", "--light", "grace", "--out", "a.png")[0] == 0
    before, after = (hf.read_image(folder / name) for name in ("photo.png", "a.png"))
    shown = after[ADA.mask] @ [0.2126, 0.7152, 0.0722]
    assert_allclose(shown.mean(), before[ADA.mask].reshape(int(ADA.mask.sum()), -1).mean(), rtol=0.02)


def test_photographs_may_be_said_to_be_linear(run: Run, folder: Path) -> None:
    usual = ("ada.npz", "--photo", "photo.png", "--light", "0,0,1", "--exposure", 1)
    assert run(*usual, "--transfer", "linear", "--out", "a.png")[0] == 0
    assert run(*usual, "--out", "b.png")[0] == 0
    for name, transfer in (("a.png", "linear"), ("b.png", "srgb")):
        assert_shown(folder / name, relight(hf.read_image(folder / "photo.png", transfer), ADA, [0, 0, 1]))


def test_meshes_are_seen_as_large_as_the_photograph(run: Run, folder: Path) -> None:
    hf.write_image(folder / "wide.png", np.full((20, 30), 0.5))
    frame = "--frame=-2,-2,2,2"
    assert run("wedge.obj", frame, "--light", "0,0,1", "--photo", "wide.png", "--out", "a.png")[0] == 0
    assert hf.read_image(folder / "a.png").shape[:2] == (20, 30)
    assert run("wedge.obj", frame, "--light", "0,0,1", "--out", "b.png")[0] == 0
    assert hf.read_image(folder / "b.png").shape[:2] == (256, 256)
    assert run("wedge.obj", frame, "--light", "0,0,1", "--size", 32, "--out", "c.png")[0] == 0
    assert hf.read_image(folder / "c.png").shape[:2] == (32, 32)


def test_a_mesh_before_a_pinhole(run: Run, folder: Path) -> None:
    camera = ("--size", 32, "--intrinsics", "32,32,16,16", "--distance", 4)
    assert run("wedge.obj", *camera, "--light", "0,0,1", "--exposure", 1, "--out", "a.png")[0] == 0
    seen = hf.load_surface(folder / "wedge.obj", 32, intrinsics=(32, 32, 16, 16), distance=4)
    assert_shown(folder / "a.png", hf.render(seen, [0, 0, 1]))


def test_help_says_what_a_light_may_be(run: Run) -> None:
    code, out, _ = run("--help")
    assert code == 0
    for word in ("--light", "eucalyptus", "--photo", "--shadows", "--bounces", "--shininess", "--rotate-light"):
        assert word in out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["ada.npz", "--light", "noon"],
            "light: expected the path of a file, one of grace, eucalyptus, st_peters, or a",
        ),
        (["ada.npz", "--light", "1,2"], "light: expected the path of a file"),
        (["ada.npz", "--light", "1,2,x"], "light: expected 3 comma-separated numbers, got '1,2,x'"),
        (["ada.npz", "--light", "0,0,0"], "directions: expected directions, got a vector of zero length"),
        (["ada.npz", "--light", "a" * 300], "light: expected the path of a file"),
        (["ada.npz", "--light", "text.hdr"], "text.hdr: expected"),
        (["ada.npz", "--light", "disc.npy"], "expected a map twice as wide as high"),
        (["ada.npz", "--light", "disc.npy", "--layout", "globe"], "layout: expected one of"),
        (["ada.npz", "--light", "0,0,1", "--rotate-light", "1,2"], "rotate-light: expected 3 comma-separated numbers"),
        (["none.npz", "--light", "0,0,1"], "expected a saved Surface, got no file none.npz"),
        (["text.hdr", "--light", "0,0,1"], "expected a mesh"),
        (["ada.npz", "--light", "0,0,1", "--order", -1], "order: expected an integer of at least 0"),
        (["ada.npz", "--light", "0,0,1", "--order", 2, "--exact"], "expected --order or --exact, got both"),
        (["ada.npz", "--light", "0,0,1", "--bounces", -1], "bounces: expected an integer of at least 0"),
        (["ada.npz", "--light", "0,0,1", "--shininess", -1], "shininess: expected a finite number of at least 0"),
        (["ada.npz", "--light", "0,0,1", "--roughness", 0], "roughness: expected a finite number above 0"),
        (
            ["ada.npz", "--light", "0,0,1", "--shininess", 1, "--roughness", 1],
            "expected --shininess or --roughness, got b",
        ),
        (
            ["ada.npz", "--light", "0,0,1", "--gloss", 1],
            "gloss: expected --shininess or --roughness with it, got neither",
        ),
        (["ada.npz", "--light", "0,0,1", "--shininess", 1, "--gloss", 2], "strength: expected a number from 0 to 1"),
        (["ada.npz", "--light", "0,0,1", "--exposure", 0], "exposure: expected a finite number above 0"),
        (["ada.npz", "--light", "0,0,1", "--photo-light", "0,0,1"], "photo-light: expected --photo with it, got none"),
        (["ada.npz", "--light", "0,0,1", "--transfer", "srgb"], "transfer: expected --photo with it, got none"),
        (["ada.npz", "--light", "0,0,1", "--photo", "none.png"], "none.png: expected an image"),
        (["ada.npz", "--light", "0,0,1", "--photo", "small.png"], "photo: expected shape (24, 24) or (24, 24, 3)"),
        (["ada.npz", "--light", "0,0,1", "--size", 9], "expected no view of a saved Surface, got size"),
        (["ada.npz"], "Missing option '--light'"),
    ],
)
def test_what_cannot_be_relit(run: Run, folder: Path, options: list[object], message: str) -> None:
    code, out, err = run(*options, "--out", "relit.png")
    assert (code, out) == (2, "")
    assert err.startswith("harmonicface: ")
    assert err.count("\n") == 1
    assert message in err
    assert not (folder / "relit.png").exists()


def test_pictures_of_another_kind_are_refused_before_the_work(run: Run) -> None:
    code, out, err = run("none.npz", "--light", "0,0,1", "--out", "relit.exr")
    assert (code, out) == (2, "")
    assert err == "harmonicface: out: expected a name that ends in .png, .jpg, .jpeg, got relit.exr\n"
