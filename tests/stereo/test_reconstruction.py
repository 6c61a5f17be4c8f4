from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import shift

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.reconstruction import reconstruct

TILTS = [(0, 0), (0.17, 0), (-0.17, 0), (0, 0.17), (0, -0.17), (0.17, 0.17), (-0.17, -0.17)]
LIGHTS = np.array([(x, y, 1.0) for x, y in TILTS])
LIGHTS /= np.linalg.norm(LIGHTS, axis=1, keepdims=True)
PERSON = hf.synthetic_person(0, size=144)
STILL = np.stack([0.9 * hf.render(PERSON, hf.lights.directional(light)) for light in LIGHTS]).clip(0, 1)
MOVED = np.stack([*STILL])  # two of seven
MOVED[0], MOVED[3] = (shift(STILL[index], by, mode="nearest").clip(0, 1) for index, by in ((0, (1, 4)), (3, (-3, 2))))
FACE = np.zeros(PERSON.shape, bool)
FACE[30:114, 36:108] = True


def degrees(found: hf.Surface) -> float:
    """Return the mean angle between normals inside the face."""
    cosines = np.einsum("...i,...i", found.normals, PERSON.normals)[FACE]
    return float(np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean())


def test_a_person_who_did_not_move_has_her_depth_back() -> None:
    found = reconstruct(STILL, LIGHTS, registered=True)
    assert degrees(found) < 1
    assert found.depth is not None and PERSON.depth is not None
    assert found.depth.dtype == np.float32
    assert found.mask.all() and found.pixel_size == 1
    mine, hers = found.depth[FACE], PERSON.depth[FACE] / PERSON.pixel_size
    relief = np.ptp(hers)
    assert np.abs((mine - mine.mean()) - (hers - hers.mean())).mean() < 0.05 * relief


def test_registration_undoes_motion_and_the_majority_stays() -> None:
    assert degrees(reconstruct(MOVED, LIGHTS, registered=True)) > 10
    assert degrees(reconstruct(MOVED, LIGHTS)) < 1.5


def test_it_casts_shadows() -> None:
    found = reconstruct(STILL, LIGHTS, registered=True)
    shadowed, free = (hf.harmonic_images(found, order=0, shadows=shadows)[0] for shadows in (True, False))
    assert (shadowed <= free + 1e-4).all()
    assert shadowed.mean() < 0.99 * free.mean()


def test_a_dark_room_has_a_surface_without_albedo() -> None:
    found = reconstruct(np.zeros((3, 20, 20)), np.eye(3), registered=True)
    assert_array_equal(found.albedo, 0)
    assert_array_equal(found.depth, 0)


@pytest.mark.parametrize(
    ("photographs", "lights", "message"),
    [
        (STILL[:2], LIGHTS[:2], "images: expected at least 3 under different lights, got 2"),
        (STILL, LIGHTS[:4], r"lights: expected one vector an image, shape \(7, 3\)"),
        (STILL[0], LIGHTS, r"photographs: expected shape \(n, h, w\)"),
        (2 * STILL, LIGHTS, "images: expected intensities up to saturation=1"),
        (0 * STILL, LIGHTS, "photographs: expected contrast, got photograph 0"),
    ],
)
def test_bad_input(photographs: np.ndarray, lights: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        reconstruct(photographs, lights)
