"""Point clouds: what PLY files and tables say, and what they must not."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from harmonicface import _memory
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.point_clouds import is_point_cloud, read_point_cloud
from harmonicface.io.transfer import srgb_to_linear

RNG = np.random.default_rng(0)
POINTS = RNG.normal(size=(30, 3)).astype(np.float32)
NORMALS = (POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)).astype(np.float32)
COLOURS = RNG.integers(0, 256, (30, 3), dtype=np.uint8)


def ply(form="binary_little_endian", colours="u1", names="x y z nx ny nz", faces=""):
    order = ">" if "big" in form else "<"
    kinds = {"u1": "uchar", "u2": "ushort", "f4": "float"}
    fields = [(name, order + "f4") for name in names.split()]
    lines = ["ply", f"format {form} 1.0", "element vertex 30", *(f"property float {name}" for name, _ in fields)]
    if colours:
        fields += [(name, order + colours) for name in ("red", "green", "blue")]
        lines += [f"property {kinds[colours]} {name}" for name in ("red", "green", "blue")]
    table = np.zeros(30, dtype=fields)
    for number, (name, _) in enumerate(fields[:6]):
        table[name] = np.hstack([POINTS, NORMALS])[:, number]
    for number, name in enumerate(("red", "green", "blue") if colours else ()):
        table[name] = COLOURS[:, number].astype(float) * {"u1": 1, "u2": 257, "f4": 1 / 255}[colours]
    header = "\n".join([*lines, *faces.split("\n")] if faces else lines) + "\nend_header\n"
    body = "\n".join(" ".join(f"{value:.9g}" for value in row) for row in table).encode() + b"\n"
    return header.encode() + (body if form == "ascii" else table.tobytes())


def written(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("colours", ["u1", "u2", "f4", ""])
def test_a_ply_without_faces_is_a_point_cloud(tmp_path, form, colours):
    path = written(tmp_path, "a.ply", ply(form, colours))
    assert is_point_cloud(path)
    cloud = read_point_cloud(path)
    np.testing.assert_allclose(cloud.points, POINTS, rtol=1e-6)
    np.testing.assert_allclose(cloud.normals, NORMALS, atol=1e-6)
    if colours:
        np.testing.assert_allclose(cloud.albedo, srgb_to_linear(COLOURS / 255), atol=1e-5)
    else:
        assert cloud.albedo is None


def test_tables_of_text_and_numpy(tmp_path):
    table = np.hstack([POINTS, 3 * NORMALS, COLOURS])
    np.save(tmp_path / "a.npy", table)
    np.savetxt(tmp_path / "a.xyz", table, fmt="%.9g", header="x y z nx ny nz r g b")
    np.savetxt(tmp_path / "commas.XYZ", table, fmt="%.9g", delimiter=", ")
    for name in ("a.npy", "a.xyz", "commas.XYZ"):
        cloud = read_point_cloud(tmp_path / name)
        np.testing.assert_allclose(cloud.points, POINTS, rtol=1e-6)
        np.testing.assert_allclose(cloud.normals, NORMALS, atol=1e-6)
        np.testing.assert_allclose(cloud.albedo, srgb_to_linear(COLOURS / 255), atol=1e-6)
    np.save(tmp_path / "b.npy", table[:, :6])
    assert read_point_cloud(tmp_path / "b.npy").albedo is None


def test_meshes_and_missing_files_are_no_point_clouds(tmp_path):
    trimesh.creation.icosphere(1).export(tmp_path / "a.ply")
    assert not is_point_cloud(tmp_path / "a.ply")
    assert not is_point_cloud(tmp_path / "none.ply")
    assert not is_point_cloud(tmp_path / "a.obj")
    with pytest.raises(HarmonicFaceError, match="expected points without faces, got 80 faces"):
        read_point_cloud(tmp_path / "a.ply")


ROW = "0 0 0 0 0 1"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.txt", ROW, r"expected a point cloud \(\.ply \.xyz \.npy\), got '\.txt'"),
        ("a.xyz", "", "expected a table of points, got an empty file$"),
        ("a.xyz", "# none\n", "cut short or corrupt$"),
        ("a.xyz", "0 0 0\n1 1 1\n", "expected rows of x y z nx ny nz"),
        ("a.xyz", f"{ROW}\n0 0 0 0 1\n", "cut short or corrupt"),
        ("a.xyz", f"{ROW}\n0 0 0 zero 0 1\n", "cut short or corrupt"),
        ("a.xyz", "0 0 nan 0 0 1\n", "points: expected finite"),
        ("a.xyz", "0 0 0 0 0 0\n", "normals: expected directions, got a vector of zero length"),
        ("a.xyz", f"{ROW} 0.5 0 0\n", "expected colours of whole numbers from 0 to 255"),
        ("a.xyz", f"{ROW} 256 0 0\n", "expected colours of whole numbers from 0 to 255"),
        ("a.xyz", f"{ROW} nan 0 0\n", "expected colours of whole numbers from 0 to 255"),
        ("a.npy", b"\x93NUMPY", "cut short or corrupt"),
        ("a.ply", ply(names="x y z"), "expected points with normals .nx ny nz., got a PLY without nx ny nz"),
        ("a.ply", ply().replace(b"vertex 30", b"vertex 31"), "cut short"),
        ("a.ply", ply().replace(b"vertex 30", b"vertex 0"), "expected at least one point, got none"),
        ("a.ply", ply("ascii", "f4").replace(b"vertex 30", b"vertex 29"), None),
        ("a.ply", ply("binary_little_endian", "u1").replace(b"float nx", b"list uchar int nx"), "cut short or corrupt"),
    ],
)
def test_bad_clouds_are_refused(tmp_path, name, content, message):
    path = written(tmp_path, name, content)
    if message is None:
        assert len(read_point_cloud(path).points) == 29
        return
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_point_cloud(path)
    assert "\n" not in str(caught.value) and name in str(caught.value)


def test_colours_of_floats_have_a_range(tmp_path):
    data = ply("ascii", "f4").decode().splitlines()
    row = data[-1].split()
    data[-1] = " ".join([*row[:6], "1.5", "0", "0"])
    with pytest.raises(HarmonicFaceError, match="expected colours from 0 to the largest"):
        read_point_cloud(written(tmp_path, "a.ply", "\n".join(data) + "\n"))


def test_arrays_that_are_no_numbers_are_refused(tmp_path):
    np.save(tmp_path / "a.npy", np.array([["a"] * 6]))
    with pytest.raises(HarmonicFaceError, match="points: expected an array of real numbers"):
        read_point_cloud(tmp_path / "a.npy")
    np.save(tmp_path / "o.npy", np.array([[{}] * 6]), allow_pickle=True)
    with pytest.raises(HarmonicFaceError, match="Object arrays cannot be loaded"):
        read_point_cloud(tmp_path / "o.npy")
    with pytest.raises(HarmonicFaceError, match="No such file"):
        read_point_cloud(tmp_path / "none.ply")


def test_points_beyond_the_memory_are_refused(tmp_path, monkeypatch):
    path = written(tmp_path, "a.ply", ply())
    table = written(tmp_path, "a.xyz", f"{ROW}\n" * 30)
    monkeypatch.setattr(_memory, "physical_memory", lambda: 3000)
    with pytest.raises(HarmonicFaceError, match=r"a\.ply: 30 points: need"):
        read_point_cloud(path)
    monkeypatch.setattr(_memory, "physical_memory", lambda: 1000)
    with pytest.raises(HarmonicFaceError, match=r"a\.xyz: a table of 360 bytes: need"):
        read_point_cloud(table)
    monkeypatch.setattr(_memory, "physical_memory", lambda: 100)
    with pytest.raises(HarmonicFaceError, match=r"a file of \d+ bytes: need"):
        read_point_cloud(path)
