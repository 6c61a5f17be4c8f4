"""Shape from photographs under unknown general light, rendered with shadows past the surface's own mesh or depth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from harmonicface.appearance.render import render
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting.natural import natural
from harmonicface.people.synthetic import synthetic_person
from harmonicface.stereo.general_unknown_light import general_light_stereo, reduced, reduced_mask

SIZE = (32, 28)


def angles(found, normals):
    """Return degrees between scaled normals and unit normals."""
    unit = found / np.linalg.norm(found, axis=1, keepdims=True)
    return np.degrees(np.arccos(np.clip((unit * normals).sum(axis=1), -1, 1)))


@pytest.fixture(scope="module")
def person():
    return synthetic_person(5, SIZE)


@pytest.fixture(scope="module")
def photographs(person):
    """Fourteen photographs under turned natural light, with shadows and 1 % noise, exposed differently."""
    rng = np.random.default_rng(2)
    pictures = []
    for number in range(14):
        light = natural(number).rotated(Rotation.random(rng=rng))
        picture = render(person, light, order=8, shadows=True)
        grey = picture if picture.ndim == 2 else picture.mean(axis=2)
        pictures.append(grey[person.mask] / np.percentile(grey[person.mask], 99))
    pictures = np.stack(pictures)
    return (pictures + 0.01 * rng.normal(size=pictures.shape)) * np.geomspace(0.1, 10, 14)[:, None]


@pytest.fixture(scope="module")
def found(photographs, person):
    return general_light_stereo(photographs, person.mask, model="harmonic9", face=True)


def test_a_face(found, photographs, person):
    assert angles(found.scaled, person.pixel_normals).mean() < 8
    assert found.model == "harmonic9" and found.model_reason == "asked for"
    assert found.ambiguity.name == "bas-relief" and "mean face" in found.ambiguity.reason
    assert found.lights.shape == (14, 9)
    assert found.depth.shape == SIZE and (np.isfinite(found.depth) == person.mask).all()
    assert len(found.factors.singular_values) == 14


def test_refinement_never_costs_more(found):
    assert len(found.cost) == 3
    assert (np.diff(found.cost) <= 0).all() and found.cost[-1] < found.cost[0]


def test_exposures_return_in_the_lights(found, photographs, person):
    """A photograph is about what its nine numbers of light give on the surface that was found."""
    normals = found.scaled / np.linalg.norm(found.scaled, axis=1, keepdims=True)
    filters = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4], [1, 3, 5])[:, None]
    again = found.lights @ (np.linalg.norm(found.scaled, axis=1) * filters * real_harmonics(normals, 2))
    misfit = np.linalg.norm(again - photographs, axis=1) / np.linalg.norm(photographs, axis=1)
    assert np.median(misfit) < 0.25
    brightness = np.linalg.norm(again, axis=1) / np.linalg.norm(photographs, axis=1)
    assert abs(np.median(brightness) - 1) < 0.2 and brightness.std() < 0.3


def test_without_saying_that_it_is_a_face(photographs, person):
    found = general_light_stereo(photographs, person.mask)
    assert found.model == "harmonic9"
    assert angles(found.scaled, person.pixel_normals).mean() < 14
    assert found.ambiguity.name == "bas-relief" and found.ambiguity.parameters["lambda_std"] == 0.25


def test_first_order_without_shadows():
    """Light of first order on hills: the closed form is a better start than a balloon."""
    y, x = np.mgrid[1:-1:32j, -1:1:32j]
    depth = 0.6 * np.exp(-2 * (x**2 + 1.5 * y**2)) + 0.2 * np.exp(-8 * ((x - 0.4) ** 2 + y**2))
    down, right = np.gradient(depth, x[0, 1] - x[0, 0])
    normals = np.stack([-right, down, np.ones_like(x)], axis=-1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    albedo = (0.5 + 0.1 * np.sin(4 * x + 3 * y)).ravel()
    rng = np.random.default_rng(0)
    light = np.hstack([np.full((14, 1), 3.0), 0.7 * rng.normal(size=(14, 3))])
    pixels = light @ (albedo * np.vstack([np.ones(len(normals)), normals.T]))
    noisy = pixels + 0.002 * rng.normal(size=pixels.shape)
    found = general_light_stereo(noisy, np.ones((32, 32), bool), shadows=False)
    assert found.model == "ambient4" and "4 numbers a light leave" in found.model_reason
    assert found.lights.shape == (14, 4)
    assert angles(found.scaled, normals).mean() < 8


def test_reduction_is_a_mean_over_whole_squares():
    mask = np.ones((5, 6), bool)
    mask[0, 0] = False
    small = reduced_mask(mask, 2)
    assert small.tolist() == [[False, True, True], [True, True, True]]
    grid = np.arange(30.0).reshape(5, 6)
    assert reduced(grid[mask][None], mask, 2, small)[0].tolist() == [5.5, 7.5, 15.5, 17.5, 19.5]


def flat_card(ways, count=14):
    """Return photographs that vary in so many ways, with noise."""
    rng = np.random.default_rng(0)
    parts = rng.uniform(0.2, 1, (ways, 400))
    return rng.uniform(0.5, 1, (count, ways)) @ parts + 0.01 * rng.normal(size=(count, 400))


@pytest.mark.parametrize(
    ("pixels", "mask", "options", "message"),
    [
        (np.ones((12, 400)), np.ones(400, bool), {}, r"mask: expected shape \(h, w\)"),
        (np.ones((12, 400)), np.zeros((20, 20), bool), {}, "mask: expected at least one pixel"),
        (np.ones((12, 399)), np.ones((20, 20), bool), {}, r"pixels: expected shape \(n, 400\)"),
        (np.ones((6, 400)), np.ones((20, 20), bool), {}, "expected at least 7 photographs .* got 6"),
        (np.ones((2, 400)), np.ones((20, 20), bool), {}, "expected at least 7 photographs .* got 2"),
        (np.ones((12, 9)), np.ones((3, 3), bool), {}, "mask: expected at least 100 pixels, got 9"),
        (np.full((12, 400), np.nan), np.ones((20, 20), bool), {}, "pixels: expected finite"),
        (np.ones((12, 400)), np.ones((20, 20), bool), {"model": "three"}, "model: expected one of auto"),
        (flat_card(4, 9), np.ones((20, 20), bool), {"model": "harmonic9"}, "expected at least 12 photographs"),
        (flat_card(4) * np.eye(14)[0][:, None], np.ones((20, 20), bool), {}, "expected light in each photograph"),
        (flat_card(1), np.ones((20, 20), bool), {}, "vary in at least 3 ways, got 1"),
        (flat_card(2), np.ones((20, 20), bool), {}, "vary in at least 3 ways, got 2"),
    ],
)
def test_refusals(pixels, mask, options, message):
    with pytest.raises(HarmonicFaceError, match=message):
        general_light_stereo(pixels, mask, **options)
