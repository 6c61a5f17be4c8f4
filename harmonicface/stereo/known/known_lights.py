"""Known lights, block by block: which solver answers, and the standard error of each normal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.known.calibrated import HIGHEST_NOISE_GAIN, calibrated_stereo
from harmonicface.stereo.known.least_squares import noise_of, scaled_normals
from harmonicface.stereo.known.robust import robust_normals

NARROW = 0.1  # of the largest singular value: lamps within 12 degrees, or within 6 of a plane


def solve(observations: Floats, lights: Floats, method: str, saturation: float) -> Pixels:
    """Solve (n, p) observations under distant lamps by the method asked for; narrow lamps tell no gloss from shape."""
    if method == "least_squares":
        return plain(observations, lights, saturation)
    if method == "matte":
        return matte(observations, lights, saturation)
    found = robust_normals(observations, lights, saturation)
    return found if spread_of(lights) >= NARROW else _narrow(found, matte(observations, lights, saturation))


def spread_of(lights: Floats) -> float:
    """Return the smallest singular value of (n, 3) lights' directions over their largest.

    Examples
    --------
    >>> spread_of(np.eye(3)), spread_of(np.array([[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8]]))
    (1.0, 0.0)
    """
    values = np.linalg.svd(lights / np.linalg.norm(lights, axis=1, keepdims=True), compute_uv=False)
    return float(values[-1] / values[0])


def _narrow(glossy: Pixels, plain: Pixels) -> Pixels:
    """Return matte normals, unsure by all that they differ from glossy ones: narrow lamps do not tell which it is."""
    one, other = (np.asarray(found.scaled, np.float64) for found in (glossy, plain))
    lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    cosines = np.einsum("pk,pk->p", one, other) / np.where(lengths > 0, lengths, 1.0)
    angle = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    return replace(plain, confidence=np.hypot(np.maximum(plain.confidence, glossy.confidence), angle))


def check_span(lights: Floats) -> None:
    """Refuse lamps near one plane or one another, under which least squares multiplies noise too much to be of use.

    Raises
    ------
    HarmonicFaceError
        (n, 3) lights of a gain above 30 (`scaled_normals`).
    """
    directions = lights / np.linalg.norm(lights, axis=1, keepdims=True)
    gain = float(scaled_normals(np.zeros((len(lights), 1)), directions)[1][0])
    if gain > HIGHEST_NOISE_GAIN:
        raise HarmonicFaceError(
            f"lights: expected directions that span space, got {len(lights)} near one plane or one another"
            f" (they multiply noise by {gain:.3g}, at most {HIGHEST_NOISE_GAIN:g} is of use)"
        )


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
    the normal (`noise_of`).

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
    noise = noise_of(residual, used)
    gain = scaled_normals(np.zeros(lit.shape), lights, lit)[1]
    brightness = np.sqrt(np.einsum("nk,nk->", lights, lights) / len(lights))
    albedo = np.linalg.norm(scaled, axis=1)
    error = np.full(len(used), np.inf)
    known = (albedo > 0) & np.isfinite(gain) & np.isfinite(noise)
    error[known] = noise[known] * gain[known] / brightness * np.sqrt(2 / 3) / albedo[known]
    error[known] = np.degrees(np.arctan(error[known]))
    return error
