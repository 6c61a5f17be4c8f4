"""Harmonic coefficients of samples at scattered directions, by least squares that says when it cannot know."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count

Floats64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """What least squares found.

    Parameters
    ----------
    coefficients
        ((order + 1)^2,) or ((order + 1)^2, channels).
    condition
        The largest over the smallest singular value of the equations: how many times more a relative error of the
        values may weigh in the coefficients.
    residual
        Root mean square of values minus fit, weighted as the fit; one number a channel.
    """

    coefficients: Floats64
    condition: float
    residual: Floats64


def fit(directions: ArrayLike, values: ArrayLike, order: int, weights: ArrayLike | None = None) -> HarmonicFit:
    r"""Find the harmonic coefficients that explain samples best.

    .. math:: \min_c \sum_i w_i \Big(v_i - \sum_{lm} c_{lm} Y_{lm}(n_i)\Big)^2

    by a QR decomposition, which does not square the condition as the normal equations do.

    Parameters
    ----------
    directions
        (n, 3) unit vectors.
    values
        (n,) or (n, channels).
    order
        The highest degree l, at least 0.
    weights
        (n,) of at least 0, as 1 / variance; equal if not given.

    Returns
    -------
    HarmonicFit
        Coefficients, condition and residual.

    Raises
    ------
    HarmonicFaceError
        Samples that do not determine the coefficients: too few of them, or on too few directions; arrays that do
        not fit each other, negative weights, more than the memory holds.

    Examples
    --------
    >>> axes = np.concatenate([np.eye(3), -np.eye(3)])
    >>> found = fit(axes, 1 + axes[:, 2], order=1)
    >>> found.coefficients.round(4) + 0.0, round(found.condition, 3)
    (array([3.5449, 0.    , 2.0467, 0.    ]), 1.0)
    """
    towards = np.asarray(_validate.unit_normals(directions, "directions"), np.float64)
    sampled = np.asarray(_validate.finite(values, "values"), np.float64)
    if towards.ndim != 2:
        raise HarmonicFaceError(f"directions: expected shape (n, 3), got {towards.shape}")
    if sampled.ndim not in (1, 2) or len(sampled) != len(towards):
        raise HarmonicFaceError(
            f"values: expected {len(towards)} of them, one a direction, got {_validate.describe(sampled)}"
        )
    importance = _weights(weights, len(towards))
    used = int((importance > 0).sum())
    if used < count(order):
        raise HarmonicFaceError(_undetermined(used, order, f"at least {count(order)} are needed"))
    _memory.require(24 * count(order) * len(towards), f"a fit of order {order} to {len(towards)} samples")
    roots = np.sqrt(importance)
    equations = real_harmonics(towards, order).T * roots[:, None]
    columns = sampled.reshape(len(sampled), -1) * roots[:, None]
    orthonormal, triangle = np.linalg.qr(equations)
    left, singular, right = np.linalg.svd(triangle)
    rank = int((singular > singular[0] * len(towards) * np.finfo(np.float64).eps).sum())
    if rank < len(singular):
        raise HarmonicFaceError(_undetermined(used, order, f"their directions determine {rank}"))
    found = right.T @ ((left.T @ (orthonormal.T @ columns)) / singular[:, None])
    residual = np.sqrt(((columns - equations @ found) ** 2).sum(axis=0) / importance.sum())
    channels = sampled.shape[1:]
    return HarmonicFit(
        found.reshape(-1, *channels), float(singular[0] / singular[-1]), np.asarray(residual.reshape(channels))
    )


def _weights(weights: ArrayLike | None, number: int) -> Floats64:
    """Return one weight of at least 0 a sample."""
    if weights is None:
        return np.ones(number)
    given = np.asarray(_validate.finite(weights, "weights"), np.float64)
    if given.shape != (number,) or (given < 0).any():
        least = f", least {given.min():.4g}" if given.size else ""
        raise HarmonicFaceError(
            f"weights: expected {number} numbers of at least 0, got {_validate.describe(given)}{least}"
        )
    return given


def _undetermined(samples: int, order: int, reason: str) -> str:
    """Say that samples are too few for an order."""
    return f"directions: {samples} samples do not determine the {count(order)} harmonics of order {order}, {reason}"
