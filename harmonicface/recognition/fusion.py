"""Fusion: several measures of resemblance, each standardized by how strangers do, summed to one score."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

PRIOR_PEOPLE = 5  # strangers that the usual deviation counts for


def standardized(values: ArrayLike, usual: float, prior: float = PRIOR_PEOPLE) -> NDArray[np.float64]:
    r"""Return by how many deviations each person resembles a photograph more than strangers do.

    Everybody but the best is a stranger: m of them, of mean \bar x. Few of them tell little of how much strangers
    differ, so the deviation is pooled with the usual one, which counts for `prior` people,

    .. math:: s^2 = \frac{\nu s_0^2 + \sum (x - \bar x)^2}{\nu + m - 1}, \qquad z = \frac{x - \bar x}{s \sqrt{1 + 1/m}}

    Parameters
    ----------
    values
        (n,) larger for more alike.
    usual
        The deviation s_0 of strangers' values, above 0.
    prior
        \nu, above 0.

    Returns
    -------
    array
        (n,); 0 for somebody alone, who has nobody to be compared with.

    Raises
    ------
    HarmonicFaceError
        Not an (n,) array with something in it, NaN, a deviation or weight that is not above 0.

    Examples
    --------
    >>> standardized([0.21, 0.19, 0.48, 0.20], usual=0.02).round(1)
    array([ 0.5, -0.5, 13.7, -0. ])
    """
    array = _validate.finite(values, "values").astype(np.float64)
    if array.ndim != 1 or len(array) == 0:
        raise HarmonicFaceError(f"values: expected shape (n,), got {_validate.describe(array)}")
    deviation, weight = _validate.positive(usual, "usual"), _validate.positive(prior, "prior")
    strangers = np.delete(array, array.argmax())
    if len(strangers) == 0:
        return np.zeros(1)
    mean = strangers.mean()
    pooled = weight * deviation**2 + np.square(strangers - mean).sum()
    spread = np.sqrt(pooled / (weight + len(strangers) - 1) * (1 + 1 / len(strangers)))
    return np.asarray((array - mean) / spread)


def fused(measures: Sequence[Floats]) -> NDArray[np.float64]:
    r"""Return one score of several standardized measures: their sum over the root of their number (Stouffer 1949).

    Parameters
    ----------
    measures
        At least one, each (n,).

    Raises
    ------
    HarmonicFaceError
        None.

    Examples
    --------
    >>> fused([np.array([3.0, 0.0]), np.array([1.0, 0.0])]).round(3)
    array([2.828, 0.   ])
    """
    if len(measures) == 0:
        raise HarmonicFaceError("measures: expected at least one, got none")
    return np.asarray(np.sum(measures, axis=0) / np.sqrt(len(measures)))
