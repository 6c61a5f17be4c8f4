"""Meshes: nothing is merged or reordered, colours mean what the docstring says, bad files are refused."""

from __future__ import annotations

import io
import json
import logging
import struct

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import read_mesh
from harmonicface.io.transfer import srgb_to_linear

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
PICTURE = np.random.default_rng(0).integers(0, 256, (4, 6, 3), dtype=np.uint8)


@pytest.fixture
def ball():
    return trimesh.creation.icosphere(1)


def written(tmp_path, name, mesh, **options):
    path = tmp_path / name
    mesh.export(path, **options)
    return path


def text(tmp_path, content, name="a.obj"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def textured(mesh, material):
    uv = np.random.default_rng(1).random((len(mesh.vertices), 2))
    return trimesh.Trimesh(
        mesh.vertices, mesh.faces, visual=trimesh.visual.TextureVisuals(uv=uv, material=material), process=False
    ), uv


@pytest.mark.parametrize("name", ["a.glb", "a.obj", "a.ply", "A.PLY"])
def test_vertices_and_faces_keep_their_order(tmp_path, ball, name):
    shuffled = np.random.default_rng(2).permutation(len(ball.faces))
    twice = np.concatenate([ball.vertices, ball.vertices])  # every vertex at a second place in the list
    faces = ball.faces[shuffled] + len(ball.vertices) * (shuffled[:, None] % 2)
    source = trimesh.Trimesh(twice, faces, process=False)
    mesh = read_mesh(written(tmp_path, name, source))
    np.testing.assert_allclose(mesh.vertices[mesh.faces], twice[faces], atol=1e-6)
    if name != "a.obj":  # an OBJ keeps only the vertices that its faces name
        assert len(mesh.vertices) == len(twice)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals[mesh.faces], axis=2), 1, atol=1e-12)
    assert mesh.vertex_albedo.min() == mesh.vertex_albedo.max() == 0.5
    assert mesh.is_grey and mesh.uv is None and mesh.textures == ()


@pytest.mark.parametrize("ascii_file", [True, False])
def test_stl_has_smooth_normals_although_its_triangles_share_nothing(tmp_path, ball, ascii_file):
    path = tmp_path / "a.stl"
    path.write_bytes(ball.export(file_type="stl_ascii").encode() if ascii_file else ball.export(file_type="stl"))
    mesh = read_mesh(path)
    assert mesh.faces.shape == ball.faces.shape
    assert np.einsum("ij,ij->i", mesh.normals, mesh.vertices).min() > 0.999


def test_normals_of_the_file_are_used_and_missing_ones_computed(tmp_path, ball):
    given = np.tile([0.0, 0.6, 0.8], (len(ball.vertices), 1))
    given[3] = 0
    source = trimesh.Trimesh(ball.vertices, ball.faces, vertex_normals=given, process=False)
    mesh = read_mesh(written(tmp_path, "a.glb", source, include_normals=True))
    np.testing.assert_allclose(np.delete(mesh.normals, 3, axis=0), np.delete(given, 3, axis=0), atol=1e-6)
    assert mesh.normals[3] @ mesh.vertices[3] > 0.999


def test_parts_are_placed_by_the_scene(tmp_path):
    box = trimesh.creation.box()
    box.vertex_normals  # noqa: B018  (computed now, so that they are written)
    scene = trimesh.Scene()
    stretch = np.diag([2.0, 1.0, 1.0, 1.0])
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    mirror[:3, 3] = [10, 0, 0]
    scene.add_geometry(box, transform=stretch)
    scene.add_geometry(box, transform=mirror)
    mesh = read_mesh(written(tmp_path, "a.glb", scene, include_normals=True))
    assert len(mesh.faces) == 24
    left = 0 if mesh.vertices[0, 0] < 5 else 8  # two places of one geometry have no order
    first, second = mesh.vertices[left : left + 8], mesh.vertices[8 - left : 16 - left]
    np.testing.assert_allclose([first.min(0), first.max(0)], [[-1, -0.5, -0.5], [1, 0.5, 0.5]], atol=1e-6)
    np.testing.assert_allclose([second.min(0), second.max(0)], [[9.5, -0.5, -0.5], [10.5, 0.5, 0.5]], atol=1e-6)
    corners = mesh.vertices[mesh.faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    centre = np.where(corners[:, :1, 0] < 5, 0, 10) * [1, 0, 0]
    assert (np.einsum("ij,ij->i", outward, corners.mean(axis=1) - centre) > 0).all()
    expected = np.sign(first) * [1 / 2, 1, 1]  # a normal goes by the inverse transpose
    np.testing.assert_allclose(mesh.normals[left : left + 8], expected / np.linalg.norm(expected[0]), atol=1e-5)
    np.testing.assert_allclose(mesh.normals[8 - left : 16 - left], np.sign(second - [10, 0, 0]) / np.sqrt(3), atol=1e-5)


def test_an_obj_keeps_the_order_of_its_parts_and_cuts_its_quads(tmp_path):
    content = (
        "mtllib missing.mtl\n"
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\n"
        "usemtl zebra\nf 1 2 3 4\nusemtl apple\nf 5 6 7\n"
    )
    mesh = read_mesh(text(tmp_path, content))
    np.testing.assert_array_equal(mesh.vertices[mesh.faces][:, :, 2], [[0] * 3, [0] * 3, [1] * 3])
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    np.testing.assert_allclose(areas, 0.5)


def test_a_missing_material_file_makes_no_noise(tmp_path, caplog, capfd):
    with caplog.at_level(logging.DEBUG):
        mesh = read_mesh(text(tmp_path, "mtllib gone.mtl\nusemtl skin\n" + TRIANGLE))
    assert (mesh.vertex_albedo == 0.5).all()
    assert caplog.records == []
    assert capfd.readouterr() == ("", "")
    assert not trimesh.util.log.disabled


def test_seams_split_vertices_but_not_normals(tmp_path):
    content = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/3 3/4 4/1\n"
    mesh = read_mesh(text(tmp_path, content))
    assert len(mesh.vertices) == 6
    first = mesh.normals[(mesh.vertices == [1, 1, 0]).all(axis=1)]
    np.testing.assert_allclose(first[0], first[1])
    np.testing.assert_array_equal(mesh.uv[mesh.faces[1]], [[1, 1], [0, 1], [0, 0]])


@pytest.mark.parametrize("name", ["a.ply", "a.obj"])
def test_vertex_colours_are_srgb(tmp_path, ball, name):
    colours = np.random.default_rng(3).integers(0, 256, (len(ball.vertices), 4), dtype=np.uint8)
    ball.visual.vertex_colors = colours
    mesh = read_mesh(written(tmp_path, name, ball))
    np.testing.assert_allclose(mesh.vertex_albedo, srgb_to_linear(colours[:, :3] / 255), atol=1e-6)
    assert not mesh.is_grey


@pytest.mark.parametrize("name", ["a.glb", "a.obj"])
def test_the_texture_inside_is_srgb(tmp_path, ball, name):
    picture = Image.fromarray(PICTURE)
    material = PBRMaterial(baseColorTexture=picture) if name == "a.glb" else SimpleMaterial(image=picture)
    source, uv = textured(ball, material)
    (tmp_path / "obj").mkdir()
    mesh = read_mesh(written(tmp_path / "obj", name, source))
    expected = srgb_to_linear(PICTURE / 255)
    np.testing.assert_allclose(mesh.textures[0], expected, atol=1e-6)
    assert (mesh.face_texture == 0).all() and (mesh.vertex_albedo == 1).all()
    np.testing.assert_allclose(np.sort(mesh.uv[mesh.faces].ravel()), np.sort(uv[ball.faces].ravel()), atol=1e-5)


def test_a_base_colour_is_linear_and_tints_the_texture(tmp_path, ball):
    factor = [255, 51, 0, 255]
    source, _ = textured(ball, PBRMaterial(baseColorFactor=factor, baseColorTexture=Image.fromarray(PICTURE)))
    np.testing.assert_allclose(read_mesh(written(tmp_path, "a.glb", source)).vertex_albedo[0], [1, 0.2, 0], atol=1e-6)
    plain, _ = textured(ball, PBRMaterial(baseColorFactor=factor))
    np.testing.assert_allclose(read_mesh(written(tmp_path, "b.glb", plain)).vertex_albedo[0], [1, 0.2, 0], atol=1e-6)


def test_the_main_colour_of_an_obj_material_is_linear(tmp_path):
    text(tmp_path, "newmtl skin\nKd 0.25 0.5 0.75\n", "a.mtl")
    mesh = read_mesh(text(tmp_path, "mtllib a.mtl\nusemtl skin\n" + TRIANGLE))
    np.testing.assert_allclose(mesh.vertex_albedo, [[0.25, 0.5, 0.75]] * 3)


def test_parts_with_and_without_textures_live_together(tmp_path, ball):
    dressed, _ = textured(ball, PBRMaterial(baseColorTexture=Image.fromarray(PICTURE)))
    other, _ = textured(ball, PBRMaterial(baseColorTexture=Image.fromarray(PICTURE[::-1].copy())))
    scene = trimesh.Scene([ball, dressed, other])
    mesh = read_mesh(written(tmp_path, "a.glb", scene))
    np.testing.assert_array_equal(mesh.face_texture, np.repeat([-1, 0, 1], len(ball.faces)))
    assert len(mesh.textures) == 2
    assert set(mesh.vertex_albedo[: len(ball.vertices)].ravel()) == {0.5}


def test_a_texture_beside_the_mesh_takes_the_place_of_its_colours(tmp_path, ball):
    source, _ = textured(ball, PBRMaterial(baseColorFactor=[10, 20, 30, 255]))
    path = written(tmp_path, "a.glb", source)
    Image.fromarray(PICTURE).save(tmp_path / "map.png")
    mesh = read_mesh(path, texture=tmp_path / "map.png")
    flipped = read_mesh(path, texture=tmp_path / "map.png", flip_texture=True)
    np.testing.assert_allclose(mesh.textures[0], srgb_to_linear(PICTURE / 255), atol=1e-6)
    np.testing.assert_array_equal(flipped.textures[0], mesh.textures[0][::-1])
    assert (mesh.vertex_albedo == 1).all() and (mesh.face_texture == 0).all()


@pytest.mark.parametrize("name", ["a.glb", "a.ply", "binary.stl"])
def test_a_binary_mesh_cut_short_is_refused_wherever_it_is_cut(tmp_path, ball, name):
    data = written(tmp_path, name, ball).read_bytes()
    for cut in np.linspace(0, len(data) - 1, 40).astype(int):
        with pytest.raises(HarmonicFaceError) as caught:
            read_mesh(text(tmp_path, data[:cut], "cut" + name))
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["a.ply", "a.stl"])
def test_a_text_mesh_without_its_end_is_refused(tmp_path, ball, name):
    data = ball.export(file_type="ply", encoding="ascii") if name == "a.ply" else ball.export(file_type="stl_ascii")
    data = data.encode() if isinstance(data, str) else data
    assert len(read_mesh(text(tmp_path, data, name)).faces) == len(ball.faces)
    for cut in np.linspace(0, len(data) - 40, 20).astype(int):
        with pytest.raises(HarmonicFaceError):
            read_mesh(text(tmp_path, data[:cut], name))


def test_random_bytes_are_refused(tmp_path):
    rng = np.random.default_rng(0)
    for name in ("a.glb", "a.obj", "a.ply", "a.stl"):
        for _ in range(5):
            with pytest.raises(HarmonicFaceError):
                read_mesh(text(tmp_path, rng.bytes(300), name))


def broken_glb(ball, change):
    """A GLB whose first accessor of each kind was changed."""
    data = ball.export(file_type="glb")
    length = struct.unpack("<I", data[12:16])[0]
    document = json.loads(data[20 : 20 + length])
    binary = bytearray(data[28 + length :])
    change(document, binary)
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    body = struct.pack("<I", len(words)) + b"JSON" + words + struct.pack("<I", len(binary)) + b"BIN\0" + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def first_number(document, binary, kind, value, code):
    accessor = next(a for a in document["accessors"] if a["type"] == kind)
    offset = document["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
    struct.pack_into(code, binary, offset, value)


@pytest.mark.parametrize(
    ("kind", "value", "code", "message"),
    [
        ("VEC3", np.nan, "<f", r"expected finite vertices, got 1 NaN or infinite of \d+"),
        ("VEC3", np.inf, "<f", "expected finite vertices"),
        ("SCALAR", 4_000_000, "<I", "expected triangles of vertices 0 to 41, got indices 0 to 4000000"),
    ],
)
def test_nan_and_indices_out_of_range_in_a_glb_are_refused(tmp_path, ball, kind, value, code, message):
    whole = broken_glb(ball, lambda document, binary: None)
    assert len(read_mesh(text(tmp_path, whole, "whole.glb")).faces) == len(ball.faces)
    data = broken_glb(ball, lambda document, binary: first_number(document, binary, kind, value, code))
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_mesh(text(tmp_path, data, "a.glb"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "expected a mesh with faces"),
        ("hello", "expected a mesh with faces"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "expected a mesh with faces"),
        (TRIANGLE.replace("f 1 2 3", "f 1 2"), "expected a mesh with faces"),
        (TRIANGLE.replace("1 0 0", "1 nan 0"), r"expected finite vertices, got 1 NaN or infinite of \d+"),
        (TRIANGLE.replace("1 0 0", "1 1e200 0"), r"expected vertices within 1e\+60, got 1e\+200"),
        (TRIANGLE.replace("f 1 2 3", "f 1 2 4"), "cut short or corrupt: index 3, beyond the 3 that there are"),
        (TRIANGLE.replace("f 1 2 3", "f 1 2 -7"), r"cut short or corrupt: index -\d, beyond the 3 that there are"),
        (TRIANGLE.replace("f 1 2 3", "f 0 1 2"), "expected vertex indices from 1"),
        (TRIANGLE.replace("f 1 2 3", "f 1/1 0/2 2/3"), "expected vertex indices from 1"),
        (TRIANGLE.replace("1 0 0", "inf 0 0"), r"expected finite vertices, got 1 NaN or infinite of \d+"),
        (TRIANGLE.replace("f 1 2 3", "f 1 2 x"), "cut short or corrupt: string or file could not be read"),
        (TRIANGLE.replace("f 1 2 3", "f -1 -2 -3\nv 4 4 4"), "relative"),
    ],
)
def test_bad_obj_files_are_refused(tmp_path, content, message):
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_mesh(text(tmp_path, content))
    assert "\n" not in str(caught.value)


def test_relative_indices_count_from_the_end(tmp_path):
    mesh = read_mesh(text(tmp_path, TRIANGLE.replace("f 1 2 3", "f -3 -2 -1")))
    np.testing.assert_array_equal(mesh.vertices[mesh.faces[0]], [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


def test_bad_normals_and_texture_coordinates_are_refused(tmp_path):
    content = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 {}\nvt 0 1\nvn 0 0 1\nvn 0 {} 1\nvn 0 0 1\nf 1/1/1 2/2/2 3/3/3\n"
    assert read_mesh(text(tmp_path, content.format(0, 0))).uv.shape == (3, 2)
    with pytest.raises(HarmonicFaceError, match="expected finite texture coordinates"):
        read_mesh(text(tmp_path, content.format("nan", 0)))
    with pytest.raises(HarmonicFaceError, match="expected finite normals"):
        read_mesh(text(tmp_path, content.format(0, "nan")))


def test_a_texture_needs_coordinates(tmp_path, ball):
    Image.fromarray(PICTURE).save(tmp_path / "map.png")
    with pytest.raises(HarmonicFaceError, match=r"expected texture coordinates for map\.png"):
        read_mesh(written(tmp_path, "a.ply", ball), texture=tmp_path / "map.png")
    text(tmp_path, "newmtl skin\nmap_Kd map.png\n", "a.mtl")
    with pytest.raises(HarmonicFaceError, match="expected texture coordinates for the texture inside"):
        read_mesh(text(tmp_path, "mtllib a.mtl\nusemtl skin\n" + TRIANGLE))
    with pytest.raises(HarmonicFaceError, match="flip_texture: expected a texture"):
        read_mesh(tmp_path / "a.ply", flip_texture=True)
    with pytest.raises(HarmonicFaceError, match=r"none\.png: expected an image"):
        read_mesh(textured_glb(tmp_path, ball), texture=tmp_path / "none.png")


def textured_glb(tmp_path, ball):
    return written(tmp_path, "t.glb", textured(ball, PBRMaterial())[0])


def test_a_corrupt_texture_inside_is_refused(tmp_path, ball):
    stream = io.BytesIO()
    Image.fromarray(PICTURE).save(stream, "PNG")
    source, _ = textured(ball, PBRMaterial(baseColorTexture=Image.fromarray(PICTURE)))
    data = bytearray(source.export(file_type="glb"))
    pixels = data.find(b"IDAT")
    assert pixels > 0
    data[pixels + 10] ^= 0xFF
    data[pixels + 11] ^= 0xFF
    with pytest.raises(HarmonicFaceError):
        read_mesh(text(tmp_path, bytes(data), "a.glb"))


def test_other_files_are_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match=r"expected a mesh .* got the ending '\.fbx'"):
        read_mesh(tmp_path / "a.fbx")
    with pytest.raises(HarmonicFaceError, match=r"none\.glb: expected a mesh, got No such file"):
        read_mesh(tmp_path / "none.glb")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(HarmonicFaceError, match="Is a directory"):
        read_mesh(tmp_path / "folder.obj")


@pytest.mark.data
def test_real_heads_are_read_whole(data_dir):
    scan = read_mesh(
        data_dir / "heads" / "LeePerrySmith" / "LeePerrySmith.glb",
        texture=data_dir / "heads" / "LeePerrySmith" / "Map-COL.jpg",
    )
    assert scan.faces.shape == (17684, 3) and scan.vertices.shape == (9279, 3)
    assert scan.textures[0].shape == (1024, 1024, 3)
    head = read_mesh(data_dir / "heads" / "ICT-FaceKit" / "FaceXModel" / "generic_neutral_mesh.obj")
    assert len(np.unique(head.vertices, axis=0)) <= 26719 <= len(head.vertices)
    face = head.vertices[np.unique(head.faces[: 2 * 9230])]  # the face's quads come first, and face the viewer
    assert face[:, 2].max() == head.vertices[:, 2].max()
