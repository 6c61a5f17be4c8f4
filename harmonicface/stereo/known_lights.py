"""Known lights, block by block: which solver answers, and the standard error of each normal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.calibrated import HIGHEST_NOISE_GAIN, calibrated_stereo
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.least_squares import scaled_normals
from harmonicface.stereo.robust import robust_normals

FEWEST = 3  # distant lamps


def solve(observations: Floats, lights: Floats, method: str, saturation: float) -> Pixels:
    """Solve (n, p) observations under distant lamps by the method asked for."""
    if method == "least_squares":
        return plain(observations, lights, saturation)
    if method == "matte":
        return matte(observations, lights, saturation)
    return robust_normals(observations, lights, saturation)


def plain(observations: Floats, lights: Floats, saturation: float) -> Pixels:
    """Solve (n, p) observations by least squares over all photographs in which a pixel is not saturated (Woodham)."""
    exact = observations.astype(np.float64)
    weights = exact < saturation
    scaled, gain = scaled_normals(exact, lights, weights)
    rest = (exact - lights @ scaled.T) * weights
    used = weights.sum(axis=0)
    residual = np.sqrt(np.einsum("np,np->p", rest, rest) / np.maximum(used, 1))
    confidence = standard_error(scaled, lights, residual, used)
    confidence[gain > HIGHEST_NOISE_GAIN] = np.inf
    return Pixels(scaled, residual, confidence, used)


def matte(observations: Floats, lights: Floats, saturation: float) -> Pixels:
    """Solve (n, p) observations by least squares over the photographs in which a pixel is lit (`calibrated_stereo`)."""
    found = calibrated_stereo(observations[:, None, :], lights, saturation=saturation)
    scaled = (found.surface.normals * found.surface.albedo[..., None])[0]
    residual, used = found.residual[0], found.used[0]
    confidence = standard_error(scaled, lights, residual, used)
    confidence[~found.determined[0]] = np.inf
    return Pixels(scaled, residual, confidence, used)


def standard_error(scaled: Floats, lights: Floats, residual: Floats, used: NDArray[np.integer]) -> NDArray[np.float64]:
    r"""Return the standard error of normals in degrees, infinite where nothing is left over to tell the noise by.

    Noise of standard deviation s leaves an error of s gain in albedo times normal, two thirds of its square across
    the normal; s^2 is the sum of squared residuals over what is left of the photographs after three unknowns, and for
    pixels of three photographs the median over the others.

    Parameters
    ----------
    scaled
        (p, 3) albedo times normal.
    lights
        (n, 3) directions times brightness.
    residual
        (p,) root mean square over the photographs that were used.
    used
        (p,) how many were.
    """
    lit = (lights @ scaled.T) > 0
    freedom = used - FEWEST
    noise = np.full(len(used), np.nan)
    some = freedom > 0
    noise[some] = residual[some] * np.sqrt(used[some] / freedom[some])
    noise[~some] = np.median(noise[some]) if some.any() else np.inf
    gain = scaled_normals(np.zeros(lit.shape), lights, lit)[1]
    brightness = np.sqrt(np.einsum("nk,nk->", lights, lights) / len(lights))
    albedo = np.linalg.norm(scaled, axis=1)
    error = np.full(len(used), np.inf)
    known = (albedo > 0) & np.isfinite(gain) & np.isfinite(noise)
    error[known] = noise[known] * gain[known] / brightness * np.sqrt(2 / 3) / albedo[known]
    error[known] = np.degrees(np.arctan(error[known]))
    return error
