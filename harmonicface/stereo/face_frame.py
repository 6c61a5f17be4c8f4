"""The frame in which scaled normals look like the mean face: what photographs of a face leave open, it tells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.mean_face import mean_face_normals, place_mean_face

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

FACTORS = 4  # that place the mean face
SAMPLE = 4000  # pixels
DARKEST = 0.2  # of the median albedo: hair and nostrils tell nothing
SCALE = 0.15  # of the Cauchy loss, about 9 degrees: how far people are from the mean


@dataclass(frozen=True, eq=False)
class MeanFace:
    """The mean face where it lies in photographs.

    Parameters
    ----------
    normals
        (p, 3) its unit normals at the masked pixels.
    known
        (p,) booleans, where it covers them.
    """

    normals: Doubles
    known: Mask

    def angle(self, scaled: Doubles) -> float:
        """Return the mean angle to scaled normals in degrees."""
        return float(np.degrees(np.arccos(np.clip(self._cosines(scaled), -1, 1))).mean())

    def frame(self, scaled: Doubles) -> Doubles:
        r"""Return the (3, 3) matrix that makes scaled normals most like the mean face's; it faces the camera with them.

        Either the normals s of the photographs differ from the true ones, or the mean face's m do: A that minimizes
        :math:`\sum \rho(|A s / |A s| - m|)` is too flat and B of
        :math:`\sum \rho(|s / |s| - B^{-1} m / |B^{-1} m||)` too deep, as in regression with errors in both variables.
        The mean of A and B is taken, both at determinant 1. The mean face is symmetric, so the frame is too.

        Parameters
        ----------
        scaled
            (p, 3) in any frame.
        """
        units, target = self._sample(scaled)
        start = np.linalg.lstsq(units, target, rcond=None)[0].T
        if abs(np.linalg.det(start)) < 1e-9 * np.linalg.norm(start) ** 3:
            raise HarmonicFaceError("images: expected a face, got normals that lie in a plane")
        turned = _units(units @ start.T)
        flat = least_squares(_misses, np.eye(3).ravel(), args=(turned, target), loss="cauchy", f_scale=SCALE)
        deep = least_squares(_misses_back, np.eye(3).ravel(), args=(turned, target), loss="cauchy", f_scale=SCALE)
        mean = (_unimodular(flat.x) + _unimodular(deep.x)) / 2
        return np.asarray(mean @ start)

    def _sample(self, scaled: Doubles) -> tuple[Doubles, Doubles]:
        """Return unit vectors of photographs and of the mean face, at pixels that tell something."""
        lengths = np.linalg.norm(scaled, axis=1)
        good = np.flatnonzero(self.known & (lengths > DARKEST * np.median(lengths)))
        if len(good) > SAMPLE:
            good = good[np.linspace(0, len(good) - 1, SAMPLE).astype(int)]
        return _units(scaled[good]), self.normals[good]

    def _cosines(self, scaled: Doubles) -> Doubles:
        units, target = self._sample(scaled)
        return np.asarray(np.einsum("pk,pk->p", units, target))


def find_mean_face(observations: Floats, mask: Mask) -> MeanFace:
    """Find the mean face in photographs, each divided by its lamp's brightness.

    Parameters
    ----------
    observations
        (n, p) intensities.
    mask
        (h, w) booleans.

    Raises
    ------
    HarmonicFaceError
        Fewer than four photographs, nothing that resembles a face.
    """
    if len(observations) < FACTORS:
        raise HarmonicFaceError(
            f"images: expected at least {FACTORS} to find a face in them whatever the light, got {len(observations)}"
        )
    exact = observations.astype(np.float64)
    values, vectors = np.linalg.eigh(exact @ exact.T)
    right = (vectors[:, -FACTORS:] / np.sqrt(np.maximum(values[-FACTORS:], 1e-12 * values[-1]))).T @ exact
    return MeanFace(*mean_face_normals(mask, place_mean_face(right, exact.mean(axis=0), mask)))


def _misses(entries: Doubles, units: Doubles, target: Doubles) -> Doubles:
    return np.asarray((_units(units @ entries.reshape(3, 3).T) - target).ravel())


def _misses_back(entries: Doubles, units: Doubles, target: Doubles) -> Doubles:
    seen = np.asarray(np.linalg.solve(entries.reshape(3, 3), target.T).T, np.float64)
    return np.asarray((_units(seen) - units).ravel())


def _unimodular(entries: Doubles) -> Doubles:
    matrix = entries.reshape(3, 3)
    return np.asarray(matrix / np.cbrt(np.linalg.det(matrix)))


def _units(vectors: Doubles) -> Doubles:
    return np.asarray(vectors / (np.linalg.norm(vectors, axis=1)[:, None] + 1e-300))
