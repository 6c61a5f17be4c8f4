"""Relighting against pictures that were rendered with the detail that the Surface lacks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.relight import relight
from harmonicface.reflectance.materials import Phong

ADA = hf.synthetic_person(11, 40)
RNG = np.random.default_rng(0)
PORES = 1 + 0.2 * RNG.normal(size=ADA.shape).clip(-2, 2)  # a texture that the albedo lacks
REAL = hf.Surface(ADA.normals.astype(float), ADA.albedo * PORES, ADA.mask)
KNOWN = hf.Surface(ADA.normals.astype(float), ADA.albedo.astype(float), ADA.mask)
WARM = np.array([1.0, 0.8, 0.6])
TINTED = hf.Surface(KNOWN.normals, KNOWN.albedo[..., None] * WARM, KNOWN.mask)
OLD, NEW = hf.lights.sky(0.8) + hf.lights.ambient(0.2), hf.lights.from_angles(40, 20) + hf.lights.ambient(0.1)
COLOURED = hf.lights.directional([1, 1, 1], [1, 0.7, 0.4]) + hf.lights.ambient([0.1, 0.2, 0.3])


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Return the relative root mean square difference in the mask."""
    return float(np.linalg.norm((one - other)[ADA.mask]) / np.linalg.norm(other[ADA.mask]))


@pytest.mark.parametrize("order", [None, 2, 4])
def test_detail_that_nobody_told_of_is_kept(order: int | None) -> None:
    photo = hf.render(REAL, OLD, order=order)
    found = relight(photo, KNOWN, NEW, OLD, order, floor=0)
    assert_allclose(found, np.maximum(hf.render(REAL, NEW, order=order), 0), rtol=1e-10, atol=1e-14)
    assert difference(hf.render(KNOWN, NEW, order=order), found) > 0.1  # the pores are really in it


def test_with_shadows_and_light_thrown_back() -> None:
    real, known = (
        hf.Surface(each.normals, each.albedo, each.mask, ADA.depth, ADA.pixel_size) for each in (REAL, KNOWN)
    )
    photo = hf.render(real, OLD, order=3, shadows=True)
    found = relight(photo, known, NEW, OLD, 3, shadows=True, floor=0)
    assert_allclose(found, np.maximum(hf.render(real, NEW, order=3, shadows=True), 0), rtol=1e-6, atol=1e-7)


def test_with_a_coat() -> None:
    coat = Phong(20, 0.1)
    photo = hf.render(REAL, OLD, material=coat)
    found = relight(photo, KNOWN, NEW, OLD, material=coat, floor=0)
    assert_allclose(found, hf.render(REAL, NEW, material=coat), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("known", [KNOWN, TINTED], ids=["grey surface", "coloured surface"])
def test_coloured_photographs_and_lights(known: hf.Surface) -> None:
    tinted = hf.Surface(known.normals, REAL.albedo[..., None] * WARM, known.mask)
    photo = hf.render(tinted, COLOURED)
    for light in (NEW, COLOURED, [1, 0, 1]):
        found = relight(photo, known, light, COLOURED, floor=0)  # type: ignore[arg-type]
        assert found.shape == (*ADA.shape, 3)
        assert_allclose(found, hf.render(tinted, light), rtol=1e-9, atol=1e-12)  # type: ignore[arg-type]


def test_a_grey_photograph_under_coloured_light_gets_colour() -> None:
    photo = hf.render(REAL, OLD)
    found = relight(photo, KNOWN, COLOURED, OLD, floor=0)
    assert_allclose(found, hf.render(REAL, COLOURED), rtol=1e-9, atol=1e-12)


def test_a_grey_photograph_of_a_coloured_surface_is_its_luminance() -> None:
    grey = hf.Surface(KNOWN.normals, KNOWN.albedo * (WARM @ [0.2126, 0.7152, 0.0722]), KNOWN.mask)
    photo = hf.render(grey, OLD)
    assert_allclose(relight(photo, TINTED, NEW, OLD), hf.render(grey, NEW), rtol=1e-9, atol=1e-12)
    bright = hf.lights.ambient([0.5, 0.4, 0.3])
    as_grey = hf.lights.ambient(float(np.array([0.5, 0.4, 0.3]) @ [0.2126, 0.7152, 0.0722]))
    assert_allclose(relight(photo, TINTED, NEW, bright), relight(photo, TINTED, NEW, as_grey), rtol=1e-9)


def test_there_and_back_again() -> None:
    photo = hf.render(REAL, OLD)
    there = relight(photo, KNOWN, NEW, OLD, floor=0)
    assert_allclose(relight(there, KNOWN, OLD, NEW, floor=0), photo, rtol=1e-10, atol=1e-14)


def test_the_scale_of_the_light_does_not_matter() -> None:
    photo = hf.render(REAL, OLD)
    assert_allclose(
        relight(1e3 * photo, KNOWN, 1e3 * NEW, 1e3 * OLD), 1e3 * relight(photo, KNOWN, NEW, OLD), rtol=1e-10
    )


def test_where_no_light_was_the_albedo_that_is_known_takes_over() -> None:
    lamp = hf.lights.directional([1, 0, 0.2])
    photo = hf.render(REAL, lamp)
    dark = (lamp.irradiance(KNOWN.normals[KNOWN.mask]) == 0).nonzero()[0]
    assert len(dark) > 50
    for floor in (0, 0.1):
        found = relight(photo, KNOWN, NEW, lamp, floor=floor)
        assert_allclose(found[ADA.mask][dark], hf.render(KNOWN, NEW)[ADA.mask][dark], rtol=1e-12)


def test_noise_is_not_blown_up() -> None:
    lamp = hf.lights.directional([1, 0, 0.5])
    photo, noise = hf.render(REAL, lamp), 0.01 * RNG.normal(size=ADA.shape)
    before, after = (light.irradiance(KNOWN.normals[KNOWN.mask]) for light in (lamp, NEW))
    kappa = 0.1 * np.sqrt(np.mean(before**2))
    change = relight(np.maximum(photo + noise, 0), KNOWN, NEW, lamp) - relight(photo, KNOWN, NEW, lamp)
    assert (np.abs(change[ADA.mask]) <= np.abs(noise[ADA.mask]) * after / (2 * kappa) + 1e-12).all()
    plain = relight(np.maximum(photo + noise, 0), KNOWN, NEW, lamp, floor=0) - relight(photo, KNOWN, NEW, lamp, floor=0)
    assert np.abs(plain).max() > 5 * np.abs(change).max()


def test_outside_the_mask_the_photograph_stays() -> None:
    photo = hf.render(REAL, OLD)
    photo[~ADA.mask] = 0.3
    found = relight(photo, KNOWN, COLOURED, OLD)
    assert (found[~ADA.mask] == 0.3).all()
    photo[~ADA.mask] = np.nan  # nobody looks there
    assert np.isfinite(relight(photo, KNOWN, NEW, OLD)[ADA.mask]).all()


def test_single_precision_stays_single() -> None:
    photo = hf.render(ADA, OLD).astype(np.float32)
    assert relight(photo, ADA, NEW, OLD).dtype == np.float32


def test_a_light_that_is_not_told_is_estimated() -> None:
    """People whose detail is not in their Surface, from one natural light into another."""
    errors, without = [], []
    for seed in range(3):
        person = hf.synthetic_person(20 + seed, 40)
        pores = 1 + 0.1 * np.random.default_rng(seed).normal(size=person.shape).clip(-2, 2)
        real = hf.Surface(person.normals, person.albedo * pores.astype(np.float32), person.mask)
        old, new = hf.lights.natural(50 + 2 * seed, size=16), hf.lights.natural(51 + 2 * seed, size=16)
        truth = hf.render(real, new)
        found = relight(hf.render(real, old), person, new)
        errors.append(np.linalg.norm((found - truth)[person.mask]) / np.linalg.norm(truth[person.mask]))
        plain = hf.render(person, new)
        without.append(np.linalg.norm((plain - truth)[person.mask]) / np.linalg.norm(truth[person.mask]))
    assert max(errors) < 0.05
    assert min(without) > 0.08


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"photo": np.ones((3, 3))}, "photo: expected shape .40, 40. or .40, 40, 3., as the surface, got an array"),
        ({"photo": np.full(ADA.shape, np.nan)}, "photo: expected finite numbers"),
        ({"photo": "face.png"}, "photo: expected an array of real numbers, got str"),
        ({"surface": ADA.normals}, "surface: expected a Surface, got an array"),
        ({"light": "noon"}, "light: expected one of 'grace'"),
        ({"photo_light": "noon"}, "light: expected one of 'grace'"),
        ({"photo": np.zeros(ADA.shape), "photo_light": None}, "photo: expected some light"),
        ({"floor": -0.1}, "floor: expected a finite number of at least 0, got -0.1"),
        ({"floor": np.nan}, "floor: expected a finite number of at least 0"),
        ({"floor": "none"}, "floor: expected a number of at least 0, got str"),
        ({"floor": True}, "floor: expected a number of at least 0, got bool"),
        ({"order": -1}, "order: expected an integer of at least 0"),
        ({"material": 3}, "material: expected Phong or Microfacet"),
        ({"shadows": True}, "surface: expected .*depth, .*got"),
        ({"bounces": -1, "order": 2}, "bounces: expected an integer of at least 0"),
    ],
)
def test_what_cannot_be_relit(arguments: dict[str, object], message: str) -> None:
    usual = {"photo": hf.render(REAL, OLD), "surface": KNOWN, "light": NEW, "photo_light": OLD}
    with pytest.raises(hf.HarmonicFaceError, match=message) as error:
        relight(**(usual | arguments))  # type: ignore[arg-type]
    assert "\n" not in str(error.value)
