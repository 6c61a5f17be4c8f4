import dataclasses

import numpy as np
import pytest

from harmonicface.io.colour import luminance
from harmonicface.people.complexion import draw_complexion
from harmonicface.people.ict_albedo import DARKEST_TONE, LIGHTEST_TONE, draw_head_skin, head_textures
from harmonicface.people.ict_atlas import COARSEST, FINEST, texture_maps, texture_side
from harmonicface.people.ict_model import BACK, FACE, LEFT_EYE, RIGHT_EYE, read_ict_model
from harmonicface.people.ict_places import (
    above_hairline,
    aligned,
    ear_share,
    face_share,
    head_places,
    nostril_share,
)
from harmonicface.people.skin import MOUTH_HALF_WIDTH, lip_margins
from harmonicface.surfaces.texture import look_up

SIDE = 256


@pytest.fixture(scope="module")
def model(data_dir):
    return read_ict_model(data_dir / "heads/ICT-FaceKit")


@pytest.fixture(scope="module")
def skin():
    return draw_head_skin(np.random.default_rng(3))


@pytest.fixture(scope="module")
def textures(model, skin):
    return head_textures(model, skin, SIDE, colour=True)


def seen_at(model, textures, part, vertices):
    """Return the colours that a part shows at its vertices."""
    return look_up(textures[part], model.uv[vertices])


@pytest.mark.data
def test_both_sides_of_a_cut_in_the_texture_agree(model, skin):
    textures = head_textures(model, skin, 2 * SIDE, colour=True)  # fine enough for strands of hair
    owner = np.full(len(model.source), -1)
    for part in (BACK, FACE):
        owner[np.unique(model.faces[model.parts == part])] = part
    order = np.argsort(model.source, kind="stable")
    twins = order[:-1][model.source[order[:-1]] == model.source[order[1:]]]
    others = order[1:][model.source[order[:-1]] == model.source[order[1:]]]
    # the sockets of eyes and mouth are sewn on where nobody sees it
    visible = (owner[twins] >= 0) & (owner[others] >= 0) & (head_places(model).points[twins, 2] < 0)
    twins, others = twins[visible], others[visible]
    assert len(twins) > 100
    assert (owner[twins] != owner[others]).sum() > 50  # the face's texture against that of the back of the head

    def values(vertices):
        found = np.zeros((len(vertices), 3))
        for part in (FACE, BACK):
            found[owner[vertices] == part] = seen_at(model, textures, part, vertices[owner[vertices] == part])
        return found

    here, there = values(twins), values(others)
    step = np.abs(np.log(here / there))
    assert np.median(step) < 0.01
    assert np.quantile(step, 0.99) < 0.05
    shuffled = np.abs(np.log(here / np.roll(there, 7, axis=0)))
    assert np.median(step) < 0.2 * np.median(shuffled)


@pytest.mark.data
def test_nothing_foreign_bleeds_in_at_the_borders(model):
    texture = texture_maps(model, SIDE)[FACE]
    picture = texture.picture(np.ones(len(texture.texels.x)))
    assert picture.shape == (SIDE, SIDE) and (picture == 1).all()
    height = texture.picture(texture.texels.y)
    vertices = np.unique(model.faces[model.parts == FACE])
    error = look_up(height, model.uv[vertices]) - head_places(model).points[vertices, 1]
    assert np.quantile(np.abs(error), 0.95) < 0.5  # the folds inside lids and nostrils are finer than a texel


@pytest.mark.data
def test_parts_have_the_colours_of_what_they_are(model, textures, skin):
    points = aligned(model, model.neutral)

    def colour(vertices):
        kept = np.flatnonzero(np.isin(model.source, vertices))
        kept = kept[np.isin(kept, model.faces[model.parts == FACE])]
        return seen_at(model, textures, FACE, kept).mean(axis=0)

    lips = colour(model.landmarks[[61, 62, 63, 65, 66, 67, 51, 57]])
    cheek = colour(np.flatnonzero((np.abs(points[:, 0] - 38) < 4) & (np.abs(points[:, 1] + 50) < 4)))
    assert luminance(lips) < luminance(cheek)
    assert lips[0] / lips[1] > cheek[0] / cheek[1]
    for part in (LEFT_EYE, RIGHT_EYE):
        own = np.unique(model.faces[model.parts == part])
        radius = np.hypot(*head_places(model).gaze[own].T)
        front = points[model.source[own], 2] > 0
        grey = luminance(seen_at(model, textures, part, own))
        pupil, iris, white = (grey[front & (radius > a) & (radius < b)].mean() for a, b in ((0, 1), (3, 5), (7, 9)))
        assert pupil < 0.05 < iris < white and white > 0.25


@pytest.mark.data
def test_ears_are_redder_than_the_neck_and_the_crown_has_hair(model, textures, skin):
    points = aligned(model, model.neutral)[model.source]
    seen = {part: np.unique(model.faces[model.parts == part]) for part in (FACE, BACK)}
    ear = seen[FACE][ear_share(points[seen[FACE]]) > 0.9]
    neck = seen[BACK][points[seen[BACK], 1] < -160]
    crown = seen[BACK][points[seen[BACK], 1] > 100]
    ear, neck, crown = (
        seen_at(model, textures, part, own).mean(axis=0) for part, own in ((FACE, ear), (BACK, neck), (BACK, crown))
    )
    assert ear[0] / ear[1] > 1.05 * neck[0] / neck[1]
    assert luminance(crown) == pytest.approx(skin.complexion.hair, rel=0.5)


@pytest.mark.data
def test_grey_is_the_luminance_of_colour(model, skin, textures):
    grey = head_textures(model, skin, SIDE, colour=False)
    assert [texture.shape for texture in grey] == [(SIDE, SIDE)] * 2 + [(SIDE // 2, SIDE // 2)] * 2
    for one, other in zip(grey, textures, strict=True):
        assert one.dtype == other.dtype == np.float32
        assert np.quantile(np.abs(luminance(other) / one - 1), 0.99) < 1e-5


@pytest.mark.data
def test_the_beard_is_on_the_face_alone(model, skin):
    bare = dict.fromkeys(("moustache_density", "chin_beard_density", "stubble_density"), 0.0)
    shaved, bearded = (
        dataclasses.replace(skin, complexion=dataclasses.replace(skin.complexion, **bare, beard_density=density))
        for density in (0.0, 0.8)
    )
    textures = [head_textures(model, person, SIDE, colour=False) for person in (shaved, bearded)]
    change = [np.abs(np.log(one / other)) for one, other in zip(*textures, strict=True)]
    assert change[FACE].max() > 0.5
    assert change[LEFT_EYE].max() == change[RIGHT_EYE].max() == 0
    places = texture_maps(model, SIDE)[BACK]
    neck = places.picture(places.texels.points[:, 2]) < -80
    assert change[BACK][neck].max() == 0


@pytest.mark.data
def test_lids_and_lips_lie_on_the_mean_face(model):
    places = head_places(model)
    at = {vertex: index for index, vertex in enumerate(model.source.tolist())}
    corners = places.points[[at[model.landmarks[k]] for k in (48, 54)]]
    assert np.allclose(corners[:, 0], [-MOUTH_HALF_WIDTH, MOUTH_HALF_WIDTH], atol=0.1)
    upper, lower = (places.points[at[model.landmarks[k]]] for k in (51, 57))
    _, highest, lowest = lip_margins(np.zeros(1))
    assert upper[1] == pytest.approx(highest[0], abs=0.1)
    assert lower[1] == pytest.approx(lowest[0], abs=0.1)


def test_shares_of_the_head():
    cheek, ear, nape, nostril = [45.0, -40, 20], [85.0, -25, -90], [0.0, -100, -135], [8.0, -35, 27]
    places = np.array([cheek, ear, nape, nostril])
    assert face_share(places).tolist() == [1, 0, 0, 1]
    assert ear_share(places).tolist() == [0, 1, 0, 0]
    assert nostril_share(places).tolist() == [0, 0, 0, 1]
    crown, forehead = np.array([[0.0, 105, -70], [0.0, 40, 25]])
    assert above_hairline(np.array([crown]), 78)[0] > 0 > above_hairline(np.array([forehead]), 78)[0]
    assert above_hairline(np.array([forehead]), 30)[0] == pytest.approx(10)


def test_texture_sides_follow_the_pixels():
    sides = [texture_side(size) for size in (100.0, 2.25, 1.125, 0.56, 0.01)]
    assert sides[0] == COARSEST and sides[-1] == FINEST
    assert sides == sorted(sides) and all(side % 64 == 0 for side in sides)
    assert 230 / texture_side(1.125) < 1.125  # a texel is finer than a pixel


def test_tones_are_those_of_skin_and_keep_their_order():
    skins = [draw_head_skin(np.random.default_rng(seed)) for seed in range(300)]
    tones = np.array([skin.complexion.tone for skin in skins])
    assert DARKEST_TONE <= tones.min() < 0.23 and 0.46 < tones.max() <= LIGHTEST_TONE
    assert np.median(tones) == pytest.approx(0.34, abs=0.02)


def test_a_skin_is_drawn_by_its_seed():
    one, same, other = (draw_head_skin(np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one.pigments == same.pigments != other.pigments
    assert one.complexion.tone == same.complexion.tone
    assert np.array_equal(one.complexion.marks, same.complexion.marks)
    assert draw_complexion(np.random.default_rng(1), 0.0, 0.0).tone != one.complexion.tone
