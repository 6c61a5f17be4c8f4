"""Files that a person is enrolled from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.gallery.enrolled.sources import MeshView, read_lamps, read_mask, read_source, read_surface

PHOTOS = np.random.default_rng(0).uniform(0, 1, (3, 8, 10)).astype(np.float32)


@pytest.fixture
def photos(tmp_path: Path) -> list[Path]:
    for index, photo in enumerate(PHOTOS):
        np.save(tmp_path / f"{index}.npy", photo)
    return sorted(tmp_path.glob("*.npy"))


def test_photographs_are_stacked_as_they_are(photos: list[Path]) -> None:
    assert np.array_equal(read_source(photos, MeshView(), "linear", 64), PHOTOS)


def test_photographs_of_unlike_sizes(photos: list[Path], tmp_path: Path) -> None:
    np.save(tmp_path / "9.npy", PHOTOS[0, :5])
    with pytest.raises(hf.HarmonicFaceError, match=r"9\.npy: expected the size of .*0\.npy, \(8, 10\), got \(5, 10\)"):
        read_source([*photos, tmp_path / "9.npy"], MeshView(), None, 64)


def test_a_view_belongs_to_a_mesh(photos: list[Path]) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="the options of a view with one mesh only"):
        read_source(photos, MeshView(size=8), None, 64)


def test_a_transfer_belongs_to_photographs(tmp_path: Path) -> None:
    hf.synthetic_person(0, 16).save(tmp_path / "a.npz")
    with pytest.raises(hf.HarmonicFaceError, match="transfer: expected it with photographs only"):
        read_source([tmp_path / "a.npz"], MeshView(), "linear", 64)
    loaded = read_source([tmp_path / "a.npz"], MeshView(), None, 64)
    assert isinstance(loaded, hf.Surface)
    assert loaded.shape == (16, 16)


def test_a_mesh_is_seen_at_the_usual_size_or_at_another(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert read_surface(tmp_path / "a.obj", MeshView(), 32).shape == (32, 32)
    assert read_surface(tmp_path / "a.obj", MeshView(size=8), 32).shape == (8, 8)


def test_points_are_told_from_photographs(tmp_path: Path, photos: list[Path]) -> None:
    down, right = np.mgrid[-1:1:9j, -1:1:9j].reshape(2, -1)
    table = np.column_stack([right, down, np.zeros((81, 3)), np.ones(81)])
    np.save(tmp_path / "points.npy", table)
    np.savetxt(tmp_path / "points.xyz", table)
    np.save(tmp_path / "coloured.npy", np.column_stack([table, np.full((81, 3), 255.0)]))
    for name in ("points.npy", "points.xyz", "coloured.npy"):
        found = read_source([tmp_path / name], MeshView(size=8), None, 64)
        assert isinstance(found, hf.Surface)
        assert found.shape == (8, 8)
    assert np.array_equal(read_source(photos[:1], MeshView(), None, 64), PHOTOS[:1])
    (tmp_path / "no.npy").write_text("a face")
    for name in ("no.npy", "none.npy"):
        with pytest.raises(hf.HarmonicFaceError, match=rf"{name}: expected an? (whole )?image"):
            read_source([tmp_path / name], MeshView(), None, 64)


def test_a_mesh_before_a_pinhole(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    near, far = (
        read_surface(tmp_path / "a.obj", MeshView(32, intrinsics=(32, 32, 16, 16), distance=distance), 64)
        for distance in (1.0, 2.0)
    )
    assert near.mask.sum() > 3.5 * far.mask.sum()


def test_a_mask_is_what_is_lighter_than_half(tmp_path: Path) -> None:
    picture = np.array([[0.0, 0.4], [0.6, 1.0]], np.float32)
    hf.write_image(tmp_path / "grey.png", picture, transfer="linear")
    hf.write_image(tmp_path / "colour.png", np.repeat(picture[..., None], 3, axis=2), transfer="linear")
    for name in ("grey.png", "colour.png"):
        assert read_mask(tmp_path / name).tolist() == [[False, False], [True, True]]


def test_lamps_are_directions_times_intensities_by_name(tmp_path: Path) -> None:
    file = tmp_path / "lamps.txt"
    file.write_text("b.png 0 0 1 2\na.png 0.6 0 0.8 0.5\n")
    assert np.allclose(read_lamps(file, [tmp_path / "a.png", tmp_path / "b.png"]), [[0.3, 0, 0.4], [0, 0, 2]])
    file.write_text("0 0 1\n1 0 0\n")
    assert np.array_equal(read_lamps(file, [tmp_path / "a.png", tmp_path / "b.png"]), [[0, 0, 1], [1, 0, 0]])


@pytest.mark.parametrize(
    ("line", "got"),
    [("0 0 1 1 0.9 0.8", "an intensity for each colour"), ("3 0 0 0 0 0 0 0 0", "harmonic coefficients")],
)
def test_lights_that_are_no_lamps(tmp_path: Path, line: str, got: str) -> None:
    file = tmp_path / "lamps.txt"
    file.write_text(line)
    with pytest.raises(hf.HarmonicFaceError, match=f"expected a direction and at most one intensity.*got {got}"):
        read_lamps(file, [tmp_path / "a.png"])
