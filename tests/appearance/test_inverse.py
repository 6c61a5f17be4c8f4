"""Inverse lighting against exact sums of clamped cosines, closed forms, scipy's least squares and drawn noise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.linalg import lstsq

import harmonicface as hf
from harmonicface.appearance.inverse import estimate_light
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.filters import lambertian_filter, lambertian_weights

Array = NDArray[np.float64]


def whole_sphere(size: int = 40, seed: int = 0, colours: int = 0) -> hf.Surface:
    """Return pixels with normals in all directions."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(size, size, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return hf.Surface(normals, rng.uniform(0.3, 1, (size, size, colours) if colours else (size, size)))


def half_sphere(size: int = 48) -> hf.Surface:
    """Return a white ball as a camera sees it."""
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    inside = x**2 + y**2 < 0.999
    normals = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))], axis=-1) * inside[..., None]
    return hf.Surface(normals, np.ones((size, size)) * inside)


def wall(size: int = 8) -> hf.Surface:
    return hf.Surface(np.tile([0.0, 0.0, 1.0], (size, size, 1)), np.ones((size, size)))


def clamped(normals: Array, directions: Array, strengths: Array) -> Array:
    """Return irradiance by the plain sum over lamps."""
    return np.maximum(normals @ directions.T, 0) @ strengths


def band_limited(surface: hf.Surface, coefficients: Array) -> Array:
    """Return a photograph under harmonics that is integrated numerically, not filtered: a sum over 131,000 lamps."""
    z, weights = np.polynomial.legendre.leggauss(256)
    angles = 2 * np.pi * np.arange(512) / 512
    ring = np.sqrt(1 - z**2)[:, None]
    across, up = ring * np.cos(angles), ring * np.sin(angles)
    directions = np.stack([across, up, np.broadcast_to(z[:, None], across.shape)], axis=-1).reshape(-1, 3)
    radiance = coefficients @ real_harmonics(directions, int(np.sqrt(len(coefficients))) - 1)
    strengths = radiance * np.repeat(weights * 2 * np.pi / 512, 512)
    return surface.albedo * clamped(surface.normals, directions, strengths)


def test_the_light_of_a_band_limited_photograph() -> None:
    rng = np.random.default_rng(1)
    surface = whole_sphere(12)
    truth = rng.normal(size=25) * [1] * 25
    truth[9:16] = 0
    photo = band_limited(surface, truth)
    found = estimate_light(photo, surface, order=4)
    assert_allclose(found.coefficients, truth, atol=2e-3)  # the sum over lamps is good to 1e-4, A_4 is 0.13
    assert found.residual < 1e-4


@pytest.mark.parametrize("order", [0, 1, 2, 4, 8])
def test_exact_harmonic_photographs_give_their_light_back(order: int) -> None:
    surface = whole_sphere()
    values = np.random.default_rng(2).normal(size=(order + 1) ** 2)
    photo = hf.render(surface, hf.HarmonicLight(values))
    found = estimate_light(photo, surface, order)
    dark = (degrees(order) % 2 == 1) & (degrees(order) > 1)
    assert_allclose(found.coefficients[~dark], values[~dark], atol=1e-11)
    assert_array_equal(found.coefficients[dark], 0)
    assert_array_equal(found.recoverable, ~dark)
    assert_array_equal(np.isinf(found.std), dark)
    assert [mode.name for mode in found.unrecoverable] == [
        f"L({degree},{mode})" for degree in range(3, order + 1, 2) for mode in range(-degree, degree + 1)
    ]
    assert_allclose(hf.render(surface, found.light), photo, atol=1e-12)


def penalized(surface: hf.Surface, photo: Array, order: int, noise: float, ridge: float) -> Array:
    """Return the modes up to an order by normal equations that hold the six degrees above at 0.3 of the ambient."""
    far = order + 6
    images = hf.harmonic_images(surface, far)
    degree, visible = degrees(far), np.abs(images).max(axis=1) > 0
    images, degree = images[visible], degree[visible]
    values = photo[surface.mask]
    mean_square = (images[0] ** 2).mean()
    ambient = np.sqrt((values**2).mean() / mean_square)
    modes = 2 * np.arange(2000) + 1
    tail = (modes * (lambertian_filter(1999) / np.pi) ** 2)[far + 1 :].sum() * mean_square
    above = (degree > order) * ((noise / ambient) ** 2 + 0.09 * tail) / 0.09
    decay = np.abs(np.pi / lambertian_weights(far)[visible])
    within = ((degree > 0) & (degree <= order)) * ridge * decay * (images[0] ** 2).sum()
    return np.asarray(np.linalg.solve(images @ images.T + np.diag(above + within), images @ values)[degree <= order])


def test_it_is_penalized_least_squares() -> None:
    surface = whole_sphere()
    photo = np.asarray(hf.render(surface, hf.lights.directional([1, 2, 3])))
    found = estimate_light(photo, surface, noise=0.02, ridge=0.0)
    assert_allclose(found.coefficients, penalized(surface, photo, 2, 0.02, 0.0), atol=1e-9)
    explained = hf.render(surface, found.light)
    assert_allclose(found.residual, np.sqrt(np.mean((photo - explained) ** 2)), rtol=1e-9)
    assert found.pixels == 1600


def test_a_ridge_is_penalized_least_squares() -> None:
    surface = half_sphere(24)
    photo = np.asarray(hf.render(surface, hf.lights.directional([1, 1, 1])))
    found = estimate_light(photo, surface, 4, ridge=0.01, noise=0.01).coefficients
    assert_allclose(found[np.r_[:9, 16:25]], penalized(surface, photo, 4, 0.01, 0.01), atol=1e-9)


def test_singular_values_are_those_of_the_normal_equations() -> None:
    surface = half_sphere()
    images = hf.harmonic_images(surface)
    eigenvalues = np.linalg.eigvalsh(images @ images.T)[::-1]
    found = estimate_light(hf.render(surface, hf.lights.ambient()), surface)
    assert_allclose(found.singular_values, eigenvalues, rtol=1e-9)
    assert_allclose(found.condition, eigenvalues[0] / eigenvalues[-1], rtol=1e-9)


def test_light_above_the_order_hardly_passes_for_light_of_the_order() -> None:
    """On a half sphere and on faces it is several times better to fit the degrees above along."""
    for surface, factor in ((half_sphere(), 0.4), (hf.synthetic_person(3, 48), 0.6)):
        ours, plain = [], []
        for seed in range(12):
            light = hf.lights.natural(seed, 16)
            photo = np.asarray(hf.render(surface, light), np.float64)
            photo = photo + np.random.default_rng(seed).normal(0, 0.01, photo.shape)
            truth = light.coefficients(2)
            ours.append(np.linalg.norm(estimate_light(photo, surface).coefficients - truth))
            images = hf.harmonic_images(surface).astype(np.float64)
            plain.append(np.linalg.norm(lstsq(images.T, photo[surface.mask])[0] - truth))
        assert np.median(ours) < factor * np.median(plain)


def test_the_whole_sphere_has_the_condition_of_the_filter() -> None:
    """Evenly spread normals leave A_0^2 / A_2^2 = 16, A_0^2 / A_4^2 = 576 and A_0^2 / A_8^2 = 16,384."""
    surface = whole_sphere(256)
    for order, expected in ((1, 2.25), (2, 16), (4, 576), (8, 128.0**2)):
        found = estimate_light(hf.render(surface, hf.lights.ambient()), surface, order)
        assert_allclose(found.condition, expected, rtol=0.35)


def test_a_ridge_by_the_decay_helps_where_a_face_is_seen() -> None:
    plain, held = [], []
    for person in range(20, 24):
        surface = hf.synthetic_person(person, 48)
        for seed in range(6):
            light = hf.lights.natural(seed, 16)
            photo = np.asarray(hf.render(surface, light), np.float64)
            photo += np.random.default_rng(seed).normal(0, 0.01, surface.shape)
            truth = light.coefficients(2)
            by_default = estimate_light(photo, surface).coefficients
            assert_array_equal(by_default, estimate_light(photo, surface, ridge="decay").coefficients)
            held.append(np.linalg.norm(by_default - truth))
            plain.append(np.linalg.norm(estimate_light(photo, surface, ridge=0.0).coefficients - truth))
    assert np.median(held) < 0.9 * np.median(plain)


def test_a_ridge_by_the_decay_changes_nothing_where_all_normals_are_seen() -> None:
    surface = whole_sphere()
    for seed in range(4):
        photo = np.asarray(hf.render(surface, hf.lights.natural(seed)), np.float64)
        photo += np.random.default_rng(seed).normal(0, 0.01, photo.shape)
        plain, held = (estimate_light(photo, surface, ridge=ridge).coefficients for ridge in (0.0, "decay"))
        assert np.linalg.norm(held - plain) < 5e-4 * np.linalg.norm(plain)


def test_a_wall_tells_one_number() -> None:
    found = estimate_light(np.full((8, 8), 0.7), wall())
    assert found.condition == np.inf
    assert len(found.determined) == 1
    assert len(found.unrecoverable) == 8
    assert {"L(1,-1)", "L(1,1)", "L(2,-2)", "L(2,-1)", "L(2,1)", "L(2,2)"} < {m.name for m in found.unrecoverable}
    assert not found.recoverable.any()
    assert np.isinf(found.std).all()
    assert_allclose(found.light.irradiance([0.0, 0.0, 1.0]), 0.7)
    expected = [np.pi * 0.5 / np.sqrt(np.pi), 0, 2 * np.pi / 3 * np.sqrt(0.75 / np.pi)]
    direction = found.determined[0].direction
    assert_allclose(direction[[0, 1, 2]] / direction[0], np.array(expected) / expected[0], atol=1e-12)
    assert_allclose(found.coefficients, [0.7 / expected[0], *[0] * 8], atol=1e-12)  # the smoothest light: ambient


def test_a_half_sphere_hides_the_light_from_behind() -> None:
    """A lamp straight behind lights nothing that is seen; its coefficients are (-1)^l Y_l0."""
    surface = half_sphere()
    behind = hf.lights.directional([0, 0, -1]).coefficients(8)[[i * (i + 1) for i in (0, 1, 2, 4, 6, 8)]]
    for order in (2, 4, 6):
        found = estimate_light(hf.render(surface, hf.lights.natural(1)), surface, order, noise=0.01, ridge=0.0)
        hidden = [mode for mode in found.unrecoverable if "hidden" in mode.reason]
        seen = hidden[0].direction[[i * (i + 1) for i in (0, 1, 2, 4, 6, 8) if i <= order]]
        expected = behind[: len(seen)] / np.linalg.norm(behind[: len(seen)])
        assert abs(seen @ expected) > 0.75
        assert not found.recoverable[2]  # L(1,0): front and back differ by what is not seen
        assert found.recoverable[[1, 3, 4]].all()


def test_few_pixels() -> None:
    surface = whole_sphere(10)
    mask = np.zeros((10, 10), bool)
    mask[0, :5] = True
    photo = hf.render(surface, hf.lights.natural(0))
    found = estimate_light(photo, surface, mask=mask, noise=0.01)
    assert found.pixels == 5
    assert len(found.determined) <= 5
    assert len(found.determined) + len(found.unrecoverable) == 9
    assert found.condition == np.inf
    with pytest.raises(hf.HarmonicFaceError, match="noise: expected a number, for no more pixels are left than modes"):
        estimate_light(photo, surface, mask=mask)
    mask[:] = False
    mask[3, 4] = True
    one = estimate_light(photo, surface, mask=mask, noise=0.0)
    assert len(one.determined) == 1


def test_saturated_pixels_are_left_out() -> None:
    surface = whole_sphere()
    light = hf.HarmonicLight([3.0, 0.5, 1.0, -0.4, 0.1, 0.2, 0.3, -0.2, 0.1])
    photo = np.minimum(hf.render(surface, light), 2.0)
    assert_allclose(estimate_light(photo, surface, saturation=2.0).coefficients, light.values, atol=1e-11)
    assert np.abs(estimate_light(photo, surface).coefficients - light.values).max() > 0.05
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected pixels in the masks below saturation=1e-05"):
        estimate_light(photo + 1, surface, saturation=1e-5)


def test_no_light() -> None:
    surface = hf.synthetic_person(0, 24)
    found = estimate_light(np.zeros((24, 24)), surface)
    assert_array_equal(found.coefficients, 0)
    assert found.residual == found.noise == 0
    assert np.isfinite(found.coefficients).all()
    told = estimate_light(np.zeros((24, 24)), surface, noise=0.1)
    assert_allclose(told.coefficients, 0)
    assert (told.std[told.recoverable] > 0).all()


@pytest.mark.parametrize("colours", [0, 3])
def test_colour_photographs(colours: int) -> None:
    surface = whole_sphere(colours=colours)
    values = np.random.default_rng(7).normal(size=(9, 3))
    found = estimate_light(hf.render(surface, hf.HarmonicLight(values)), surface)
    assert_allclose(found.coefficients, values, atol=1e-12)
    assert found.std.shape == found.systematic.shape == found.recoverable.shape == (9, 3)
    assert found.singular_values.shape == (9, 3)
    assert np.shape(found.residual) == np.shape(found.noise) == (3,)
    assert found.light.channels == 3


def test_a_channel_of_its_own() -> None:
    """Where red is reflected by a wall only, red alone tells one number."""
    surface = whole_sphere(colours=3)
    albedo = surface.albedo.copy()
    albedo[1:, :, 0] = 0
    normals = surface.normals.copy()
    normals[0] = [0, 0, 1]
    surface = hf.Surface(normals, albedo)
    found = estimate_light(hf.render(surface, hf.lights.natural(0)), surface)
    grey = estimate_light(hf.render(surface, hf.lights.natural(0)) @ [0.2126, 0.7152, 0.0722], surface)
    assert [mode.channel for mode in found.unrecoverable] == [0] * 8
    assert "(channel 0)" in str(found.unrecoverable[0])
    assert_array_equal(found.recoverable.sum(axis=0), [0, 9, 9])
    assert grey.recoverable.all()


def test_outside_the_mask_nothing_is_read() -> None:
    surface = half_sphere(24)
    photo = np.where(surface.mask, hf.render(surface, hf.lights.natural(2)), np.nan)
    assert np.isfinite(estimate_light(photo, surface).coefficients).all()
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected finite numbers"):
        estimate_light(np.full((24, 24), np.nan), surface)


def test_float32_surfaces_are_solved_in_double_precision() -> None:
    surface = whole_sphere()
    single = hf.Surface(surface.normals.astype(np.float32), surface.albedo.astype(np.float32))
    found = estimate_light(hf.render(single, hf.HarmonicLight(np.arange(9.0))), single)
    assert found.coefficients.dtype == np.float64
    assert_allclose(found.coefficients, np.arange(9.0), atol=1e-5)


def test_many_pixels_in_blocks() -> None:
    surface = whole_sphere(200)
    photo = np.asarray(hf.render(surface, hf.HarmonicLight(np.arange(9.0))))
    assert_allclose(estimate_light(photo, surface).coefficients, np.arange(9.0), atol=1e-12)


def test_bad_input() -> None:
    surface = wall()
    photo = np.ones((8, 8))
    with pytest.raises(hf.HarmonicFaceError, match=r"photo: expected shape \(8, 8\) or \(8, 8, 3\), as the surface"):
        estimate_light(photo[:4], surface)
    with pytest.raises(hf.HarmonicFaceError, match="order: expected an integer of at least 0"):
        estimate_light(photo, surface, -1)
    for noise in (-1.0, np.nan, "much"):
        with pytest.raises(hf.HarmonicFaceError, match="noise: expected a finite number of at least 0"):
            estimate_light(photo, surface, noise=noise)  # type: ignore[arg-type]
    for ridge in (-1.0, np.inf, "more", None):
        with pytest.raises(hf.HarmonicFaceError, match="ridge: expected 'decay' or a finite number"):
            estimate_light(photo, surface, ridge=ridge)  # type: ignore[arg-type]
    for saturation in (0.0, np.nan, True, "a"):
        with pytest.raises(hf.HarmonicFaceError, match="saturation: expected a number above 0"):
            estimate_light(photo, surface, saturation=saturation)  # type: ignore[arg-type]
    with pytest.raises(hf.HarmonicFaceError, match="mask: expected at least one pixel"):
        estimate_light(photo, surface, mask=np.zeros((8, 8), bool))
    with pytest.raises(hf.HarmonicFaceError, match="mask: expected at least one pixel"):
        estimate_light(photo, hf.Surface(surface.normals, photo, mask=np.eye(8) > 0), mask=np.eye(8)[::-1] < 0)
    for dark in (-photo, -np.tri(8)):
        with pytest.raises(hf.HarmonicFaceError, match="photo: expected some light, got values from -1 to"):
            estimate_light(dark, surface)
    assert_allclose(estimate_light(1e30 * photo, surface).light.irradiance([0.0, 0.0, 1.0]), 1e30)
    usual = estimate_light(photo, surface, noise=0.1)
    for huge in (1e31, 1e200, 1e300):
        found = estimate_light(huge * photo, surface, noise=0.1 * huge)
        assert_allclose(found.coefficients / huge, usual.coefficients, atol=1e-12)
        assert_allclose(found.std / huge, usual.std, rtol=1e-12)
    with pytest.raises(hf.HarmonicFaceError, match=r"coefficients: expected at most 1e\+35"):
        _ = found.light
    with pytest.raises(hf.HarmonicFaceError, match="surface: expected some albedo above 0"):
        estimate_light(photo, hf.Surface(surface.normals, 0 * photo))
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected pixels in the masks"):
        lower = hf.Surface(surface.normals, photo, mask=np.tri(8, dtype=bool))
        estimate_light(photo, lower, mask=~np.tri(8, dtype=bool))


def test_what_normals_hide_is_no_matter_of_noise_and_what_noise_drowns_is_not_hidden() -> None:
    """A half sphere hides the light from behind however quiet; on the whole sphere only noise can take modes away."""
    quiet = estimate_light(hf.render(half_sphere(), hf.lights.natural(0)), half_sphere(), 2, noise=1e-6)
    assert [mode.reason.split(":")[0] for mode in quiet.unrecoverable] == ["hidden"]
    surface = whole_sphere(12)
    loud = estimate_light(hf.render(surface, hf.lights.natural(0)), surface, 4, noise=0.6)
    reasons = {mode.reason.split(":")[0] for mode in loud.unrecoverable if not mode.reason.startswith("an odd")}
    assert reasons == {"lost in noise"}


def test_auto_drops_what_noise_decides_and_names_it() -> None:
    surface, rng = half_sphere(24), np.random.default_rng(0)
    coefficients = np.array([1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    photo = hf.render(surface, hf.HarmonicLight(coefficients))
    photo = photo + 0.05 * rng.normal(size=photo.shape)
    full, auto = (estimate_light(photo, surface, ridge=0, model=model) for model in ("full", "auto"))
    assert full.dropped == ()
    assert 3 <= len(auto.dropped) <= 7
    assert all(mode.reason == "dropped: not told from noise" for mode in auto.dropped)
    kept = np.array([mode.direction for mode in auto.dropped]) @ auto.coefficients
    assert_allclose(kept, 0, atol=1e-12)
    assert np.linalg.norm(auto.coefficients - coefficients) < np.linalg.norm(full.coefficients - coefficients)


def test_auto_is_full_where_all_modes_are_told() -> None:
    surface = whole_sphere(12)
    photo = hf.render(surface, hf.HarmonicLight(np.arange(1.0, 10.0)))
    full, auto = (estimate_light(photo, surface, noise=1e-4, model=model) for model in ("full", "auto"))
    assert_array_equal(auto.coefficients, full.coefficients)
    assert auto.dropped == ()


def test_auto_of_fewer_pixels_than_modes_that_are_fitted_along() -> None:
    """Their noise is known by the pixels beyond the nine modes, so that what stands far above it is kept."""
    surface, coefficients = half_sphere(8), np.array([1.0, 0.3, 0.4, -0.3, 0.1, 0.1, 0.2, -0.1, 0.1])
    assert surface.mask.sum() < 48  # modes up to degree 8 that are reflected
    photo = hf.render(surface, hf.HarmonicLight(coefficients))
    photo = photo + 0.002 * np.random.default_rng(0).normal(size=photo.shape)
    full, auto = (estimate_light(photo, surface, ridge=0, model=model) for model in ("full", "auto"))
    assert len(auto.dropped) <= 3
    assert auto.residual < 1.3 * full.residual


def test_auto_of_a_coloured_photograph() -> None:
    surface, rng = half_sphere(20), np.random.default_rng(1)
    photo = hf.render(surface, hf.lights.directional([0.3, 0.2, 1], [1.0, 0.8, 0.6]))
    found = estimate_light(photo + 0.05 * rng.normal(size=photo.shape), surface, model="auto")
    assert found.coefficients.shape == (9, 3)
    assert {mode.channel for mode in found.dropped} <= {None, 0, 1, 2}


def test_no_such_model() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="model: expected 'full' or 'auto', got str 'nine'"):
        estimate_light(np.ones((8, 8)), wall(), model="nine")  # type: ignore[arg-type]
