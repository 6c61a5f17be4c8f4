"""Pictures against a loop over pixels and lamps, and the published errors of nine harmonics."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting.sources import DirectionalLights

RNG = np.random.default_rng(0)
NORMALS = RNG.normal(size=(6, 5, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=2, keepdims=True)
MASK = RNG.uniform(size=(6, 5)) < 0.7
GREY = RNG.uniform(0.1, 1, (6, 5))
COLOUR = RNG.uniform(0.1, 1, (6, 5, 3))
LAMPS = RNG.normal(size=(4, 3))


@pytest.mark.parametrize("albedo", [GREY, COLOUR], ids=["grey surface", "coloured surface"])
@pytest.mark.parametrize("strengths", [RNG.uniform(0, 1, 4), RNG.uniform(0, 1, (4, 3))], ids=["grey", "coloured"])
def test_exact_pictures(albedo: np.ndarray, strengths: np.ndarray) -> None:
    colours = max(albedo.ndim - 1, strengths.ndim) > 1
    expected = np.zeros((6, 5, 3) if colours else (6, 5))
    for row, column in zip(*np.nonzero(MASK), strict=True):
        for lamp, strength in zip(LAMPS, strengths, strict=True):
            cosine = NORMALS[row, column] @ lamp / np.sqrt(lamp @ lamp)
            if cosine > 0:
                expected[row, column] += albedo[row, column] * strength * cosine
    picture = hf.render(hf.Surface(NORMALS, albedo, MASK), DirectionalLights(LAMPS, strengths))
    assert picture.shape == expected.shape
    assert_allclose(picture, expected, rtol=1e-12)
    assert not picture[~MASK].any()


def test_a_wall_that_faces_the_lamp_is_as_bright_as_its_albedo() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (2, 3, 1)), np.full((2, 3), 0.25))
    assert_allclose(hf.render(wall, hf.lights.directional([0, 0, 9])), 0.25, rtol=1e-15)
    assert_allclose(hf.render(wall, hf.lights.ambient(1.0)), 0.25, rtol=1e-15)
    assert not hf.render(wall, hf.lights.directional([0, 0, -1])).any()


def test_pictures_add_as_lights_do() -> None:
    surface = hf.Surface(NORMALS, COLOUR, MASK)
    sun, sky = hf.lights.directional([1, 1, 1], [1, 0.9, 0.7]), hf.lights.natural(1, size=4)
    together = hf.render(surface, 0.5 * sun + sky)
    assert_allclose(together, 0.5 * hf.render(surface, sun) + hf.render(surface, sky), rtol=1e-12)


def sphere_of_normals() -> hf.Surface:
    """Normals all over the sphere, evenly: Fibonacci's spiral."""
    count = 40_000
    z = 1 - (2 * np.arange(count) + 1) / count
    angles = np.arange(count) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    normals = np.stack([across * np.cos(angles), across * np.sin(angles), z], axis=-1)
    return hf.Surface(normals.reshape(200, 200, 3), np.ones((200, 200)))


# Of the energy 2 pi / 3 of the clamped cosine, order 2 leaves 1 - .375 - .5 - .1171875 = .0078125: its root is 8.84 %.
@pytest.mark.parametrize(("order", "energy_left"), [(0, 0.625), (1, 0.125), (2, 0.0078125), (4, 0.001953125)])
@pytest.mark.parametrize("towards", [[0, 0, 1], [1, -2, 0.5]])
def test_error_of_few_harmonics_under_one_lamp(order: int, energy_left: float, towards: list[float]) -> None:
    sphere = sphere_of_normals()
    lamp = hf.lights.directional(towards)
    exact = hf.render(sphere, lamp)
    error = hf.render(sphere, lamp, order=order) - exact
    assert_allclose(np.mean(error**2) / np.mean(exact**2), energy_left, rtol=2e-3)


def test_single_precision_stays_single() -> None:
    surface = hf.Surface(NORMALS.astype(np.float32), GREY.astype(np.float32), MASK)
    lamp = hf.lights.directional([1, 1, 1])
    for order in (None, 2):
        assert hf.render(surface, lamp, order=order).dtype == np.float32


def test_no_order() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="order: expected an integer of at least 0"):
        hf.render(hf.Surface(NORMALS, GREY, MASK), hf.lights.ambient(1), order=-1)


DEPTH = RNG.uniform(0, 2, (6, 5))
HOLLOW = hf.Surface(NORMALS * np.sign(NORMALS[..., 2:]), GREY, MASK, DEPTH)
TINTED = hf.Surface(HOLLOW.normals, COLOUR, MASK, DEPTH)
SKY = hf.lights.natural(1, size=4)


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("grace", hf.lights.published("grace")),
        ([1, 2, 3], hf.lights.directional([1, 2, 3])),
        (SKY.coefficients(2), hf.HarmonicLight(SKY.coefficients(2))),
        (["grace", [1, 2, 3]], hf.lights.published("grace") + hf.lights.directional([1, 2, 3])),
    ],
    ids=["name", "direction", "coefficients", "list"],
)
def test_whatever_is_a_light(given: object, meant: hf.Light) -> None:
    assert_allclose(hf.render(HOLLOW, given), hf.render(HOLLOW, meant), rtol=0)  # type: ignore[arg-type]


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("settings", [{}, {"shadows": True}, {"bounces": 1}], ids=repr)
def test_harmonic_pictures_are_sums_of_harmonic_images(order: int, settings: dict[str, int]) -> None:
    expected = SKY.grey().coefficients(order) @ hf.harmonic_images(HOLLOW, order, **settings)  # type: ignore[arg-type]
    found = hf.render(HOLLOW, SKY.grey(), order=order, **settings)  # type: ignore[arg-type]
    assert_allclose(found[MASK], expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("settings", [{"shadows": True}, {"shadows": True, "order": 2}, {"bounces": 1, "order": 2}])
@pytest.mark.parametrize("surface", [HOLLOW, TINTED], ids=["grey surface", "coloured surface"])
def test_colours_are_lit_one_by_one(surface: hf.Surface, settings: dict[str, int]) -> None:
    colours = hf.lights.directional([1, 1, 1], [1, 0.5, 0.25]) + hf.lights.directional([-1, 0, 1], [0.1, 0.2, 0.8])
    found = hf.render(surface, colours, **settings)  # type: ignore[arg-type]
    for channel, (first, second) in enumerate([(1, 0.1), (0.5, 0.2), (0.25, 0.8)]):
        grey = hf.lights.directional([1, 1, 1], first) + hf.lights.directional([-1, 0, 1], second)
        albedo = surface.albedo if surface.albedo.ndim == 2 else surface.albedo[..., channel]
        alone = hf.render(hf.Surface(surface.normals, albedo, MASK, DEPTH), grey, **settings)  # type: ignore[arg-type]
        assert_allclose(found[..., channel], alone, rtol=1e-5, atol=1e-6)


def test_shadows_only_take_light_away() -> None:
    free, shadowed = (hf.render(HOLLOW, [1, 1, 0.3], shadows=shadows) for shadows in (False, True))
    assert (shadowed <= free * (1 + 1e-6)).all()
    assert (shadowed < free).any()


def test_light_thrown_back_implies_shadows() -> None:
    white = hf.lights.ambient(1.0)
    assert_allclose(
        hf.render(HOLLOW, white, order=2, bounces=1), hf.render(HOLLOW, white, order=2, bounces=1, shadows=True), rtol=0
    )
    assert (hf.render(HOLLOW, white, order=2, bounces=1) != hf.render(HOLLOW, white, order=2)).any()


@pytest.mark.parametrize("shadows", [False, True])
def test_no_more_orders_than_the_light_has(shadows: bool) -> None:
    for light in ("grace", hf.lights.published("grace") + hf.lights.published("eucalyptus")):
        found = hf.render(HOLLOW, light, order=1000, shadows=shadows)
        assert_allclose(found, hf.render(HOLLOW, light, order=2, shadows=shadows), rtol=0)
    fresh = hf.Surface(HOLLOW.normals, HOLLOW.albedo, HOLLOW.mask, HOLLOW.depth)
    hf.render(fresh, "grace", order=1000, shadows=True)
    assert fresh.transports[0].order == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"light": "noon"}, "light: expected one of 'grace'"),
        ({"material": "wet"}, "material: expected Phong or Microfacet, got str"),
        ({"bounces": None}, "bounces: expected an integer of at least 0, got NoneType"),
        ({"bounces": None, "shadows": True}, "bounces: expected an integer of at least 0, got NoneType"),
        ({"shadows": "no"}, "shadows: expected True or False, got str 'no'"),
        ({"order": 201}, "order: expected at most 200, .* got 201"),
        ({"order": 10**9}, "order: expected at most 200, .* got 1e.09"),
        ({"order": 13, "shadows": True}, "order: expected at most 12 with shadows, .* got 13"),
        ({"order": -1, "light": "grace"}, "order: expected an integer of at least 0"),
        ({"bounces": -1}, "bounces: expected an integer of at least 0"),
        ({"bounces": -1, "order": 2}, "bounces: expected an integer of at least 0"),
        ({"surface": hf.Surface(NORMALS, GREY, MASK), "shadows": True}, "surface: expected .* got"),
        ({"surface": hf.Surface(NORMALS, GREY, MASK), "shadows": True, "order": 2}, "surface: expected depth"),
        ({"surface": NORMALS}, "surface: expected a Surface, got an array"),
    ],
)
def test_what_cannot_be_shown(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.render(**({"surface": HOLLOW, "light": SKY} | arguments))  # type: ignore[arg-type]
