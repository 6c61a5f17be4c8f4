"""What an ambiguity's parameters mean for normals: closed forms of flattening and tilting."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from harmonicface.stereo.lamps.relief_doubt import stated_doubt

NORMALS = np.array([[0.0, 0.0, 2.0], [0.6, 0.0, 0.8]])


def test_without_parameters_there_is_no_doubt() -> None:
    assert_allclose(stated_doubt(NORMALS, {"outward_slant": 0.4}), 0)


def test_relief_turns_slopes_and_leaves_what_faces_the_camera() -> None:
    doubt = stated_doubt(NORMALS, {"mu_std": 0.0, "nu_std": 0.0, "lambda_std": 0.25})
    change = np.degrees(np.arctan(0.75 * 1.25) - np.arctan(0.75))
    assert_allclose(doubt, [0, change], rtol=0.05)


def test_tilt_turns_what_faces_the_camera() -> None:
    doubt = stated_doubt(NORMALS, {"mu_std": 0.1, "nu_std": 0.1, "lambda_std": 0.0})
    assert_allclose(doubt[0], np.sqrt(2) * np.degrees(np.arctan(0.1)), rtol=1e-6)
