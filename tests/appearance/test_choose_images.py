"""Images and spectra that errors are predicted from: closed forms, and rays beside horizons."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.choose_error import ErrorTheory
from harmonicface.appearance.choose_images import FARTHEST, PIXELS, images_of
from harmonicface.appearance.choose_lights import light_power
from harmonicface.appearance.principal_lights import light_statistics
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.mesh import surface_from_mesh


def wall(size: int = 6, albedo: float = 1.0) -> hf.Surface:
    return hf.Surface(np.tile([0.0, 0.0, 1.0], (size, size, 1)), np.full((size, size), albedo))


def bowl(side: int = 15) -> hf.Surface:
    """Return a bowl of triangles, which shades itself, as a camera sees it."""
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    z = 1.2 * (x**2 + y**2)
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    grey = np.full((len(vertices), 3), 0.5)
    mesh = Mesh(vertices, faces, np.zeros_like(vertices), None, (), np.full(len(faces), -1), grey)
    return surface_from_mesh(mesh, 12)


def test_images_of_a_matte_surface_are_its_harmonic_images() -> None:
    face = hf.synthetic_person(0, 16)
    found = images_of(face, False, None)
    scale = face.grey_albedo.max()
    assert_allclose(scale * found.exact, hf.harmonic_images(face, 12), atol=1e-5)
    assert_allclose(scale * found.models[False, False], hf.harmonic_images(face, 6), atol=1e-5)
    assert found.pixels == face.mask.sum()


def test_the_spectrum_adds_up_to_all_that_a_lamp_does() -> None:
    found = images_of(wall(), False, None)
    assert found.spectrum.shape == (FARTHEST + 1,)
    assert found.spectrum.sum() == pytest.approx(36 * 2 * np.pi / 3, rel=1e-6)  # the integral of max(cos, 0)^2


def test_the_spectrum_of_hard_shadows_adds_up_to_what_is_not_hidden() -> None:
    depth = np.zeros((300, 2))
    depth[:, 1] = 500.0  # a cliff hides half of the sky from what is at its foot
    surface = hf.Surface(np.tile([0.0, 0.0, 1.0], (300, 2, 1)), np.ones((300, 2)), depth=depth)
    found = images_of(surface, True, None)
    assert found.spectrum.sum() == pytest.approx(
        600 * 2 * np.pi / 3 * (1 - 15 / 32 / 2), rel=0.005
    )  # 15 of 32 azimuths


def test_rays_and_their_models_agree_to_the_noise_of_rays() -> None:
    found = images_of(bowl(), True, None)
    plain, shadowed = found.models[False, False], found.models[True, False]
    noise, hidden = (np.linalg.norm(images - found.exact[:49]) for images in (shadowed, plain))
    assert 0 < noise < 0.1 * np.linalg.norm(found.exact[:49])
    assert hidden > 3 * noise


def test_some_pixels_stand_for_all_of_a_mesh() -> None:
    seen = bowl()
    everything, few = images_of(seen, True, None), None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("harmonicface.appearance.choose_images.PIXELS", 60)
        few = images_of(seen, True, None)
    assert few.exact.shape == (169, 60) and few.pixels == everything.pixels
    assert (few.exact**2).mean() == pytest.approx((everything.exact**2).mean(), rel=0.1)


def test_a_large_picture_is_predicted_by_some_of_its_pixels() -> None:
    small, large = (hf.synthetic_person(3, size) for size in (32, 96))
    assert large.mask.sum() > PIXELS > small.mask.sum()
    statistics = light_statistics("natural")
    errors = [
        ErrorTheory(images_of(face, False, None), statistics, light_power("natural", statistics))
        .of_images((False, False), np.eye(49)[:9], 0.0)
        .total
        for face in (small, large)
    ]
    assert errors[0] == pytest.approx(errors[1], rel=0.05)


def test_gloss_is_that_of_its_pictures() -> None:
    face, coat = hf.synthetic_person(0, 16), hf.Phong(8, 0.2)
    light = hf.lights.natural(0).coefficients(6)
    found = images_of(face, False, coat)
    picture = hf.render(face, hf.HarmonicLight(light), material=coat)[face.mask]
    assert_allclose(face.grey_albedo.max() * light @ found.models[False, True], picture, atol=1e-4)


def test_the_power_of_lamps_is_the_same_in_every_degree() -> None:
    lamp = hf.lights.directional([1, 2, 3], 2.0)
    power = light_power(lamp, light_statistics(lamp))
    assert_allclose(power, 4 / (4 * np.pi), rtol=1e-9)
    assert_allclose(light_power("sphere", light_statistics("sphere")), 1 / (4 * np.pi), rtol=1e-9)


def test_the_power_of_light_of_few_degrees_ends_with_them() -> None:
    power = light_power(np.eye(9), light_statistics(np.eye(9)))
    assert (power[:3] == 1).all() and not power[3:].any()
    grace = hf.lights.published("grace")
    assert not light_power("grace", light_statistics("grace"))[3:].any()
    assert_allclose(light_power(grace, light_statistics(grace)), light_power([grace], light_statistics([grace])))


def test_darkness_is_refused() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="surface: expected some albedo above 0"):
        images_of(wall(albedo=0.0), False, None)
    with pytest.raises(hf.HarmonicFaceError, match="shadows: expected a Surface with depth or a scene"):
        images_of(wall(), True, None)
    statistics = light_statistics(
        np.zeros((4, 4)) + np.diag([0.0, 1, 0, 0])
    )  # light along y, which a wall does not see
    with pytest.raises(hf.HarmonicFaceError, match="lights: expected light that reaches the surface"):
        ErrorTheory(images_of(wall(), False, None), statistics, np.zeros(FARTHEST + 1))
