"""Seven photographs of a real face, its lamps unknown."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from harmonicface.datasets.photographs import opened_photographs, photograph_files
from harmonicface.stereo.bright_part import bright_part
from harmonicface.stereo.photometric_stereo import photometric_stereo

NOSE = slice(110, 140), slice(75, 110)  # rows and columns at half size


@pytest.mark.data
def test_seven_photographs_under_unknown_lamps_give_that_face(data_dir: Path) -> None:
    with opened_photographs(photograph_files([data_dir / "stereo_face"]), reduce=2) as photographs:
        mask = bright_part(photographs.brightest)
        assert mask is not None and 0.5 < mask.mean() < 0.7
        found = photometric_stereo(photographs.images, None, mask, model="linear3", face=True)
    surface = found.surface
    assert found.ambiguity.name == "bas-relief"  # and it says so
    depth = np.asarray(surface.depth)
    tip = np.unravel_index(np.nanargmax(np.where(mask, depth, np.nan)), mask.shape)
    assert NOSE[0].start <= tip[0] < NOSE[0].stop and NOSE[1].start <= tip[1] < NOSE[1].stop
    normals = surface.normals
    cheeks = (np.s_[60:190, tip[1] - 55 : tip[1] - 15], np.s_[60:190, tip[1] + 16 : tip[1] + 56])
    left, right = (normals[part][mask[part]] for part in cheeks)
    assert left[:, 0].mean() < -0.2 and right[:, 0].mean() > 0.2  # the cheeks fall away to both sides
    tilt = (left[:, 0].mean() + right[:, 0].mean()) / 2  # of a face that looks at the camera: none
    assert abs(tilt) < 2 * found.ambiguity.parameters["mu_std"] < 0.3  # as well as it says
    model = surface.albedo[mask] * np.maximum(normals[mask] @ found.lights.T.astype(np.float32), 0).T
    shown = np.asarray(photographs.images)[:, mask]
    assert np.sqrt(np.mean((model - shown) ** 2)) < 0.1 * np.sqrt(np.mean(shown**2))
