"""Three measured environments by the nine coefficients that were published of them."""

from __future__ import annotations

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.light import HarmonicLight

# Red, green, blue of L_00; L_1-1, L_10, L_11; L_2-2, L_2-1, L_20, L_21, L_22.
TABLE = {
    "grace": [
        [0.79, 0.44, 0.54],
        [0.39, 0.35, 0.60],
        [-0.34, -0.18, -0.27],
        [-0.29, -0.06, 0.01],
        [-0.11, -0.05, -0.12],
        [-0.26, -0.22, -0.47],
        [-0.16, -0.09, -0.15],
        [0.56, 0.21, 0.14],
        [0.21, -0.05, -0.30],
    ],
    "eucalyptus": [
        [0.38, 0.43, 0.45],
        [0.29, 0.36, 0.41],
        [0.04, 0.03, 0.01],
        [-0.10, -0.10, -0.09],
        [-0.06, -0.06, -0.04],
        [0.01, -0.01, -0.05],
        [-0.09, -0.13, -0.15],
        [-0.06, -0.05, -0.04],
        [0.02, 0.00, -0.05],
    ],
    "st_peters": [
        [0.36, 0.26, 0.23],
        [0.18, 0.14, 0.13],
        [-0.02, -0.01, 0.00],
        [0.03, 0.02, 0.01],
        [0.02, 0.01, 0.00],
        [-0.05, -0.03, -0.01],
        [-0.09, -0.08, -0.07],
        [0.01, 0.00, 0.00],
        [-0.08, -0.06, 0.00],
    ],
}


def published(name: str) -> HarmonicLight:
    """Return one of three light probes by its nine published coefficients, in colour.

    Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, figure 2; the probes
    are Debevec's. The axes are the package's (x right, y up, z toward the camera), the scale is that of the table,
    where the irradiance is about 1, and each number is rounded to 0.01.

    Parameters
    ----------
    name
        "grace" (Grace Cathedral), "eucalyptus" (a grove under the sky) or "st_peters" (St. Peter's Basilica).

    Raises
    ------
    HarmonicFaceError
        Another name.

    Examples
    --------
    >>> published("grace").irradiance([[0.0, 1.0, 0.0]]).round(3)
    array([[1.049, 0.792, 1.258]])
    """
    if not isinstance(name, str) or name not in TABLE:
        raise HarmonicFaceError(f"name: expected one of {', '.join(map(repr, TABLE))}, got {name!r}")
    return HarmonicLight(np.array(TABLE[name]))
