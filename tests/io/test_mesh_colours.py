"""Colours of meshes: linear in GLB, textures of every mode, and none that is missing without a word."""

from __future__ import annotations

import io
import json
import struct

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual.material import PBRMaterial

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import read_mesh
from harmonicface.io.transfer import srgb_to_linear

POSITIONS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float32)
UV = np.array([[0, 1], [1, 1], [0, 0]], dtype=np.float32)
CODES = {"u1": 5121, "u2": 5123, "f4": 5126}
OBJ = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\nf 1/1 2/2 3/3\n"
PICTURE = np.random.default_rng(0).integers(0, 256, (4, 6, 3), dtype=np.uint8)


def png(picture):
    stream = io.BytesIO()
    picture.save(stream, "PNG")
    return stream.getvalue()


def glb(tmp_path, colours=None, picture=None, factor=None, **more):
    """A triangle as GLB, written by hand: what no exporter writes is wanted too."""
    blobs = [POSITIONS.tobytes()]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]
    attributes = {"POSITION": 0}

    def attribute(name, array, kind):
        code = CODES[array.dtype.str[1:]]
        integers = array.dtype.kind == "u"
        accessors.append(
            {"bufferView": len(blobs), "componentType": code, "count": 3, "type": kind, "normalized": integers}
        )
        attributes[name] = len(accessors) - 1
        blobs.append(array.tobytes())

    primitive = {"attributes": attributes}
    document = {"asset": {"version": "2.0"}, "accessors": accessors, "meshes": [{"primitives": [primitive]}]}
    document |= {"scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}]}
    if colours is not None:
        attribute("COLOR_0", colours, f"VEC{colours.shape[1]}")
    pbr = {} if factor is None else {"baseColorFactor": factor}
    if picture is not None:
        attribute("TEXCOORD_0", UV, "VEC2")
        pbr["baseColorTexture"] = {"index": 0}
        document["textures"] = [{"source": 0}]
        document["images"] = [picture if isinstance(picture, dict) else {"bufferView": len(blobs)}]
        if isinstance(picture, bytes):
            blobs.append(picture)
    if pbr:
        document["materials"] = [{"pbrMetallicRoughness": pbr}]
        primitive["material"] = 0
    padded = [blob + b"\0" * (-len(blob) % 4) for blob in blobs]
    starts = np.cumsum([0] + [len(blob) for blob in padded]).tolist()
    document["buffers"] = [{"byteLength": starts[-1]}]
    document["bufferViews"] = [
        {"buffer": 0, "byteOffset": start, "byteLength": len(blob)} for start, blob in zip(starts, blobs, strict=False)
    ]
    words = json.dumps(document | more).encode()
    words += b" " * (-len(words) % 4)
    chunks = struct.pack("<I", len(words)) + b"JSON" + words
    chunks += struct.pack("<I", starts[-1]) + b"BIN\0" + b"".join(padded)
    path = tmp_path / "a.glb"
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
    return path


@pytest.mark.parametrize("kind", ["u1", "u2", "f4"])
@pytest.mark.parametrize("channels", [3, 4])
def test_vertex_colours_of_a_glb_are_linear_and_not_rounded(tmp_path, kind, channels):
    """glTF 2.0, section 3.7.2.1: COLOR_0 is linear, also where it is normalized from integers."""
    values = np.random.default_rng(0).uniform(0, 0.01, (3, channels))
    largest = 1.0 if kind == "f4" else float(np.iinfo(kind).max)
    stored = (values * largest).round(0 if kind != "f4" else 9).astype(kind)
    if kind != "f4":
        stored[0] = np.iinfo(kind).max
    mesh = read_mesh(glb(tmp_path, stored))
    np.testing.assert_allclose(mesh.vertex_albedo, stored[:, :3].astype(float) / largest, rtol=1e-6)


def test_an_exported_glb_is_read_the_same_way(tmp_path):
    ball = trimesh.creation.icosphere(1)
    colours = np.random.default_rng(3).integers(0, 256, (len(ball.vertices), 4), dtype=np.uint8)
    ball.visual.vertex_colors = colours
    ball.export(tmp_path / "ball.glb")
    np.testing.assert_allclose(read_mesh(tmp_path / "ball.glb").vertex_albedo, colours[:, :3] / 255, atol=1e-7)


def test_factor_texture_and_vertex_colours_of_a_glb_are_multiplied(tmp_path):
    colours = np.array([[0.5, 0.25, 1]] * 3, dtype=np.float32)
    mesh = read_mesh(glb(tmp_path, colours, png(Image.fromarray(PICTURE)), [1, 0.2, 0, 1]))
    np.testing.assert_allclose(mesh.vertex_albedo, [[0.5, 0.05, 0]] * 3, atol=1e-6)
    np.testing.assert_allclose(mesh.textures[0], srgb_to_linear(PICTURE / 255), atol=1e-6)
    plain = read_mesh(glb(tmp_path, colours, factor=[1, 0.2, 0, 1]))
    np.testing.assert_allclose(plain.vertex_albedo, [[0.5, 0.05, 0]] * 3, atol=1e-6)
    assert plain.textures == ()


@pytest.mark.parametrize("value", [-0.5, np.nan, np.inf])
def test_vertex_colours_that_are_no_reflectances_are_refused(tmp_path, value):
    colours = np.full((3, 3), value, dtype=np.float32)
    with pytest.raises(HarmonicFaceError, match="expected vertex colours of at least 0"):
        read_mesh(glb(tmp_path, colours))


def test_vertex_colours_of_another_shape_are_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match="expected 3 vertex colours, got an array of shape"):
        read_mesh(glb(tmp_path, np.zeros((3, 2), dtype=np.float32)))


MODES = {
    "L": lambda picture: picture.convert("L"),
    "1": lambda picture: picture.convert("1"),
    "LA": lambda picture: picture.convert("LA"),
    "P": lambda picture: picture.quantize(256),
    "RGB": lambda picture: picture,
    "RGBA": lambda picture: Image.merge("RGBA", [*picture.split(), picture.convert("L")]),
    "I;16": lambda picture: Image.fromarray(np.asarray(picture.convert("L")).astype(np.uint16) * 257),
}


@pytest.mark.parametrize("mode", MODES)
def test_textures_of_every_mode_that_png_has(tmp_path, mode):
    picture = MODES[mode](Image.fromarray(PICTURE))
    assert picture.mode == mode
    mesh = read_mesh(glb(tmp_path, picture=png(picture)))
    if mode == "I;16":
        expected = np.asarray(picture) / 65535
    else:
        expected = np.asarray(picture.convert("RGB" if mode in ("P", "RGBA", "RGB") else "L")) / 255
    np.testing.assert_allclose(mesh.textures[0], srgb_to_linear(expected), atol=1e-6)


@pytest.mark.parametrize("mode", ["CMYK", "LAB"])
def test_textures_of_other_modes_are_refused(tmp_path, mode):
    stream = io.BytesIO()
    picture = Image.fromarray(PICTURE).convert("CMYK") if mode == "CMYK" else Image.new("LAB", (4, 4))
    picture.save(stream, "JPEG" if mode == "CMYK" else "TIFF")
    with pytest.raises(HarmonicFaceError, match=f"expected grey or RGB pixels, got the Pillow mode '{mode}'"):
        read_mesh(glb(tmp_path, picture=stream.getvalue()))


def test_a_texture_of_floats_with_nan_is_refused(tmp_path):
    stream = io.BytesIO()
    Image.fromarray(np.full((4, 4), np.nan, dtype=np.float32)).save(stream, "TIFF")
    with pytest.raises(HarmonicFaceError, match="values: expected finite numbers"):
        read_mesh(glb(tmp_path, picture=stream.getvalue()))


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        (b"no picture at all", "texture inside the file, got one that cannot be opened"),
        (b"", "texture inside the file, got one that cannot be opened"),
        ({"uri": "gone.png"}, r"texture gone\.png, got No such file"),
        ({"name": "skin"}, "texture skin, got one that cannot be opened"),
    ],
)
def test_a_glb_without_its_texture_is_refused(tmp_path, picture, message):
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_mesh(glb(tmp_path, picture=picture))
    assert "\n" not in str(caught.value)


def test_a_texture_beside_the_glb_is_found(tmp_path):
    (tmp_path / "my skin.png").write_bytes(png(Image.fromarray(PICTURE)))
    mesh = read_mesh(glb(tmp_path, picture={"uri": "my%20skin.png"}))
    np.testing.assert_allclose(mesh.textures[0], srgb_to_linear(PICTURE / 255), atol=1e-6)


def test_an_obj_without_its_texture_is_refused_unless_another_is_given(tmp_path):
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "a.mtl").write_text("newmtl other\nmap_Kd unused.png\nnewmtl skin\nKd 1 1 1\nmap_Kd gone.png\n")
    with pytest.raises(HarmonicFaceError, match=r"a\.obj: expected a picture as the texture gone\.png, got No such"):
        read_mesh(tmp_path / "a.obj")
    (tmp_path / "map.png").write_bytes(png(Image.fromarray(PICTURE)))
    assert len(read_mesh(tmp_path / "a.obj", texture=tmp_path / "map.png").textures) == 1
    (tmp_path / "gone.png").write_bytes(b"broken")
    with pytest.raises(HarmonicFaceError, match=r"texture gone\.png, got one that cannot be opened"):
        read_mesh(tmp_path / "a.obj")
    (tmp_path / "gone.png").write_bytes(png(Image.fromarray(PICTURE)))
    np.testing.assert_allclose(read_mesh(tmp_path / "a.obj").textures[0], srgb_to_linear(PICTURE / 255), atol=1e-6)


def test_a_ply_without_its_texture_is_refused(tmp_path):
    ball = trimesh.creation.icosphere(1)
    data = ball.export(file_type="ply").replace(b"comment ", b"comment TextureFile gone.png\ncomment ", 1)
    assert b"TextureFile" in data
    (tmp_path / "a.ply").write_bytes(data)
    with pytest.raises(HarmonicFaceError, match=r"texture gone\.png, got No such file"):
        read_mesh(tmp_path / "a.ply")


@pytest.mark.parametrize("colour", ["nan 0 0", "-1 0 0", "inf 1 1"])
def test_a_material_whose_colour_is_no_reflectance_is_refused(tmp_path, colour):
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "a.mtl").write_text(f"newmtl skin\nKd {colour}\n")
    with pytest.raises(HarmonicFaceError, match="expected a material's colour of at least 0"):
        read_mesh(tmp_path / "a.obj")


def test_materials_of_several_parts_keep_their_textures(tmp_path):
    ball = trimesh.creation.icosphere(1)
    uv = np.random.default_rng(1).random((len(ball.vertices), 2))
    parts = []
    for picture in (PICTURE, PICTURE[::-1].copy()):
        visual = trimesh.visual.TextureVisuals(uv=uv, material=PBRMaterial(baseColorTexture=Image.fromarray(picture)))
        parts.append(trimesh.Trimesh(ball.vertices, ball.faces, visual=visual, process=False))
    trimesh.Scene(parts).export(tmp_path / "a.glb")
    mesh = read_mesh(tmp_path / "a.glb")
    for texture, picture in zip(mesh.textures, (PICTURE, PICTURE[::-1]), strict=True):
        np.testing.assert_allclose(texture, srgb_to_linear(picture / 255), atol=1e-6)
