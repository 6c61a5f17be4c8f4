"""What hides a face in a benchmark: how much of it, where, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.bench.occlusion import behind_block, behind_glasses, natural_texture
from harmonicface.errors import HarmonicFaceError

PHOTO = np.random.default_rng(0).uniform(0.2, 0.8, (96, 84)).astype(np.float32)
EYES = (0.24, 0.21, 0.78)


@pytest.mark.parametrize("fill", ["texture", "grey"])
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_a_block_hides_its_share(share: float, fill: str) -> None:
    hidden = behind_block(PHOTO, share, 3, fill)
    changed = hidden != PHOTO
    assert changed.mean() == pytest.approx(share, abs=0.012)
    rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
    assert changed[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].mean() > 0.99
    assert hidden.dtype == np.float32 and hidden.min() >= 0
    assert hidden[changed].max() <= np.percentile(PHOTO, 95) * 1.0001


def test_nothing_and_everything_are_hidden() -> None:
    assert np.array_equal(behind_block(PHOTO, 0, 0), PHOTO)
    assert len(np.unique(behind_block(PHOTO, 1, 0, "grey"))) == 1


def test_the_seed_decides_the_place() -> None:
    assert np.array_equal(behind_block(PHOTO, 0.2, 5), behind_block(PHOTO, 0.2, 5))
    places = {tuple(np.argwhere(behind_block(PHOTO, 0.2, seed) != PHOTO)[0]) for seed in range(20)}
    assert len(places) > 15


def test_textures_fall_with_the_frequency() -> None:
    texture = natural_texture((128, 128), np.random.default_rng(0))
    assert texture.min() == 0 and texture.max() == 1
    power = np.abs(np.fft.rfft2(texture)) ** 2
    frequency = np.hypot(np.fft.fftfreq(128)[:, None], np.fft.rfftfreq(128)[None])
    low, high = (power[(frequency > f) & (frequency < 1.5 * f)].mean() for f in (0.05, 0.2))
    assert low / high == pytest.approx(16, rel=0.3)


def test_glasses_hide_what_is_about_the_eyes() -> None:
    clear, dark = (behind_glasses(PHOTO, EYES, dark) for dark in (False, True))
    assert 0.03 < (clear != PHOTO).mean() < 0.12 < (dark != PHOTO).mean() < 0.2
    assert np.array_equal(clear[50:], PHOTO[50:]) and np.array_equal(dark[50:], PHOTO[50:])
    eye = np.s_[24:26, 14:17]
    assert np.array_equal(clear[eye], PHOTO[eye])
    assert np.allclose(dark[eye], 0.12 * PHOTO[eye])
    assert clear.max() > PHOTO.max()  # the lamp on the lenses


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.ones(4), 0.1, 0), r"photo: expected shape \(h, w\)"),
        ((PHOTO, 1.5, 0), "share: expected a number from 0 to 1"),
        ((PHOTO, 0.1, 0, "hair"), "fill: expected one of texture, grey, got 'hair'"),
        ((PHOTO, 0.1, -1), "seed: expected an integer of at least 0"),
    ],
)
def test_bad_blocks(arguments: tuple, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        behind_block(*arguments)


def test_bad_glasses() -> None:
    with pytest.raises(HarmonicFaceError, match=r"photo: expected shape \(h, w\)"):
        behind_glasses(np.ones(3), EYES)  # type: ignore[arg-type]
    with pytest.raises(HarmonicFaceError, match="eyes: expected a number from 0 to 1, got 2"):
        behind_glasses(PHOTO, (2, 0.2, 0.8))
