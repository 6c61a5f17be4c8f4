from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import subspace_angles

import harmonicface as hf
from harmonicface.appearance.principal import analytic_pca
from harmonicface.recognition.models import SUBSPACE_MODELS, subspace_model

SURFACE = hf.synthetic_person(0, size=24)
ALBEDO = SURFACE.pixel_albedo.astype(np.float64)
X, Y, Z = SURFACE.pixel_normals.astype(np.float64).T
SPANS = {
    "linear3": [X, Y, Z],
    "ambient4": [np.ones_like(X), X, Y, Z],
    "harmonic9": [np.ones_like(X), X, Y, Z, X * Y, Y * Z, X * Z, X * X - Y * Y, Z * Z],
}


@pytest.mark.parametrize("name", SPANS)
def test_a_model_spans_its_pictures(name: str) -> None:
    pictures = subspace_model(name)(SURFACE)
    expected = ALBEDO * np.array(SPANS[name])
    assert pictures.shape == expected.shape
    assert subspace_angles(pictures.T.astype(np.float64), expected.T).max() < 1e-4


def test_linear_pictures_are_those_without_shadows() -> None:
    # 2 pi / 3 times sqrt(3 / 4 pi) is the weight of a harmonic of degree one
    weight = 2 * np.pi / 3 * np.sqrt(3 / (4 * np.pi))
    assert_allclose(subspace_model("linear3")(SURFACE), weight * ALBEDO * np.array([Y, Z, X]), rtol=0, atol=1e-6)


def test_shadowed_pictures_have_less_light_where_depth_hides_it() -> None:
    pictures = subspace_model("harmonic_shadowed")(SURFACE)
    assert pictures.shape == (25, len(ALBEDO))
    ambient, free = pictures[0], hf.harmonic_images(SURFACE, order=0)[0]
    assert (ambient <= free + 1e-5).all()
    assert (ambient < 0.8 * free).any()  # beside the nose


def test_shadows_need_something_that_casts_them() -> None:
    flat = hf.Surface(SURFACE.normals, SURFACE.albedo, SURFACE.mask)
    with pytest.raises(hf.HarmonicFaceError, match="surface: expected depth, which casts the shadows, got a Surface"):
        subspace_model("harmonic_shadowed")(flat)


@pytest.mark.parametrize(("name", "rank"), [("pca3", 3), ("pca5", 5), ("pca_auto", None)])
def test_principal_pictures_span_the_components_of_lamps_in_front(name: str, rank: int | None) -> None:
    found = analytic_pca(SURFACE, rank or 0.99, lights="frontal", centered=False)
    pictures = subspace_model(name)(SURFACE)
    assert pictures.shape == (25, len(ALBEDO))
    for rows in (pictures, pictures.astype(np.float32)):  # no rounding passes for a picture
        subspace = hf.Subspace.of(rows)
        assert subspace.rank == len(found.variances)
        assert subspace_angles(subspace.rows.T.astype(np.float64), found.components.T.astype(np.float64)).max() < 1e-4
    assert (found.explained.sum() >= 0.99) == (name != "pca3")


def test_principal_pictures_tell_the_light_as_the_components_do() -> None:
    found = analytic_pca(SURFACE, 5, lights="frontal", centered=False)
    photo = hf.render(SURFACE, hf.lights.directional([0.4, 0.3, 1.0]))
    told = hf.Subspace.of(subspace_model("pca5")(SURFACE)).coefficients(photo[SURFACE.mask])
    assert_allclose(told, found.light(found.transform(photo)).values, atol=1e-4)
    relit = hf.render(SURFACE, told, order=4)
    assert np.linalg.norm(relit - photo) < 0.05 * np.linalg.norm(photo)


def test_a_gallery_of_principal_components_names_people_and_their_light() -> None:
    people = list(hf.synthetic_people(3, 24, seed=1))
    gallery = hf.Gallery(model="pca5")
    for number, face in enumerate(people):
        gallery.enroll(str(number), face)
    photo = hf.render(people[1], hf.lights.directional([0.4, 0.3, 1.0]))
    match = gallery.match(photo)
    assert match.name == "1" and gallery.bytes_per_person == 5 * 24 * 24 * 4
    assert match.light is not None and match.light.order == 4
    relit = hf.render(people[1], match.light, order=4)
    assert_allclose(np.linalg.norm(relit - photo) / np.linalg.norm(photo), match.distance, rtol=1e-3)


@pytest.mark.parametrize("name", ["magic", "", "Harmonic9"])
def test_no_such_model(name: str) -> None:
    with pytest.raises(
        hf.HarmonicFaceError, match=f"model: expected one of {', '.join(SUBSPACE_MODELS)}, got '{name}'"
    ):
        subspace_model(name)
