"""Bas-relief transformations: which flattened and tilted surfaces look alike, and which lamps undo it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Doubles = NDArray[np.float64]

SPREAD = 0.03  # of lamps' brightness about the one that they should have: the scale of the loss
STARTS = (-1.5, -0.75, 0.0, 0.75, 1.5)  # logarithms of the stretch


def bas_relief(mu: float, nu: float, stretch: float) -> Doubles:
    r"""Return the (3, 3) matrix that takes scaled normals of a depth z to those of `stretch z + mu x + nu y`.

    .. math:: G = \begin{pmatrix} \lambda & 0 & -\mu \\ 0 & \lambda & -\nu \\ 0 & 0 & 1 \end{pmatrix}

    Normals go as `b -> G b` and lights as `l -> inverse(G)' l`, which leaves the photographs as they are (Belhumeur,
    Kriegman & Yuille, The bas-relief ambiguity, 1999; there in the other direction).

    Examples
    --------
    >>> bas_relief(0.0, 0.0, 0.5) @ [0.6, 0.0, 0.8]
    array([0.3, 0. , 0.8])
    """
    return np.array([[stretch, 0, -mu], [0, stretch, -nu], [0, 0, 1.0]])


def relief_of_equal_lamps(lights: Doubles) -> tuple[Doubles, Doubles]:
    """Return the bas-relief transformation, times a scale, that makes lamps equally bright, and its uncertainty.

    Parameters
    ----------
    lights
        (n, 3) lights, right up to a bas-relief transformation.

    Returns
    -------
    frame
        (3, 3) for scaled normals; the lights then are `lights @ inverse(frame)`, of length 1.
    deviations
        (3,) standard errors of mu, nu and the logarithm of the stretch, from how far the lamps miss.
    """
    size = float(np.median(np.linalg.norm(lights, axis=1)))

    def frame_of(parameters: Doubles) -> Doubles:
        mu, nu, stretch, scale = parameters
        return np.asarray(np.exp(scale) * bas_relief(mu, nu, np.exp(stretch)))

    def misses(parameters: Doubles) -> Doubles:
        return np.asarray(np.log(np.linalg.norm(lights @ np.linalg.inv(frame_of(parameters)), axis=1) + 1e-300))

    fits = [
        least_squares(misses, [0, 0, start, np.log(size)], loss="cauchy", f_scale=SPREAD, max_nfev=200)
        for start in STARTS
    ]
    best = min(fits, key=lambda fit: fit.cost)
    rest = misses(best.x)
    variance = (1.4826 * np.median(np.abs(rest))) ** 2 * len(lights) / max(len(lights) - 4, 1)
    covariance = variance * np.linalg.pinv(best.jac.T @ best.jac)
    return frame_of(best.x), np.sqrt(np.diag(covariance)[:3])


def unit_frame(lights: Doubles) -> Doubles | None:
    """Return the symmetric frame for scaled normals in which lamps have length 1; None where they do not say.

    `l' Q l = 1` for all lamps is linear in the symmetric Q, solved by reweighting with a Cauchy loss (Hayakawa 1994).
    Six lamps at least are needed, not on one cone about an axis.
    """
    x, y, z = lights.T
    rows = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=1)
    if len(lights) < 6 or np.linalg.cond(rows / np.linalg.norm(rows, axis=0)) > 1e4:
        return None
    weights = np.ones(len(lights))
    form: Doubles = np.zeros(6)
    for _ in range(20):
        form = np.asarray(np.linalg.lstsq(rows * weights[:, None], weights, rcond=None)[0], np.float64)
        rest = rows @ form - 1
        scale = 2 * 1.4826 * float(np.median(np.abs(rest))) + 1e-12
        weights = np.asarray(1 / np.sqrt(1 + (rest / scale) ** 2))
    a, b, c, d, e, f = form
    values, vectors = np.linalg.eigh(np.array([[a, d, e], [d, b, f], [e, f, c]]))
    if values[0] <= 1e-4 * values[-1]:
        return None
    return np.asarray((vectors / np.sqrt(values)) @ vectors.T)
