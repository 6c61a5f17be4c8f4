import json

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.people.ict_model import (
    BACK,
    FACE,
    LEFT_EYE,
    POLYGONS,
    RIGHT_EYE,
    VERTICES,
    read_ict_model,
)

MODEL = "heads/ICT-FaceKit"
NEUTRAL, LANDMARKS = "generic_neutral_mesh.obj", "vertex_indices.json"


def vertex_lines(shift=0.0):
    return "".join(f"v {shift + i % 7} {i % 5} {i % 3}\n" for i in range(VERTICES))


FACES = "f 1/1 2/2 3/3 4/4\n" * (POLYGONS - 1) + "f 5/1 6/2 26719/3\n"
UV = "vt 0.1 0.2\nvt 0.3 0.4\nvt 1.5 0.25\nvt 0.9 0.9\n"


@pytest.fixture(scope="module")
def parts():
    """The files of a made-up model of the right counts."""
    return {
        NEUTRAL: "# made up\n" + vertex_lines() + UV + FACES,
        "identity003.obj": vertex_lines(0.5) + UV + FACES,
        "identity007.obj": vertex_lines(-2.0) + UV + FACES,
        LANDMARKS: json.dumps({"idx_to_landmark_verts": list(range(68))}),
    }


def written(folder, parts, **changed):
    names = {"neutral": NEUTRAL, "landmarks": LANDMARKS, "mode": "identity003.obj"}
    for name, text in (parts | {names[key]: text for key, text in changed.items()}).items():
        if text is not None:
            (folder / name).write_text(text)
    return folder


def test_modes_are_displacements_in_millimetres_by_their_numbers(tmp_path, parts):
    model = read_ict_model(written(tmp_path, parts))
    assert model.numbers == (3, 7)
    assert model.neutral[1].tolist() == [10.0, 10.0, 10.0]
    weights = np.zeros(100)
    weights[[3, 5, 7]] = 2.0, 100.0, -1.0
    assert np.allclose(model.shape(weights) - model.neutral, [2 * 5.0 + 20.0, 0, 0])


def test_polygons_become_triangles_of_split_vertices_with_a_texture_each(tmp_path, parts):
    model = read_ict_model(written(tmp_path, parts))
    assert np.bincount(model.parts).tolist() == [2 * 9230, 2 * 4804, 2 * 800, 2 * 800]
    first = model.faces[0]
    assert model.source[first].tolist() == [0, 1, 2]
    assert np.allclose(model.uv[first], [[0.1, 0.2], [0.3, 0.4], [0.5, 0.25]])


def test_a_model_is_parsed_once_until_a_file_changes(tmp_path, parts):
    folder = written(tmp_path, parts)
    first = read_ict_model(folder)
    assert read_ict_model(str(folder)) is first
    (folder / "identity007.obj").unlink()
    assert read_ict_model(folder).numbers == (3,)


def test_the_folder_around_the_model_will_do(tmp_path, parts):
    (tmp_path / "FaceXModel").mkdir()
    written(tmp_path / "FaceXModel", parts)
    assert read_ict_model(tmp_path) is read_ict_model(tmp_path / "FaceXModel")


@pytest.mark.parametrize("folder", [None, 5, "a\0b"])
def test_no_folder(folder):
    with pytest.raises(HarmonicFaceError, match="expected the folder FaceXModel of ICT-FaceKit, got"):
        read_ict_model(folder)


def test_missing_files_are_named(tmp_path, parts):
    with pytest.raises(HarmonicFaceError, match=rf"got no {NEUTRAL}, no {LANDMARKS}, no identity000.obj"):
        read_ict_model(tmp_path / "nowhere")
    written(tmp_path, parts, landmarks=None)
    with pytest.raises(HarmonicFaceError, match=rf"expected the ICT face model .* got no {LANDMARKS}$"):
        read_ict_model(tmp_path)


@pytest.mark.parametrize("name", [NEUTRAL, LANDMARKS])
def test_a_folder_in_the_place_of_a_file(tmp_path, parts, name):
    written(tmp_path, parts)
    (tmp_path / name).unlink()
    (tmp_path / name).mkdir()
    with pytest.raises(HarmonicFaceError, match=rf"cannot read .*{name}: Is a directory"):
        read_ict_model(tmp_path)


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n"


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"neutral": TRIANGLE}, f"{NEUTRAL}: expected the 26719 vertices of the ICT face model, got 3"),
        ({"mode": TRIANGLE}, "identity003.obj: expected the 26719 vertices of the ICT face model, got 3"),
        ({"mode": ""}, "identity003.obj: expected the 26719 vertices of the ICT face model, got 0"),
        ({"mode": "v 0 zero 0\n"}, "identity003.obj: expected numbers after 'v '"),
        ({"mode": "v 0 0 0\nv 1 1\n"}, "identity003.obj: expected numbers after 'v '"),
        ({"mode": "v 0 0\nv 1 1\n"}, "identity003.obj: expected 3 finite numbers after 'v '"),
        ({"mode": "v 0 nan 0\n"}, "identity003.obj: expected 3 finite numbers after 'v '"),
        ({"landmarks": "{"}, f"{LANDMARKS}: expected JSON with idx_to_landmark_verts"),
        ({"landmarks": "{}"}, f"{LANDMARKS}: expected JSON with idx_to_landmark_verts"),
        ({"landmarks": "[]"}, f"{LANDMARKS}: expected JSON with idx_to_landmark_verts"),
        (
            {"landmarks": '{"idx_to_landmark_verts": [1, 2]}'},
            f"{LANDMARKS}: expected 68 landmarks, vertices 0 to 26718",
        ),
        (
            {"landmarks": json.dumps({"idx_to_landmark_verts": [26719] * 68})},
            f"{LANDMARKS}: expected 68 landmarks, vertices 0 to 26718",
        ),
        (
            {"landmarks": json.dumps({"idx_to_landmark_verts": ["a"] * 68})},
            f"{LANDMARKS}: expected 68 landmarks, vertices 0 to 26718",
        ),
    ],
)
def test_files_of_another_form(tmp_path, parts, changed, message):
    with pytest.raises(HarmonicFaceError, match=message):
        read_ict_model(written(tmp_path, parts, **changed))


@pytest.mark.parametrize(
    ("tail", "message"),
    [
        (UV + "f 1/1 2/2 3/3\n", "expected the 26384 polygons of the ICT face model, got 1"),
        (UV + "f 1 2 3\n" * POLYGONS, "expected faces of vertex/texture numbers, got another form"),
        (UV + "f 1//1 2//2 3//3\n" * POLYGONS, "expected faces of vertex/texture numbers, got another form"),
        (UV + "f 1/1\n" * POLYGONS, "expected faces of vertex/texture numbers, got another form"),
        ("vt 0 0\n" + FACES, "expected faces of 26719 vertices and 1 texture coordinates, got numbers 1 to"),
        (
            UV + "f 0/1 2/2 3/3\n" * POLYGONS,
            "expected faces of 26719 vertices and 4 texture coordinates, got numbers 0",
        ),
        ("vt 0\n" + FACES, "expected 2 finite numbers after 'vt '"),
    ],
)
def test_faces_of_another_form(tmp_path, parts, tail, message):
    with pytest.raises(HarmonicFaceError, match=f"{NEUTRAL}: {message}"):
        read_ict_model(written(tmp_path, parts, neutral=vertex_lines() + tail))


@pytest.mark.data
def test_the_parts_of_the_real_model_are_where_they_belong(data_dir):
    model = read_ict_model(data_dir / MODEL)
    middle = {part: model.neutral[model.source[model.faces[model.parts == part]]].mean((0, 1)) for part in range(4)}
    assert middle[LEFT_EYE][0] < -20 < 20 < middle[RIGHT_EYE][0]
    assert middle[FACE][2] > middle[BACK][2] + 20
    spans = np.ptp(model.uv[model.faces], axis=1)
    assert spans.max() < 0.2  # no triangle reaches across its texture
    nose_tip = model.neutral[model.landmarks[30]]
    skin = model.neutral[model.source[model.faces[model.parts == FACE]]]
    assert nose_tip[2] > skin[..., 2].max() - 2
