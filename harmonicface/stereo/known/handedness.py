"""Handedness: lights whose axes are not x right, y up give normals that are those of no surface, and so are found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.depth.curl import SCALE, curl_terms

Mask = NDArray[np.bool_]

WINDOW = 300  # pixels a side about the middle of the mask, which are asked
FEWEST = 100  # of them with four neighbours
# By how much less likely the curls are, in nats a pixel of a heavy-tailed law: faces of Yale B and measured objects
# lose 0.4 to 1.5 to their mirror image, a plane and noise 0.
CLEARLY = 0.3
# With the first two rows of the cofactor matrix of other axes, see `curl_terms`.
OTHERS = {
    "left and right (or up and down)": np.array([1.0, 0, 0, 0, -1, 0]),
    "x and y": np.array([0.0, 1, 0, 1, 0, 0]),
    "x and y, and one of their signs,": np.array([0.0, 1, 0, -1, 0, 0]),
}


def check_axes(scaled: Floats, mask: Mask) -> None:
    r"""Refuse normals that are those of a surface only when the axes of the lights are exchanged.

    Lights in other axes explain photographs as well, with normals in those axes; but slopes p and q in them have the
    curl :math:`\partial_y p + \partial_x q` (or with other signs) instead of none. Both signs of x and y together
    make the mirror image in depth, which has no curl either.

    Parameters
    ----------
    scaled
        (p, 3) albedo times normal of the masked pixels.
    mask
        (h, w) booleans.

    Raises
    ------
    HarmonicFaceError
        The curls that other axes leave are clearly more likely, by Cauchy's law.

    Examples
    --------
    >>> y, x = np.mgrid[0.5:-0.5:20j, -0.5:0.5:20j]
    >>> saddle = np.stack([-2 * x * y, -(x**2), np.ones_like(x)], axis=2)  # of z = x^2 y
    >>> check_axes(saddle.reshape(-1, 3), np.ones((20, 20), bool))
    """
    rows, columns = (int(np.median(where)) for where in np.nonzero(mask))
    near = np.zeros_like(mask)
    half = WINDOW // 2
    window = slice(max(rows - half, 0), rows + half), slice(max(columns - half, 0), columns + half)
    near[window] = mask[window]
    terms = curl_terms(np.asarray(scaled[near[mask]], np.float64), near[window])
    if len(terms) < FEWEST:
        return
    scale = SCALE * float(np.median(np.linalg.norm(terms, axis=1)))
    if scale == 0:
        return

    def unlikely(curl: Floats) -> float:
        return float(np.log1p(np.square(curl / scale)).mean())

    own = unlikely(terms[:, 0] + terms[:, 4])
    left = {name: unlikely(terms @ form) for name, form in OTHERS.items()}
    best = min(left, key=lambda name: left[name])
    if own - left[best] > CLEARLY:
        raise HarmonicFaceError(
            "lights: expected directions x right, y up, z toward the camera, got some under which the normals are"
            f" those of a surface only once {best} are exchanged"
        )
