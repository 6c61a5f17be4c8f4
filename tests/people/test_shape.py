import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.people.anatomy import EYE, EYEBALL_RADIUS, MOUTH, face_depth, lid_margins, outline
from harmonicface.people.fields import Places
from harmonicface.people.lattice import lattice_normals, mean_lattice
from harmonicface.people.shape import head_shape, mean_head
from harmonicface.people.traits import TRAITS, HeadTraits, draw_head

MIRROR = np.array([-1.0, 1.0, 1.0])


def test_mean_head_is_symmetric():
    head = mean_head()
    assert np.allclose(head.points[:, ::-1] * MIRROR, head.points, atol=1e-9)
    assert np.allclose(head.normals[:, ::-1] * MIRROR, head.normals, atol=1e-9)
    assert np.allclose(head.eyes[::-1] * MIRROR, head.eyes)


def test_mean_head_has_its_landmarks():
    head = mean_head()
    assert np.allclose(head.eyes, [EYE * MIRROR, EYE])
    assert np.allclose(head.mouth[:2], MOUTH, atol=0.7)
    highest = head.points.reshape(-1, 3)[head.points[..., 2].argmax()]
    assert abs(highest[0]) < 1 and -40 < highest[1] < -28  # the tip of the nose


def test_eyeballs_are_spheres_seen_between_the_lids():
    head, lattice = mean_head(), mean_lattice()
    for eye, centre in zip(lattice.eyes, head.eyes, strict=True):
        points = head.points[eye]
        distance = np.linalg.norm(points - centre, axis=1)
        middle = np.hypot(*(points - centre)[:, :2].T) < 6
        assert np.allclose(distance[middle], EYEBALL_RADIUS, atol=0.2)
        _, upper, lower = lid_margins(points[:, 0])
        assert (points[:, 1] <= upper + 1e-9).all() and (points[:, 1] >= lower - 1e-9).all()


def test_profile_rises_and_falls_as_a_face():
    heights = np.array([20.0, 3.0, -34.0, -50.0, -76.0, -88.0])  # brow, nose root, tip, nose base, lip, furrow
    brow, root, tip, base, lip, furrow = face_depth(np.zeros(6), heights)
    assert tip > brow and brow > root and tip > base + 10 and lip > furrow


def test_outline_narrows_to_the_chin():
    widths = outline(np.linspace(-117, 0, 50))
    assert (np.diff(widths) > 0).all()


def test_lattice_covers_the_face_once():
    lattice = mean_lattice()
    corners = lattice.points.reshape(-1, 3)[lattice.faces][..., :2]
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    area = (ax * by - ay * bx) / 2
    assert area.min() > -1e-3  # mm^2: none is turned over, but for specks where the lids' rows meet in a corner
    rows = lattice.points[:, -1, :2]
    box = np.abs(np.diff(rows[:, 1])) @ (rows[1:, 0] + rows[:-1, 0])  # the trapezoids between both borders
    assert np.isclose(area.sum(), box, rtol=1e-6)


def test_lattice_normals_of_a_sphere():
    angles = np.linspace(-1, 1, 41)
    polar, azimuth = np.meshgrid(angles[::-1], angles, indexing="ij")
    sphere = np.stack([np.sin(azimuth) * np.cos(polar), np.sin(polar), np.cos(azimuth) * np.cos(polar)], axis=-1)
    normals = lattice_normals(3 * sphere)
    assert np.allclose(normals[1:-1, 1:-1], sphere[1:-1, 1:-1], atol=1e-9)
    assert np.allclose(normals, sphere, atol=0.05)


def test_traits_move_what_they_name():
    count = len(TRAITS)
    number = {trait.name: k for k, trait in enumerate(TRAITS)}

    def moved(name, millimetres):
        values = np.zeros(count)
        values[number[name]] = millimetres
        quiet = np.random.default_rng(0)
        plain = head_shape(HeadTraits(np.zeros(count), np.zeros(count), 0.0, 0.0), quiet)
        other = head_shape(HeadTraits(values, np.zeros(count), 0.0, 0.0), np.random.default_rng(0))
        return (other.points - plain.points).reshape(-1, 3), mean_lattice().points.reshape(-1, 3)

    step, place = moved("nose tip height", 2.0)
    assert np.hypot(*(place[step[:, 2].argmax(), :2] - (0, -34))) < 2 and abs(step[:, 2].max() - 2) < 0.05
    step, place = moved("jaw width", 3.0)
    assert (step[:, 0] * place[:, 0] >= -1e-6).all() and 2.5 < step[:, 0].max() <= 3
    assert np.abs(step[place[:, 1] > -30]).max() < 1e-6
    step, place = moved("upper lid opening", 1.0)
    assert step[:, 1].max() > 0.8 and np.abs(step[np.abs(place[:, 1]) > 20]).max() < 1e-6


def test_every_trait_moves_something_by_about_its_unit():
    points = mean_lattice().points
    for trait in TRAITS:
        step = np.linalg.norm(trait.field(Places.of(mean_lattice())), axis=-1)
        assert step.shape == points.shape[:2]
        assert 0.3 < step.max() < 4, trait.name
        assert trait.spread > 0 and trait.masculine**2 + trait.age**2 < 1


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_heads_have_unit_normals_that_face_the_camera(seed):
    rng = np.random.default_rng(seed)
    head = head_shape(draw_head(rng), rng)
    assert np.isfinite(head.points).all()
    assert np.allclose(np.linalg.norm(head.normals, axis=-1), 1)
    assert head.normals[..., 2].min() > 0


def test_faces_are_nearly_but_not_quite_symmetric():
    unlike, unlike_others = [], []
    heads = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        heads.append(head_shape(draw_head(rng), rng).points)
    for k, points in enumerate(heads):
        unlike.append(np.linalg.norm(points[:, ::-1] * MIRROR - points, axis=-1).mean())
        unlike_others.append(np.linalg.norm(points - heads[k - 1], axis=-1).mean())
    assert 0.3 < np.mean(unlike) < 0.6 * np.mean(unlike_others)
