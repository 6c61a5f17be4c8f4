import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.people.complexion import draw_complexion
from harmonicface.people.crop import Alignment
from harmonicface.people.ict import ict_people
from harmonicface.people.shape import mean_head
from harmonicface.people.synthetic import portrait

MODEL = "heads/ICT-FaceKit/FaceXModel"


@pytest.mark.data
def test_ict_people_are_aligned_like_the_mean_head(data_dir):
    people = ict_people(data_dir / MODEL, 12, 64, seed=4)
    head = mean_head()
    rng = np.random.default_rng(0)
    ours = portrait(head, draw_complexion(rng, 0.0, 0.0), Alignment.of(head.eyes, head.mouth), (64, 64))
    average = np.mean([person.normals for person in people], axis=0)
    average /= np.maximum(np.linalg.norm(average, axis=2, keepdims=True), 1e-9)
    common = np.logical_and.reduce([person.mask for person in people]) & ours.mask
    angles = np.degrees(np.linalg.norm(average - ours.normals, axis=2)[common])
    assert np.median(angles) < 4


@pytest.mark.data
def test_ict_people_are_seeded(data_dir):
    a, b = (ict_people(data_dir / MODEL, 2, 24, seed=1) for _ in range(2))
    assert np.array_equal(a[1].normals, b[1].normals)
    assert not np.array_equal(a[0].normals, a[1].normals)


def test_missing_model(tmp_path):
    with pytest.raises(HarmonicFaceError, match="expected the ICT face model's neutral and identity files, got none"):
        ict_people(tmp_path, 1)


def test_model_of_another_topology(tmp_path):
    for name in ("generic_neutral_mesh.obj", "identity000.obj"):
        (tmp_path / name).write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(HarmonicFaceError, match=r"expected at least 24591 vertices, got 3"):
        ict_people(tmp_path, 1)
