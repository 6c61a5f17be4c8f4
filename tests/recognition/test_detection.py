"""Faces in ordinary photographs: where they are, and their crops."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.people.crop import FRAME
from harmonicface.recognition.detection import MIDDLE, SIDE, FaceBox, _merged, crop_face, detect_faces
from harmonicface.surfaces.mesh import surface_from_mesh

FACE = hf.synthetic_person(1, (96, 84))
SEEN = hf.render(FACE, hf.lights.directional([0.3, 0.2, 1.0])).astype(np.float32)


@pytest.fixture(scope="module")
def scene() -> np.ndarray:
    """A face, 84 pixels from (90, 60), in front of a grey wall."""
    photo = np.full((200, 240), 0.3, np.float32)
    photo[60:156, 90:174][FACE.mask] = SEEN[FACE.mask]
    return photo


@pytest.fixture(scope="module")
def found(scene: np.ndarray) -> list[FaceBox]:
    return detect_faces(scene)


def test_the_box_is_where_the_face_is(found: list[FaceBox]) -> None:
    best = found[0]
    unit = 84 / 126  # pixels a millimetre
    middle = (90 + 42, 60 + (FRAME[3] - MIDDLE) * unit)
    assert_allclose(best.side, SIDE * unit, rtol=0.15)
    assert_allclose([best.left + best.side / 2, best.top + best.side / 2], middle, atol=0.07 * best.side)
    assert [box.support for box in found] == sorted((box.support for box in found), reverse=True)


def test_the_unit_of_light_colour_and_place_change_little(scene: np.ndarray, found: list[FaceBox]) -> None:
    colour = 300 * np.roll(scene, (20, -30), axis=(0, 1))[..., None] * np.array([1.2, 1.0, 0.7])
    box = detect_faces(colour)[0]
    middle, moved = (np.array([each.left, each.top]) + each.side / 2 for each in (found[0], box))
    assert_allclose(moved - middle, [-30, 20], atol=0.05 * box.side)


def test_faces_that_fill_the_photograph() -> None:
    best = detect_faces(SEEN)[0]
    assert best.side > 84
    assert best.left < 0
    assert_allclose(best.left + best.side / 2, 42, atol=8)


def test_where_there_is_no_face(scene: np.ndarray) -> None:
    assert detect_faces(np.zeros((40, 40))) == []
    assert detect_faces(np.ones((40, 40, 3))) == []
    assert detect_faces(np.linspace(0, 1, 40 * 60).reshape(40, 60)) == []
    assert detect_faces(scene, smallest=201) == []
    assert detect_faces(scene, smallest=180) == []


@pytest.mark.parametrize(
    ("photo", "smallest", "message"),
    [
        (np.ones((23, 90)), None, r"photo: expected at least 24 pixels a side, got \(23, 90\)"),
        (np.ones(90), None, r"photo: expected an image of shape"),
        (np.full((30, 30), np.nan), None, "photo: expected finite"),
        (np.ones((30, 30)), 0, "smallest: expected a finite number above 0"),
        (np.ones((30, 30)), 0.5, "smallest: expected at least 1 pixel, got 0.5"),
    ],
)
def test_what_cannot_be_searched(photo: np.ndarray, smallest: float | None, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        detect_faces(photo, smallest)


def test_windows_are_merged_where_most_overlap() -> None:
    near = np.array([[10.0, 20, 50], [12, 20, 50], [8, 20, 50], [10, 22, 52], [10, 18, 48], [10, 20, 50]])
    far = near[:5] + np.array([100, 0, 0])
    assert _merged(np.concatenate([far, near])) == [FaceBox(10, 20, 50, 6)]
    both = _merged(np.concatenate([far, far + np.array([1, 0, 0]), near]))
    assert both == [FaceBox(110.5, 20, 50, 10), FaceBox(10, 20, 50, 6)]
    assert _merged(np.empty((0, 3))) == []


@pytest.mark.parametrize("shape", [(48, 42), (64, 64), (30, 60)])
def test_a_crop_is_the_view_of_the_frame(shape: tuple[int, int]) -> None:
    """The same person's picture at another size, by the renderer, is the oracle."""
    large = hf.synthetic_person(1, (384, 336))
    photo = np.pad(hf.render(large, [0, 0, 1]), 200)
    unit = 336 / 126
    box = FaceBox(200 + 168 - 90 * unit, 200 + (FRAME[3] - MIDDLE - 90) * unit, SIDE * unit, 9)
    wanted = hf.synthetic_person(1, shape)
    seen, rendered = crop_face(photo, box, shape), hf.render(wanted, [0, 0, 1])
    inside = wanted.mask & (seen > 0)
    columns = np.zeros(shape, bool)
    half = int(0.45 * shape[0] * 126 / 144)
    columns[1:-1, shape[1] // 2 - half : shape[1] // 2 + half] = True
    assert np.corrcoef(seen[inside & columns], rendered[inside & columns])[0, 1] > 0.99


def test_a_crop_of_a_ramp_is_a_ramp() -> None:
    ramp = np.arange(400.0)[None].repeat(300, axis=0)
    seen = crop_face(ramp, FaceBox(150, 100, 90, 9), (72, 63))
    step = 90 / SIDE * 144 / 72
    assert_allclose(np.diff(seen, axis=1), step, rtol=1e-3)
    assert_allclose(seen.mean(), 195 - 0.5, atol=1e-3)  # the middle of the box; the centre of pixel 0 is at 0.5
    colour = crop_face(np.stack([ramp, 2 * ramp, 0 * ramp], axis=2), FaceBox(150, 100, 90, 9), (72, 63))
    assert_allclose(colour[..., 1], 2 * seen, rtol=1e-6)
    assert colour.dtype == np.float32


@pytest.mark.parametrize(
    ("box", "size", "message"),
    [
        (FaceBox(0, 0, 0, 9), 64, "side: expected a finite number above 0"),
        (FaceBox(90, 0, 50, 9), 64, "box: expected a face inside the photograph of"),
        (FaceBox(0, -90, 50, 9), 64, "box: expected a face inside the photograph of"),
        (FaceBox(0, 0, 50, 9), 0, "size: expected pixels"),
    ],
)
def test_what_cannot_be_cropped(box: FaceBox, size: int, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        crop_face(np.ones((60, 60)), box, size)


@pytest.mark.data
def test_a_head_before_a_wall_under_lamps(data_dir: Path) -> None:
    """A whole head with ears and neck, under lamps 10 and 45 degrees from the camera."""
    mesh = hf.ict_person(data_dir / "heads/ICT-FaceKit/FaceXModel", 0, 16, seed=3).scene.mesh
    seen = surface_from_mesh(mesh, (120, 105), frame=(-170, -230, 180, 170))
    for degrees in (0, 45):
        photo = hf.render(seen, hf.lights.from_angles(degrees, 10))
        photo[~seen.mask] = 0.1
        box = detect_faces(photo)[0]
        unit = 120 / 400
        middle = (170 * unit, (170 - MIDDLE) * unit)
        assert_allclose([box.left + box.side / 2, box.top + box.side / 2], middle, atol=0.08 * box.side)
        assert_allclose(box.side, SIDE * unit, rtol=0.15)
