"""The chosen model against exact pictures: predicted errors are measured, and nothing cheaper would have done."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.choose import RESERVE, ModelChoice, choose_model
from harmonicface.appearance.choose_candidates import Candidate

WALL = hf.Surface(np.tile([0.0, 0.0, 1.0], (6, 6, 1)), np.ones((6, 6)))


def dome(size: int = 24) -> hf.Surface:
    """Return half a sphere with a textured albedo."""
    y, x = -np.mgrid[-1 : 1 : size * 1j, -1 : 1 : size * 1j]
    mask = x**2 + y**2 < 0.98
    normals = np.stack([-x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=2)
    albedo = 0.6 + 0.3 * np.sin(9 * x) * np.cos(7 * y)
    return hf.Surface(np.where(mask[..., None], normals, 0), np.where(mask, albedo, 0), mask)


def measured(candidate: Candidate, surface: hf.Surface, pictures: np.ndarray, noise: float = 0.0) -> float:
    """Return the relative error of fits to exact pictures (n, p) with noise, by numpy's own least squares."""
    spread = noise * np.sqrt((pictures**2).mean())
    noisy = pictures + spread * np.random.default_rng(1).normal(size=pictures.shape)
    images = candidate.pictures(surface).T.astype(float)
    fits = images @ np.linalg.lstsq(images, noisy.T, rcond=1e-7)[0]
    return float(np.sqrt(((fits.T - pictures) ** 2).sum() / (pictures**2).sum()))


def exact(surface: hf.Surface, lights: list[hf.Light], **options: object) -> np.ndarray:
    return np.stack([hf.render(surface, light, **options)[surface.mask] for light in lights]).astype(float)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_errors_of_given_lights_are_those_of_their_exact_pictures(noise: float) -> None:
    surface = dome()
    lights = [hf.lights.natural(seed) for seed in range(12)]
    choice = choose_model(surface, lights, noise=noise)
    pictures = exact(surface, lights)
    for row in choice.table:
        if row.error.total > 2e-3:  # below, few of twelve lights are left
            assert measured(row.candidate, surface, pictures, noise) == pytest.approx(row.error.total, rel=0.05)


def test_errors_of_lamps_over_the_sphere_are_those_of_a_grid_of_lamps() -> None:
    surface = dome()
    grid = hf.EnvironmentMap(np.ones((24, 48)))
    lamps = [
        hf.lights.directional(towards, strength)
        for towards, strength in zip(grid.directions.reshape(-1, 3), np.sqrt(grid.solid_angles).ravel(), strict=True)
    ]
    pictures = exact(surface, lamps)
    for row in choose_model(surface, "sphere").table:
        assert measured(row.candidate, surface, pictures) == pytest.approx(row.error.total, rel=0.03)


def test_shadows_of_a_depth_map() -> None:
    surface = hf.synthetic_person(4, 24)
    lights = [hf.lights.natural(seed, 12) for seed in range(10)]
    lamps = [hf.DirectionalLights(*one.lamps()) if hasattr(hf, "DirectionalLights") else one for one in lights]
    pictures = exact(surface, lamps, shadows=True)
    choice = choose_model(surface, lights)
    assert any(row.candidate.shadows for row in choice.table)
    for name in ("linear3", "ambient4", "harmonic9", "shadowed9", "pca4", "pca6"):
        row = choice.row(name)
        assert measured(row.candidate, surface, pictures) == pytest.approx(row.error.total, rel=0.15)


def test_gloss_of_a_coat() -> None:
    surface, coat = dome(), hf.Phong(10, 0.2)
    lights = [hf.lights.natural(seed, 16) for seed in range(10)]
    pictures = exact(surface, lights, material=coat)
    choice = choose_model(surface, lights, material=coat)
    assert choice.row("harmonic9+gloss").error.total < choice.row("harmonic9").error.total
    for name in ("linear3", "harmonic9", "harmonic25", "harmonic9+gloss", "pca4+gloss"):
        row = choice.row(name)
        assert measured(row.candidate, surface, pictures) == pytest.approx(row.error.total, rel=0.1)


def test_the_cheapest_that_meets_the_tolerance_is_chosen() -> None:
    choice = choose_model(dome(), "sphere", 0.1)
    assert choice.meets
    assert choice.chosen.error.most * RESERVE <= 0.1
    cheaper = [row for row in choice.table if row.cost.order < choice.cost.order]
    assert cheaper and all(row.error.most * RESERVE > 0.1 and not row.meets for row in cheaper)
    assert [row.cost.order for row in choice.table] == sorted(row.cost.order for row in choice.table)


def test_of_equally_many_rows_the_images_that_are_made_soonest() -> None:
    surface = dome()
    enough = 1.001 * RESERVE * choose_model(surface).row("ambient4").error.most
    row = choose_model(surface, tolerance=enough).chosen
    assert (row.name, row.cost.rows, row.cost.images) == ("ambient4", 4, 4)


def test_a_tolerance_that_nothing_meets_is_said_not_to_be_met() -> None:
    choice = choose_model(dome(), "sphere", 1e-6)
    assert not choice.meets and not any(row.meets for row in choice.table)
    assert choice.predicted_error == min(row.error.total for row in choice.table)
    assert "nothing meets 0.0001 %" in str(choice)


def test_one_light_needs_one_picture() -> None:
    surface = dome()
    choice = choose_model(surface, hf.lights.published("grace"), 0.001)
    assert (choice.name, choice.cost.rows) == ("pca1", 1)
    picture = hf.render(
        surface, hf.HarmonicLight(hf.lights.published("grace").coefficients(2) @ [0.2126, 0.7152, 0.0722])
    )
    cosine = np.corrcoef(choice.pictures(surface)[0], picture[surface.mask])[0, 1]
    assert abs(cosine) == pytest.approx(1, abs=1e-5)


def test_a_wall_has_one_picture_under_any_light() -> None:
    choice = choose_model(WALL, "sphere", 1e-3)
    assert choice.cost.rows == 1
    assert choice.predicted_error < 1e-5
    assert choice.row("harmonic9").cost.rows == 1


def test_covariance_of_order_two_is_met_by_nine() -> None:
    choice = choose_model(dome(), np.eye(9), 1e-4)
    assert choice.row("harmonic9").error.total < 1e-6
    assert choice.name == "harmonic9"


def test_noise_is_that_of_fitting_as_many_rows() -> None:
    row = choose_model(WALL, "natural", 0.5, noise=0.6).row("ambient4")
    assert row.error.noise == pytest.approx(0.6 / 6)  # one row of 36 pixels
    assert row.error.total == pytest.approx(np.hypot(row.error.missing, 0.1))


def test_more_noise_can_make_fewer_images_the_better_model() -> None:
    surface = hf.crop(dome(), (8, 14), (8, 14))
    quiet, noisy = (choose_model(surface, "natural", 1e-9, noise) for noise in (0.0, 0.5))
    assert noisy.cost.rows < quiet.cost.rows


def test_components_are_the_best_of_their_number() -> None:
    table = choose_model(dome(), "frontal").table
    for row in table:
        rivals = [other for other in table if other.name.startswith("pca") and other.cost.rows == row.cost.rows]
        assert all(rival.error.total <= row.error.total * (1 + 1e-3) for rival in rivals)


def test_lights_of_the_components_give_their_pictures() -> None:
    surface = dome()
    choice = choose_model(surface, "natural", 0.1)
    images = hf.harmonic_images(surface, 6)
    assert_allclose(choice.pictures(surface), choice.lights @ images[: choice.lights.shape[1]], atol=1e-10)


def test_cost_in_bytes_and_flops() -> None:
    cost = choose_model(WALL).row("pca1").cost
    assert (cost.rows, cost.bytes, cost.flops) == (1, 4 * 36, 2 * 36)


def test_the_table_is_printed_in_full() -> None:
    choice = choose_model(dome(), "natural", 0.05)
    lines = str(choice).splitlines()
    assert len(lines) == 2 + len(choice.table)
    assert lines[0].startswith(f"{choice.name}: the cheapest that meets 5 %")
    assert [line.split()[0] for line in lines[2:]] == [row.name for row in choice.table]


def test_shadows_are_those_of_the_surface_unless_told() -> None:
    person = hf.synthetic_person(0, 16)
    assert any(row.candidate.shadows for row in choose_model(person).table)
    assert not any(row.candidate.shadows for row in choose_model(person, shadows=False).table)


@settings(max_examples=12)
@given(st.floats(1e-3, 0.5), st.sampled_from(["natural", "sphere", "frontal"]), st.floats(0, 0.3))
def test_what_is_chosen_meets_the_tolerance_by_its_own_prediction(tolerance: float, lights: str, noise: float) -> None:
    choice: ModelChoice = choose_model(dome(12), lights, tolerance, noise)
    assert choice.meets == any(row.error.most * RESERVE <= tolerance for row in choice.table)
    assert choice.meets == (choice.chosen.error.most * RESERVE <= tolerance)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"surface": 3}, "surface: expected a Surface"),
        ({"tolerance": 0}, "tolerance: expected"),
        ({"noise": -1}, "noise: expected"),
        ({"noise": np.nan}, "noise: expected"),
        ({"noise": True}, "noise: expected"),
        ({"shadows": "yes"}, "shadows: expected True, False or None"),
        ({"shadows": True}, "shadows: expected a Surface with depth"),
        ({"material": "skin"}, "material: expected Phong or Microfacet"),
        ({"lights": "moon"}, "lights?: expected"),
        ({"lights": np.zeros((9, 9))}, "lights: expected light that reaches the surface"),
        ({"surface": hf.Surface(WALL.normals, np.zeros((6, 6)), WALL.mask)}, "expected some albedo above 0"),
    ],
)
def test_bad_input(options: dict[str, object], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        choose_model(**({"surface": WALL} | options))


def test_a_candidate_that_does_not_exist() -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"name: expected one of .*pca1.*, got 'nine'"):
        choose_model(WALL).row("nine")
