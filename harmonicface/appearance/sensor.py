"""What a camera adds to a picture: exposure, noise, saturation, eight bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError


def photograph(
    picture: ArrayLike,
    rng: int | np.random.Generator,
    *,
    noise: float = 0.01,
    saturated: float = 0.01,
    bits: int = 8,
) -> Floats:
    """Return the picture as a camera with a linear response would record it.

    The exposure is set so that a share of the lit pixels burns out; then come Gaussian noise, clipping to 0 ... 1
    and rounding to the levels of the converter.

    Parameters
    ----------
    picture
        (h, w) or (h, w, 3) linear, at least 0, not all 0.
    rng
        Where the noise comes from: a generator, or a seed.
    noise
        Standard deviation as a fraction of full scale, finite and at least 0.
    saturated
        Share of the lit pixels above full scale, from 0 up to but not including 1.
    bits
        Bits of the converter, from 1 to 16.

    Returns
    -------
    array
        float32 of the same shape, 0 ... 1.

    Raises
    ------
    HarmonicFaceError
        A picture that is negative, all 0 or not finite; a setting out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> photograph([[0.0, 1.0, 2.0]], np.random.default_rng(0), noise=0.0, saturated=0.0, bits=1)
    array([[0., 0., 1.]], dtype=float32)
    """
    linear = _validate.image(picture, "picture")
    if linear.min() < 0 or linear.max() == 0:
        expected = "a picture of at least 0 with some light in it"
        raise HarmonicFaceError(
            f"picture: expected {expected}, got values from {linear.min():.4g} to {linear.max():.4g}"
        )
    random = _validate.generator(rng, "rng")
    share = _validate.fraction(saturated, "saturated")
    depth = _validate.at_least(bits, 1, "bits")
    if not (np.isfinite(noise) and noise >= 0 and share < 1 and depth <= 16):
        expected = "noise >= 0, 0 <= saturated < 1 and bits from 1 to 16"
        raise HarmonicFaceError(f"camera: expected {expected}, got noise={noise}, saturated={saturated}, bits={bits}")
    full_scale = np.quantile(linear[linear > 0], 1 - share)
    exposed = linear / full_scale + random.normal(0.0, noise, linear.shape)
    levels = 2**depth - 1
    return np.asarray(np.round(np.clip(exposed, 0.0, 1.0) * levels) / levels, dtype=np.float32)
