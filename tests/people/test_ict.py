import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.people.anatomy import EYE, MOUTH
from harmonicface.people.complexion import draw_complexion
from harmonicface.people.crop import FRAME, Alignment
from harmonicface.people.ict import ict_people, ict_person
from harmonicface.people.ict_model import read_ict_model
from harmonicface.people.shape import mean_head
from harmonicface.people.synthetic import portrait, synthetic_people

pytestmark = pytest.mark.data


@pytest.fixture(scope="module")
def model(data_dir):
    return data_dir / "heads/ICT-FaceKit/FaceXModel"


@pytest.fixture(scope="module")
def crowd(model):
    return ict_people(model, 6, 48, seed=4, albedo="grey")


def test_ict_people_are_aligned_like_the_mean_head(model):
    people = ict_people(model, 24, 32, seed=4, albedo="uniform")
    head = mean_head()
    rng = np.random.default_rng(0)
    ours = portrait(head, draw_complexion(rng, 0.0, 0.0), Alignment.of(head.eyes, head.mouth), (32, 32))
    average = np.mean([person.normals for person in people], axis=0)
    average /= np.maximum(np.linalg.norm(average, axis=2, keepdims=True), 1e-9)
    common = np.logical_and.reduce([person.mask for person in people]) & ours.mask
    angles = np.degrees(np.linalg.norm(average - ours.normals, axis=2)[common])
    assert np.median(angles) < 4


def pixel(x, y, size):
    """Return row and column of a place in mm."""
    millimetres = (FRAME[3] - FRAME[1]) / size
    return (FRAME[3] - y) / millimetres - 0.5, x / millimetres + size / 2 - 0.5


def darkest(person, x, y, reach=7.0):
    """Return how far, in mm across and up, the middle of the darkest tenth around a place lies from it."""
    size = person.shape[0]
    millimetres = person.pixel_size
    rows, columns = np.indices(person.shape)
    row, column = pixel(x, y, size)
    across, up = (columns - column) * millimetres, (row - rows) * millimetres
    near = np.hypot(across, up) < reach
    dark = near & (person.albedo <= np.quantile(person.albedo[near], 0.1))
    return np.array([across[dark].mean(), up[dark].mean()])


def test_pupils_are_at_the_same_pixels_as_the_built_in_peoples(model):
    crowd = ict_people(model, 5, 64, seed=4, albedo="grey")
    ours = list(synthetic_people(5, 64, seed=2))
    for side in (-1, 1):
        theirs, built_in = (
            np.mean([darkest(person, side * EYE[0], EYE[1]) for person in people], axis=0) for people in (crowd, ours)
        )
        assert np.abs(theirs - built_in).max() < 2.25  # mm: a pixel of 64 x 64
        assert np.abs(theirs).max() < 2.25


def test_brows_lips_and_whites_are_where_they_belong(crowd):
    def at(x, y, tall=3):
        row, column = (round(value) for value in pixel(x, y, 48))
        half = tall // 2
        return np.array([np.median(p.albedo[row - half : row + half + 1, column - 1 : column + 2]) for p in crowd])

    cheek = (at(38, -40) + at(-38, -40)) / 2
    brows = (np.minimum(at(30, 19, 1), at(30, 22, 1)) + np.minimum(at(-30, 19, 1), at(-30, 22, 1))) / 2
    assert np.mean(brows / cheek) < 0.8  # some are blond
    assert np.mean(at(0, MOUTH[1] - 5) / cheek) < 0.9
    iris = (at(*EYE[:2], 1) + at(-EYE[0], EYE[1], 1)) / 2
    assert (iris < 0.6 * cheek).all()


def test_a_person_is_the_same_however_many_are_made_and_from_either_door(model, crowd):
    few = ict_people(model, 2, 48, seed=4, albedo="grey")
    alone = ict_person(model, 1, 48, seed=4, albedo="grey")
    for one, other in ((few[0], crowd[0]), (few[1], crowd[1]), (alone, crowd[1])):
        assert np.array_equal(one.normals, other.normals)
        assert np.array_equal(one.albedo, other.albedo)
        assert np.array_equal(one.depth, other.depth, equal_nan=True)


def test_seeds_and_indices_are_different_people(model, crowd):
    other = ict_person(model, 0, 48, seed=5, albedo="grey")
    for stranger in (other, crowd[1]):
        common = stranger.mask & crowd[0].mask
        assert np.abs(stranger.normals - crowd[0].normals)[common].mean() > 0.03
        assert np.abs(stranger.albedo - crowd[0].albedo)[common].mean() > 0.01


def test_colour_grey_and_uniform_are_the_same_head(model, crowd):
    colour = ict_person(model, 2, 48, seed=4)
    uniform = ict_person(model, 2, 48, seed=4, albedo="uniform")
    assert colour.albedo.shape == (48, 48, 3)
    assert np.array_equal(uniform.normals, colour.normals)
    assert np.array_equal(uniform.normals, crowd[2].normals)
    assert np.unique(uniform.albedo[uniform.mask]).tolist() == [0.5]
    change = np.abs(luminance(colour.pixel_albedo) / crowd[2].pixel_albedo - 1)
    assert np.quantile(change, 0.97) < 1e-5 and change.max() < 0.1  # few texels are as bright or dark as skin can be


def test_albedos_are_in_the_range_of_skin(model):
    for person in ict_people(model, 4, 48, seed=7):
        values = person.pixel_albedo
        assert values.min() >= 0.005 and values.max() <= 0.9
        red, green, blue = np.median(values, axis=0)
        assert 0.15 < red < 0.8 and 0.45 < green / red < 0.75 and 0.5 < blue / green < 0.85


def test_the_same_person_in_another_size(model, crowd):
    large = ict_person(model, 0, 96, seed=4, albedo="grey")
    inside = large.mask.reshape(48, 2, 48, 2).all(axis=(1, 3)) & crowd[0].mask
    shrunk = large.albedo.reshape(48, 2, 48, 2).mean(axis=(1, 3))
    difference = (shrunk - crowd[0].albedo)[inside] / crowd[0].albedo[inside].mean()
    assert np.sqrt((difference**2).mean()) < 0.04


def test_the_scene_is_the_whole_head_in_millimetres(crowd):
    mesh, view = crowd[0].scene.mesh, crowd[0].scene.view
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    assert low[0] < -75 and high[0] > 75  # ears
    assert low[1] < -150 and high[1] > 90  # neck and crown
    assert low[2] < -120 and 30 < high[2] < 75  # the back of the head and the nose; the eyes are near 0
    assert view.frame[1] == FRAME[1] and view.frame[3] == FRAME[3]


def test_a_turned_head(model, crowd):
    turned = ict_person(model, 0, 48, seed=4, rotation=(40.0, 0.0, 0.0), albedo="grey")
    assert (turned.normals[..., 0] > 0).sum() < 0.9 * turned.mask.sum()
    nose, before = (np.unravel_index(np.nanargmax(p.depth), p.shape) for p in (turned, crowd[0]))
    assert nose[1] > before[1] + 5  # positive yaw looks to the picture's right
    eyes = [pixel(side * EYE[0], EYE[1], 48) for side in (-1, 1)]
    assert turned.mask[round(eyes[0][0]), round(eyes[0][1] * 0.5 + eyes[1][1] * 0.5)]


def test_more_modes_make_the_same_person_more_exact(model, tmp_path):
    whole = read_ict_model(model)
    few = tmp_path / "few"
    few.mkdir()
    names = ("generic_neutral_mesh.obj", "vertex_indices.json", "identity000.obj", "identity002.obj")
    for name in names:
        (few / name).symlink_to((model / name).resolve())
    part = read_ict_model(few)
    weights = np.zeros(100)
    weights[[0, 1, 2]] = 1.5, 0.0, -2.0
    assert np.allclose(part.shape(weights), whole.shape(weights), atol=1e-4)
    alike, other = (ict_person(few, 0, 32, seed=seed, albedo="uniform").normals for seed in (4, 5))
    exact = ict_person(model, 0, 32, seed=4, albedo="uniform").normals
    assert np.abs(alike - exact).mean() < 0.8 * np.abs(other - exact).mean()


def test_nobody(model):
    assert ict_people(model, 0) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"index": -1}, "index: expected an integer of at least 0, got int -1"),
        ({"index": 1.5}, "index: expected an integer"),
        ({"seed": -1}, "seed: expected an integer of at least 0"),
        ({"size": 0}, "size: expected pixels"),
        ({"albedo": "pink"}, "albedo: expected one of colour, grey, uniform, got str 'pink'"),
        ({"albedo": True}, "albedo: expected one of colour, grey, uniform, got bool True"),
        ({"rotation": (1, 2)}, "rotation: expected"),
    ],
)
def test_refused(model, arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        ict_person(model, **({"index": 0, "size": 16} | arguments))


def test_a_count_below_0(model):
    with pytest.raises(HarmonicFaceError, match="count: expected an integer of at least 0, got int -2"):
        ict_people(model, -2)
