"""The folder of pictures of a Surface: what is written, what is read back, and what of an earlier call goes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import harmonicface as hf
from harmonicface.bench import surface_folder
from harmonicface.bench.surface_folder import write_surface_folder
from harmonicface.io.normal_maps import read_normal_map
from harmonicface.surfaces.pictures import harmonic_pictures

PERSON = hf.synthetic_person(3, 16)
PARTS = {"normals.png", "albedo.png", "depth.png", "mask.png", "surface.npz", "surface.html"}


@pytest.fixture
def no_lights(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures under lights out: exact ones take seconds."""
    monkeypatch.setattr("harmonicface.bench.surface_page.light_table", lambda *_: "")


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.usefixtures("no_lights")
def test_everything_is_written_and_comes_back(tmp_path: Path) -> None:
    out = tmp_path / "new" / "pictures"
    assert write_surface_folder(PERSON, out, "Ada") == 9
    modes = ["l0_m+0", "l1_m-1", "l1_m+0", "l1_m+1", "l2_m-2", "l2_m-1", "l2_m+0", "l2_m+1", "l2_m+2"]
    written = [f"harmonic_{number:02d}_{mode}.png" for number, mode in enumerate(modes)]
    assert names(out) == {*written, *PARTS}
    for name, picture in zip(written, harmonic_pictures(PERSON, hf.harmonic_images(PERSON)), strict=True):
        np.testing.assert_array_equal(np.asarray(Image.open(out / name)), np.rint(255 * picture))
    normals = read_normal_map(out / "normals.png")
    assert np.abs(normals - PERSON.normals).max() < 1e-4
    albedo = hf.read_image(out / "albedo.png")
    assert np.abs(albedo - PERSON.albedo).max() < 0.01
    again = hf.surface_from_normals(out / "normals.png", out / "albedo.png")
    np.testing.assert_array_equal(again.mask, PERSON.mask)
    saved = hf.load_surface(out / "surface.npz")
    np.testing.assert_array_equal(saved.normals, PERSON.normals)
    assert saved.transports == {}
    text = (out / "surface.html").read_text(encoding="utf-8")
    assert "harmonic_00_l0_m+0.png to harmonic_08_l2_m+2.png" in text


@pytest.mark.usefixtures("no_lights")
def test_the_transport_is_saved_and_the_open_sky_shown(tmp_path: Path) -> None:
    assert write_surface_folder(PERSON, tmp_path, "Ada", 1, shadows=True) == 4
    saved = hf.load_surface(tmp_path / "surface.npz")
    assert saved.transports[0].order == 1
    np.testing.assert_array_equal(hf.harmonic_images(saved, 1, True), hf.harmonic_images(PERSON, 1, True))
    assert "ambient_occlusion.png" in names(tmp_path)


@pytest.mark.usefixtures("no_lights")
def test_what_an_earlier_call_wrote_goes_and_nothing_else(tmp_path: Path) -> None:
    write_surface_folder(PERSON, tmp_path, "Ada", 3, shadows=True)
    mine = {"notes.txt", "harmonic_99_l9_m+9.png", "portrait.png"}
    for name in mine:
        (tmp_path / name).write_bytes(b"mine")
    flat = hf.Surface(PERSON.normals, PERSON.albedo, PERSON.mask)
    write_surface_folder(flat, tmp_path, "Ada", 1)
    found = names(tmp_path)
    assert mine <= found
    assert len([name for name in found - mine if name.startswith("harmonic_")]) == 4
    assert not {"ambient_occlusion.png", "depth.png"} & found
    (tmp_path / "harmonic_00_l0_m+0.png").unlink()  # gone already
    write_surface_folder(flat, tmp_path, "Ada", 0)
    assert len([name for name in names(tmp_path) - mine if name.startswith("harmonic_")]) == 1


@pytest.mark.usefixtures("no_lights")
@pytest.mark.parametrize(
    "listed",
    [b"../keep.png keep.png /keep.png surface.npz/../keep.png", b"\xff\xfe", b"mask.png"],
    ids=["sly", "odd", "gone"],
)
def test_a_page_of_another_kind_removes_nothing(tmp_path: Path, listed: bytes) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for keep in (tmp_path / "keep.png", out / "keep.png"):
        keep.write_bytes(b"mine")
    (out / "surface.html").write_bytes(b'<meta name="harmonicface-files" content="' + listed + b'">')
    write_surface_folder(PERSON, out, "Ada", 0)
    assert names(out) == {"keep.png", "harmonic_00_l0_m+0.png", *PARTS}
    assert (tmp_path / "keep.png").read_bytes() == b"mine"


@pytest.mark.usefixtures("no_lights")
def test_a_folder_that_cannot_be_made_or_cleared(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(hf.HarmonicFaceError, match=r"cannot make the folder .*file"):
            write_surface_folder(PERSON, folder, "Ada", 0)
    write_surface_folder(PERSON, tmp_path, "Ada", 1)
    (tmp_path / "harmonic_03_l1_m+1.png").unlink()
    (tmp_path / "harmonic_03_l1_m+1.png").mkdir()
    with pytest.raises(hf.HarmonicFaceError, match=r"cannot remove .*harmonic_03_l1_m\+1\.png"):
        write_surface_folder(PERSON, tmp_path, "Ada", 0)


def test_nothing_is_written_where_images_are_refused(tmp_path: Path) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="order: expected"):
        write_surface_folder(PERSON, tmp_path / "new", "Ada", -1)
    flat = hf.Surface(PERSON.normals, PERSON.albedo, PERSON.mask)
    with pytest.raises(hf.HarmonicFaceError, match="expected depth"):
        write_surface_folder(flat, tmp_path / "new", "Ada", 1, shadows=True)
    assert names(tmp_path) == set()


def test_numbers_in_names_have_as_many_digits_as_the_last() -> None:
    names_of = surface_folder._pictures(PERSON, np.zeros((121, PERSON.mask.sum())), False)
    assert list(names_of)[:2] == ["harmonic_000_l0_m+0.png", "harmonic_001_l1_m-1.png"]
    assert "harmonic_120_l10_m+10.png" in names_of
