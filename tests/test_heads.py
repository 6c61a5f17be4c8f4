"""Scanned heads under measured light: the whole way from mesh files to a name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.io.colour import luminance

SIZE = 64
SCAN_FRAME = (-1.524, -0.479, 1.364, 2.409)  # brow to chin in the scan's own units
ICT_FRAME = (-8.0, -8.5, 8.0, 7.5)  # the same part of the ICT heads, in cm
LAMPS = ((30.0, 0.0), (-60.0, 20.0), (0.0, 45.0), (75.0, 0.0))  # azimuth and elevation in degrees


def same_albedo(surface: hf.Surface) -> hf.Surface:
    """A shape without its colours: shape alone must tell people apart."""
    uniform = np.where(surface.mask, np.float32(0.5), np.float32(0))
    return hf.Surface(surface.normals, uniform, surface.mask, surface.depth, surface.pixel_size)


@pytest.fixture(scope="module")
def scan(data_dir: Path) -> hf.Surface:
    folder = data_dir / "heads" / "LeePerrySmith"
    return hf.load_surface(
        folder / "LeePerrySmith.glb", SIZE, texture=folder / "Map-COL.jpg", flip_texture=True, frame=SCAN_FRAME
    )


@pytest.fixture(scope="module")
def heads(data_dir: Path, scan: hf.Surface) -> dict[str, hf.Surface]:
    files = sorted((data_dir / "heads" / "ICT-FaceKit" / "FaceXModel").glob("*.obj"))
    ict = {file.stem: hf.load_surface(file, SIZE, frame=ICT_FRAME) for file in files}
    return {name: same_albedo(surface) for name, surface in {"scan": scan, **ict}.items()}


@pytest.fixture(scope="module")
def lights(data_dir: Path) -> dict[str, hf.Light]:
    probes = sorted((data_dir / "probes" / "latlong").glob("*.hdr"))
    environments: dict[str, hf.Light] = {path.stem: hf.EnvironmentMap.load(path).grey() for path in probes}
    return environments | {f"lamp at {angles}": hf.lights.from_angles(*angles) for angles in LAMPS}


@pytest.mark.data
def test_each_head_is_found_under_each_light(heads: dict[str, hf.Surface], lights: dict[str, hf.Light]) -> None:
    assert (len(heads), len(lights)) == (18, 7)
    photos = {
        (name, where): hf.render(surface, light) for where, light in lights.items() for name, surface in heads.items()
    }
    for model in ("harmonic9", "default"):
        gallery = hf.Gallery(model)
        for name, surface in heads.items():
            gallery.enroll(name, surface)
        found = {asked: gallery.match(photo) for asked, photo in photos.items()}
        wrong = {
            asked: match.candidates[0].name for asked, match in found.items() if match.candidates[0].name != asked[0]
        }
        assert not wrong, model


@pytest.mark.data
def test_scan_is_a_colour_face(scan: hf.Surface) -> None:
    red, green, blue = (float(np.median(scan.pixel_albedo[:, channel])) for channel in range(3))
    assert red > green > blue  # skin
    assert 0.02 < float(np.median(luminance(scan.pixel_albedo))) < 0.9
