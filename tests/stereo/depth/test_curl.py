"""True normals have no curl; in another frame they have."""

import numpy as np
from scipy.spatial.transform import Rotation

from harmonicface.stereo.depth.curl import curl_terms
from tests.stereo.lamp_scenes import bumpy_ball

NORMALS, MASK = bumpy_ball()


def test_true_normals_have_hardly_any_curl():
    terms = curl_terms(NORMALS, MASK)
    turned = curl_terms(NORMALS @ Rotation.from_euler("x", 40, degrees=True).as_matrix().T, MASK)
    curl, other = (np.median(np.abs(one[:, 0] + one[:, 4])) for one in (terms, turned))
    assert curl < 0.1 * other
