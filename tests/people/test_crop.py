import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.people.anatomy import EYE, MOUTH
from harmonicface.people.crop import Alignment, plane_rotation

PLACES = np.array([EYE[:2] * (-1, 1), EYE[:2], MOUTH])


def test_faces_in_place_are_not_moved():
    alignment = Alignment.of(PLACES[:2], PLACES[2])
    assert np.isclose(alignment.scale, 1)
    assert np.allclose(alignment.rotation, np.eye(2)) and np.allclose(alignment.shift, 0, atol=1e-12)


@given(scale=st.floats(0.5, 2), angle=st.floats(-1, 1), right=st.floats(-50, 50), up=st.floats(-50, 50))
def test_a_moved_face_comes_back(scale, angle, right, up):
    moved = scale * PLACES @ plane_rotation(angle).T + (right, up)
    alignment = Alignment.of(moved[:2], moved[2])
    back = alignment.points(np.concatenate([moved, np.zeros((3, 1))], axis=1))
    assert np.allclose(back[:, :2], PLACES, atol=1e-8)


def test_alignment_is_the_least_squares_solution():
    rng = np.random.default_rng(0)
    found = PLACES + rng.normal(0, 3, (3, 2))

    def error(alignment):
        points = alignment.scale * found @ alignment.rotation.T + alignment.shift
        return ((points - PLACES) ** 2).sum()

    best = Alignment.of(found[:2], found[2])
    for _ in range(30):
        scale, shift = best.scale + rng.normal(0, 0.01), best.shift + rng.normal(0, 0.1, 2)
        other = Alignment(scale, plane_rotation(rng.normal(0, 0.01)) @ best.rotation, shift)
        assert error(other) > error(best)


def test_disturbance_turns_about_the_middle_of_the_face():
    alignment = Alignment(1.0, np.eye(2), np.zeros(2)).disturbed(0.1, np.array([2.0, 0.0]))
    middle = np.append(PLACES.mean(axis=0), 5.0)[None]
    assert np.allclose(alignment.points(middle), middle + np.array([2, 0, 0]))


def test_normals_turn_but_do_not_stretch():
    alignment = Alignment(2.0, plane_rotation(np.pi / 2), np.array([7.0, 8.0]))
    assert np.allclose(alignment.normals(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])), [[0, 1, 0], [0, 0, 1]])
