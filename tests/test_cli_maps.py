"""From a depth map or a normal map to pictures in one command, and what of it is refused in one line."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.cli import main
from harmonicface.io.images import write_image
from harmonicface.io.normal_maps import write_normal_map

ADA = hf.synthetic_person(1, 24)
HEIGHTS = np.where(ADA.mask, 1000 + np.rint(100 * np.nan_to_num(ADA.depth)), 0).astype(np.uint16)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    cv2.imwrite(str(tmp_path / "height.png"), HEIGHTS)
    write_normal_map(tmp_path / "normals.png", ADA.normals)
    write_image(tmp_path / "albedo.png", ADA.albedo)
    monkeypatch.setattr("harmonicface.bench.surface_page.light_table", lambda *_: "")
    return tmp_path


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    monkeypatch.setattr(sys, "argv", ["harmonicface", *map(str, arguments)])
    with pytest.raises(SystemExit) as leaving:
        main()
    return int(leaving.value.code or 0)


def test_images_of_a_depth_map(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    options = ("--depth-map", "height", "--depth-scale", 0.01, "--pixel-size", 1, "--albedo", folder / "albedo.png")
    assert run(monkeypatch, "images", folder / "height.png", "--out", folder / "out", "--shadows", *options) == 0
    found = hf.load_surface(folder / "out" / "surface.npz")
    both = found.mask & ADA.mask
    assert both.sum() > 0.9 * ADA.mask.sum()
    assert_allclose(np.ptp(found.depth[both]), np.ptp(HEIGHTS[both]) / 100, rtol=1e-5)
    assert_allclose(found.albedo[both], hf.read_image(folder / "albedo.png")[both])
    assert found.transports[0].order == 2


def test_images_of_distances_before_a_pinhole(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    options = ("--depth-map", "distance", "--depth-scale", 0.001, "--intrinsics", "40,40,12,12")
    assert run(monkeypatch, "images", folder / "height.png", "--out", folder / "out", *options) == 0
    found = hf.load_surface(folder / "out" / "surface.npz")
    assert found.depth[found.mask].max() == pytest.approx(-int(HEIGHTS[found.mask].min()) / 1000)


def test_a_normal_map_is_relit(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    shown = []
    for green in ("up", "down"):
        out = folder / f"{green}.png"
        options = ("--normal-map", "--green", green, "--albedo", folder / "albedo.png", "--exposure", 1)
        light = ("--light", "0,1,0.2", "--out", out)
        assert run(monkeypatch, "relight", folder / "normals.png", *light, *options) == 0
        shown.append(hf.read_image(out))
    surface = hf.surface_from_normals(folder / "normals.png", folder / "albedo.png")
    expected = hf.render(surface, [0, 1, 0.2])
    grey = shown[0] if shown[0].ndim == expected.ndim else shown[0][..., 0]
    assert_allclose(grey, expected.clip(0, 1), atol=0.01)
    assert np.abs(shown[1] - shown[0]).max() > 0.1


def test_a_mesh_that_is_left_behind_is_told_of(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, folder: Path
) -> None:
    path = tmp_path / "tent.obj"
    path.write_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n", encoding="ascii")
    for shadows, told in (([], True), (["--shadows"], False)):
        assert run(monkeypatch, "images", path, "--out", folder / "out", "--size", 8, *shadows) == 0
        assert ("shadows will be those of its depth" in capsys.readouterr().out) is told


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--depth-map", "depth"], "kind: expected 'distance' or 'height', got 'depth'"),
        (["--depth-map", "height", "--normal-map"], "expected --depth-map or --normal-map, got both"),
        (["--depth-scale", 2], "depth-scale: expected --depth-map with it, got none"),
        (["--normal-map", "--depth-scale", 2], "depth-scale: expected --depth-map with it, got none"),
        (["--depth-map", "height", "--green", "up"], "green: expected --normal-map with it, got none"),
        (["--pixel-size", 2], "pixel-size: expected --depth-map or --normal-map with it, got none"),
        (["--albedo", "a.png"], "albedo: expected --depth-map or --normal-map with it, got none"),
        (["--depth-map", "height", "--size", 9], "expected no view of a map, whose pixels are fixed, got size"),
        (["--normal-map", "--intrinsics", "9,9,4,4"], "expected no view of a map, .* got intrinsics"),
        (["--order", 99], "order: expected at most 12, which are 169 pictures, got 99"),
        (["--order", -1], "order: expected an integer of at least 0"),
    ],
)
def test_bad_options_are_one_line(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    folder: Path,
    options: list[object],
    message: str,
) -> None:
    assert run(monkeypatch, "images", folder / "height.png", "--out", folder / "out", *options) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert re.search(message, said), said
    assert not (folder / "out").exists()


@pytest.mark.filterwarnings("default")
def test_slow_rays_are_one_line_on_standard_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    monkeypatch.setattr("harmonicface.surfaces.rays.SLOW", 100)
    monkeypatch.setattr("harmonicface.surfaces.rays._told", False)
    path = tmp_path / "tent.obj"
    path.write_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n", encoding="ascii")
    options = ("--light", "0,0.5,1", "--shadows", "--size", 12, "--out", tmp_path / "out.png")
    assert run(monkeypatch, "relight", path, *options) == 0
    said = capsys.readouterr().err
    assert said.startswith("harmonicface: more than 100 rays without embreex")
    assert said.count("\n") == 1
