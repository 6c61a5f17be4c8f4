from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.photometric_stereo import photometric_stereo

Doubles = NDArray[np.float64]
SIZE, RADIUS = 40, 22.0
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE]
X, Y = (COLUMNS - SIZE / 2 + 0.5) / RADIUS, (SIZE / 2 - 0.5 - ROWS) / RADIUS
MASK = X**2 + Y**2 < 0.75
NORMALS = np.stack([X, Y, np.sqrt(np.maximum(1 - X**2 - Y**2, 0.01))], axis=2)
NORMALS /= np.linalg.norm(NORMALS, axis=2, keepdims=True)
RANDOM = np.random.default_rng(0)
COLOURS = RANDOM.uniform(0.2, 0.8, (SIZE, SIZE, 3))
LAMPS = RANDOM.normal(size=(12, 3)) * [1, 1, 0.3] + [0, 0, 1.5]
LAMPS /= np.linalg.norm(LAMPS, axis=1, keepdims=True)
SHADING = np.maximum(np.einsum("nk,hwk->nhw", LAMPS, NORMALS), 0)
GREY = 0.5 * SHADING


def degrees(normals: NDArray[np.floating]) -> Doubles:
    return np.degrees(np.arccos(np.clip((normals * NORMALS).sum(axis=2)[MASK], -1, 1)))


@pytest.mark.parametrize("method", ["matte", "least_squares"])
def test_a_lit_ball_is_exact(method: str) -> None:
    facing = MASK & (SHADING > 0).all(axis=0)
    found = photometric_stereo(GREY, LAMPS, facing, method=method)  # type: ignore[arg-type]
    assert_allclose((found.surface.normals * NORMALS).sum(axis=2)[facing], 1, atol=1e-6)
    assert_allclose(found.surface.albedo[facing], 0.5, atol=1e-6)
    depth = found.surface.depth
    assert depth is not None
    rest = depth[facing] - RADIUS * NORMALS[facing][:, 2]
    assert np.ptp(rest) < 0.02 * RADIUS
    assert found.model == "linear3" and found.ambiguity.name == "none" and found.left_out == {}
    assert_allclose(found.lights, LAMPS)
    assert found.gap > 1e4 and found.condition == pytest.approx(found.singular_values[0] / found.singular_values[2])


def test_robust_sees_past_shadows() -> None:
    assert not (SHADING[:, MASK] > 0).all()
    assert degrees(photometric_stereo(GREY, LAMPS, MASK).surface.normals).max() < 0.1
    assert degrees(photometric_stereo(GREY, LAMPS, MASK, method="least_squares").surface.normals).max() > 1


def test_brightness_of_lamps_in_one_number_or_three() -> None:
    one = RANDOM.uniform(0.2, 1.8, 12)
    found = photometric_stereo(GREY * one[:, None, None], LAMPS, MASK, intensities=one, method="matte")
    assert degrees(found.surface.normals).max() < 0.1
    assert_allclose(found.surface.albedo[MASK], 0.5, atol=1e-5)
    assert_allclose(found.lights, LAMPS * one[:, None])
    three = RANDOM.uniform(0.2, 1.0, (12, 3))
    images = np.einsum("hwc,nc,nhw->nhwc", COLOURS, three, SHADING)
    found = photometric_stereo(images, LAMPS, MASK, intensities=three, method="matte")
    assert degrees(found.surface.normals).max() < 0.1
    assert_allclose(found.surface.albedo[MASK], COLOURS[MASK], atol=1e-5)


def test_white_lamps_show_colours() -> None:
    images = np.einsum("hwc,nhw->nhwc", COLOURS, SHADING)
    found = photometric_stereo(images, LAMPS, MASK, method="matte")
    assert_allclose(found.surface.albedo[MASK], COLOURS[MASK], atol=1e-5)
    grey = photometric_stereo(images.mean(axis=3), LAMPS, MASK, method="matte")
    assert_allclose(found.surface.normals, grey.surface.normals, atol=1e-5)


def test_saturated_colours_are_left_out() -> None:
    images = np.einsum("hwc,nhw->nhwc", COLOURS, SHADING) * 1.4
    assert ((images[:, MASK] > 1).mean() > 0.005) and images.max() > 1.05
    found = photometric_stereo(np.minimum(images, 1), LAMPS, MASK, method="matte")
    assert degrees(found.surface.normals).max() < 0.1
    assert_allclose(found.surface.albedo[MASK], 1.4 * COLOURS[MASK], atol=1e-4)


def test_a_mapped_file_gives_the_same(tmp_path: Path) -> None:
    np.save(tmp_path / "images.npy", GREY.astype(np.float32))
    mapped = np.lib.format.open_memmap(tmp_path / "images.npy", mode="r")
    found, expected = (photometric_stereo(each, LAMPS, MASK) for each in (mapped, GREY.astype(np.float32)))
    assert_array_equal(found.surface.normals, expected.surface.normals)


def test_outside_the_mask_images_hold_anything() -> None:
    images = GREY.copy()
    images[:, ~MASK] = np.nan
    assert degrees(photometric_stereo(images, LAMPS, MASK, method="matte").surface.normals).max() < 0.1


@pytest.mark.parametrize("integration", ["poisson", "weighted", "bilateral"])
def test_every_integration_of_a_ball_is_a_ball(integration: str) -> None:
    found = photometric_stereo(GREY, LAMPS, MASK, integration=integration, pixel_size=0.1)  # type: ignore[arg-type]
    assert found.surface.depth is not None and found.surface.pixel_size == 0.1
    assert np.ptp(found.surface.depth[MASK] - 0.1 * RADIUS * NORMALS[MASK][:, 2]) < 0.1 * 0.02 * RADIUS


def test_without_integration_there_is_no_depth() -> None:
    assert photometric_stereo(GREY, LAMPS, MASK, integration="none").surface.depth is None


@pytest.mark.parametrize("integration", ["poisson", "bilateral"])
def test_before_a_pinhole_depth_is_a_distance(integration: str) -> None:
    wall = np.tile(LAMPS[:, 2, None, None] * 0.5, (1, 6, 8))
    found = photometric_stereo(
        wall,
        LAMPS,
        intrinsics=(400, 400, 4, 3),
        distance=2.0,
        integration=integration,  # type: ignore[arg-type]
    )
    assert found.surface.depth is not None
    assert_allclose(found.surface.depth, -2, rtol=1e-5)
    assert found.surface.pixel_size == pytest.approx(2 / 400, rel=1e-5)


def test_noise_is_told_by_the_standard_error() -> None:
    noisy = GREY + RANDOM.normal(0, 0.01, GREY.shape)
    found = photometric_stereo(noisy, LAMPS, MASK, saturation=np.inf)
    lit = MASK & (SHADING > 0.05).all(axis=0)
    error = np.degrees(np.arccos(np.clip((found.surface.normals * NORMALS).sum(axis=2), -1, 1)))[lit]
    told = found.confidence[lit]
    assert np.sqrt((error**2).mean()) == pytest.approx(np.sqrt(2) * np.sqrt((told**2).mean()), rel=0.35)
    assert (found.confidence[~MASK] == 0).all()


def test_three_photographs_leave_no_doubt_to_measure() -> None:
    lit = MASK & (SHADING[:3] > 0).all(axis=0)
    found = photometric_stereo(GREY[:3], LAMPS[:3], lit)
    assert degrees(np.where(lit[..., None], found.surface.normals, NORMALS)).max() < 0.1
    assert np.isinf(found.confidence[lit]).all() and np.isinf(found.gap)


def test_it_tells_what_it_does() -> None:
    told: list[str] = []
    photometric_stereo(GREY, LAMPS, MASK, tell=lambda what, done, of: told.append(what))
    assert list(dict.fromkeys(told)) == ["normals", "singular values", "depth"]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"images": [np.ones((3, 4)), np.ones((3, 5)), np.ones((3, 4))]}, r"all of one shape, got \(3, 4\).*image 1"),
        ({"images": GREY[0]}, r"expected an array of shape \(n, h, w\)"),
        ({"images": GREY[:2], "lights": LAMPS[:2]}, "expected at least 3, as many as linear3 has unknowns"),
        ({"lights": LAMPS[:5]}, r"expected one direction an image, shape \(12, 3\), got \(5, 3\)"),
        ({"lights": 2 * LAMPS}, "expected unit directions .*, got one of length 2 for image 0"),
        ({"lights": LAMPS * (np.arange(12) != 7)[:, None]}, "expected unit directions .*, got zero for image 7"),
        ({"lights": np.full((12, 3), np.nan)}, "lights: expected finite numbers"),
        ({"mask": np.zeros((SIZE, SIZE), bool)}, "expected at least one pixel in the mask"),
        ({"mask": np.ones((3, 3), bool)}, "mask: expected a boolean mask of shape"),
        ({"images": GREY * np.where(MASK, np.nan, 1)}, "expected finite intensities in the mask"),
        ({"intensities": np.ones(3)}, r"intensities: expected shape \(12,\) or \(12, 3\)"),
        ({"intensities": np.zeros(12)}, "intensities: expected numbers above 0"),
        ({"saturation": 0.0}, "saturation: expected a number above 0"),
        ({"saturation": True}, "saturation: expected a number above 0"),
        ({"integration": "best"}, "integration: expected one of poisson"),
        ({"method": "best"}, "method: expected one of robust"),
        ({"model": "best"}, "model: expected one of auto"),
        ({"lights": None, "images": GREY[:2]}, "expected at least 3"),
        ({"lights": None, "images": GREY[:8], "model": "harmonic9"}, "expected at least 9, as many as harmonic9"),
    ],
)
def test_refuses(changed: dict[str, object], message: str) -> None:
    usual: dict[str, object] = {"images": GREY, "lights": LAMPS, "mask": MASK}
    with pytest.raises(HarmonicFaceError, match=message):
        photometric_stereo(**{**usual, **changed})  # type: ignore[arg-type]
