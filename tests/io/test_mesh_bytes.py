"""What files announce: counts that nothing follows, extensions that change geometry, meshes beyond the memory."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import trimesh

from harmonicface import _memory
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import read_mesh

HEADER = (
    "ply\nformat {form} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
)


@pytest.fixture
def ball():
    return trimesh.creation.icosphere(1)


def refused(tmp_path, name, data, message):
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_mesh(path)
    assert "\n" not in str(caught.value) and name in str(caught.value)


def changed_glb(ball, change):
    data = ball.export(file_type="glb")
    length = struct.unpack("<I", data[12:16])[0]
    document = json.loads(data[20 : 20 + length])
    change(document)
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    rest = data[20 + length :]
    return b"glTF" + struct.pack("<III", 2, 20 + len(words) + len(rest), len(words)) + b"JSON" + words + rest


@pytest.mark.parametrize("form", ["binary_little_endian", "binary_big_endian", "ascii"])
@pytest.mark.parametrize(("vertices", "faces"), [(10**15, 1), (3, 10**15), (10**30, 1), (5, 1)])
def test_a_ply_that_announces_more_than_follows_is_refused(tmp_path, form, vertices, faces):
    body = b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" if form == "ascii" else bytes(36 + 13)
    data = HEADER.format(form=form, vertices=vertices, faces=faces).encode() + body
    refused(tmp_path, "a.ply", data, "expected a PLY file .* got one cut short")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("element vertex 3", "element vertex -3", "expected a PLY element with a name and a count"),
        ("element vertex 3", "element vertex many", "expected a PLY element with a name and a count"),
        ("element vertex 3", "element vertex", "expected a PLY element with a name and a count"),
        ("property float x", "property quadruple x", "expected a PLY property of a known type"),
        ("property float x", "property float", "expected a PLY property of a known type"),
        ("element vertex 3\n", "", "expected a PLY property of a known type in an element"),
        ("end_header", "end", "without the header from 'ply' to 'end_header'"),
        ("ply\n", "plx\n", "without the header from 'ply' to 'end_header'"),
    ],
)
def test_ply_headers_that_say_nothing_are_refused(tmp_path, old, new, message):
    whole = HEADER.format(form="ascii", vertices=3, faces=1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    (tmp_path / "whole.ply").write_text(whole)
    assert len(read_mesh(tmp_path / "whole.ply").faces) == 1
    refused(tmp_path, "a.ply", whole.replace(old, new), message)


def test_a_glb_that_announces_more_than_follows_is_refused(tmp_path, ball):
    def huge(document):
        document["accessors"][0]["count"] = 10**12

    def without_data(document):
        document["accessors"][0].pop("bufferView")
        huge(document)

    def negative(document):
        document["accessors"][0]["count"] = -1

    refused(tmp_path, "a.glb", changed_glb(ball, huge), "expected 1000000000000 elements in a GLB accessor")
    refused(tmp_path, "a.glb", changed_glb(ball, without_data), "a GLB accessor of 1000000000000 elements: need .* GB")
    refused(tmp_path, "a.glb", changed_glb(ball, negative), "expected a count of at least 0 in a GLB accessor, got -1")


def test_a_glb_that_needs_what_is_not_understood_is_refused(tmp_path, ball):
    draco = changed_glb(ball, lambda document: document.update(extensionsRequired=["KHR_draco_mesh_compression"]))
    refused(tmp_path, "a.glb", draco, "without extensions that change its geometry, got KHR_draco_mesh_compression")
    harmless = changed_glb(ball, lambda document: document.update(extensionsRequired=["KHR_materials_unlit"]))
    (tmp_path / "b.glb").write_bytes(harmless)
    assert len(read_mesh(tmp_path / "b.glb").faces) == len(ball.faces)


@pytest.mark.parametrize(
    "change",
    [
        lambda document: document["meshes"][0].pop("primitives"),
        lambda document: document["meshes"][0]["primitives"][0]["attributes"].pop("POSITION"),
        lambda document: document["meshes"][0]["primitives"][0].update(indices=99),
        lambda document: document["meshes"][0].update(primitives=7),
        lambda document: document.update(meshes=[1e308]),
        lambda document: document.update(accessors=[]),
        lambda document: document["accessors"][0].update(componentType=1),
        lambda document: document["accessors"][0].update(type="VEC9"),
        lambda document: document.update(bufferViews=None),
        lambda document: document.update(nodes="x"),
    ],
)
def test_json_of_another_form_is_refused(tmp_path, ball, change):
    refused(tmp_path, "a.glb", changed_glb(ball, change), "cut short or corrupt(: its JSON cannot be read)?$")


def test_texture_coordinates_have_two_numbers(tmp_path, ball):
    def three(document):
        primitive = document["meshes"][0]["primitives"][0]
        primitive["attributes"]["TEXCOORD_0"] = primitive["attributes"]["POSITION"]
        primitive["material"] = 0
        document["materials"] = [{}]

    refused(tmp_path, "a.glb", changed_glb(ball, three), "expected two texture coordinates a vertex, got an array of")


def test_json_that_is_none_is_refused(tmp_path, ball):
    data = bytearray(ball.export(file_type="glb"))
    data[20:24] = b"]]]]"
    refused(
        tmp_path,
        "a.glb",
        bytes(data),
        "expected a whole GLB file, got one cut short or corrupt: its JSON cannot be read",
    )
    words = b"[]  "
    body = struct.pack("<I", 4) + b"JSON" + words
    refused(tmp_path, "a.glb", b"glTF" + struct.pack("<II", 2, 24) + body, "corrupt: the JSON is no object")
    refused(tmp_path, "a.glb", b"glTF" + struct.pack("<II", 2, 20) + b"\0" * 8, "'glTF' and JSON")


@pytest.mark.parametrize("name", ["a.glb", "a.ply", "a.stl", "a.obj", "text.stl"])
def test_a_mesh_beyond_the_memory_is_refused_with_what_it_would_need(tmp_path, monkeypatch, name):
    ball = trimesh.creation.icosphere(4)
    path = tmp_path / name
    path.write_bytes(ball.export(file_type="stl_ascii").encode() if name == "text.stl" else b"")
    if name != "text.stl":
        ball.export(path)
    assert len(read_mesh(path).faces) == 5120
    monkeypatch.setattr(_memory, "physical_memory", lambda: 2_000_000)
    with pytest.raises(HarmonicFaceError, match=r"a mesh of about \d+ faces: need 0\.0\d+ GB of memory, expected"):
        read_mesh(path)
    monkeypatch.setattr(_memory, "physical_memory", lambda: 10_000)
    with pytest.raises(HarmonicFaceError, match=r"a file of \d+ bytes: need .* GB of memory"):
        read_mesh(path)


def test_odd_names_are_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match=r"expected a mesh, got .*null"):
        read_mesh("a\0b.ply")


def test_faces_without_area_have_no_normals_but_are_kept(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
    mesh = read_mesh(tmp_path / "a.obj")
    assert len(mesh.faces) == 1
    np.testing.assert_array_equal(mesh.normals, 0)
