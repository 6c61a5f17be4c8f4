"""Decisions one against one: error rates of a threshold over scores of the right people and of others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.intervals import Rate, rate

Scores = NDArray[np.float64]
ROUNDING = 1e-12  # 0.29 x 100 is a little less than 29 in floats


@dataclass(frozen=True, eq=False)
class ErrorCurve:
    """Both errors at every threshold that makes a difference, the strictest first: nobody is accepted there.

    Parameters
    ----------
    thresholds
        (t,) descending from infinity through every score that occurs; a score at the threshold is accepted.
    fmr
        (t,) false match rate: share of impostors that are accepted, from 0 up to 1.
    fnmr
        (t,) false non-match rate: share of genuine scores that are refused, from 1 down to 0.
    """

    thresholds: Scores
    fmr: Scores
    fnmr: Scores

    @property
    def tmr(self) -> Scores:
        """True match rate, 1 - FNMR; against the FMR it is the ROC curve, as FNMR against FMR is the DET curve."""
        return 1 - self.fnmr


@dataclass(frozen=True)
class Rates:
    """What a threshold does: the false match and the false non-match rate."""

    threshold: float
    fmr: Rate
    fnmr: Rate


@dataclass(frozen=True)
class EqualErrors:
    """The equal error rate, and the threshold that comes nearest to it."""

    rate: float
    threshold: float


def error_curve(genuine: ArrayLike, impostor: ArrayLike) -> ErrorCurve:
    """Return FMR and FNMR at all thresholds: the ROC and DET curves (ISO/IEC 19795-1).

    Parameters
    ----------
    genuine
        (n,) scores of comparisons with the right person, higher where more alike. Give distances with a minus sign.
    impostor
        (m,) scores of comparisons with others.

    Raises
    ------
    HarmonicFaceError
        No score of a kind, NaN or infinity, another shape.

    Examples
    --------
    >>> curve = error_curve([3, 2], [2, 1])
    >>> curve.thresholds.tolist(), curve.fmr.tolist(), curve.fnmr.tolist()
    ([inf, 3.0, 2.0, 1.0], [0.0, 0.0, 0.5, 1.0], [1.0, 0.5, 0.0, 0.0])
    """
    return curve_of(checked_scores(genuine, "genuine"), checked_scores(impostor, "impostor"))


def rates_at(genuine: ArrayLike, impostor: ArrayLike, threshold: float, confidence: float = 0.95) -> Rates:
    """Return what a threshold does, with Clopper-Pearson intervals; a score at the threshold is accepted.

    Parameters
    ----------
    genuine, impostor
        (n,) and (m,) scores, higher where more alike.
    threshold
        In the unit of the scores.
    confidence
        Of the intervals, 0 to 1.

    Raises
    ------
    HarmonicFaceError
        No score of a kind, NaN or infinity, another shape.

    Examples
    --------
    >>> found = rates_at([3, 2], [2, 1], threshold=2.5)
    >>> found.fmr.value, found.fnmr.value
    (0.0, 0.5)
    """
    accepted = checked_scores(impostor, "impostor") >= threshold
    refused = checked_scores(genuine, "genuine") < threshold
    return Rates(
        float(threshold),
        rate(int(accepted.sum()), accepted.size, confidence),
        rate(int(refused.sum()), refused.size, confidence),
    )


def equal_error_rate(genuine: ArrayLike, impostor: ArrayLike) -> EqualErrors:
    """Return where the DET curve, with straight lines between its points, has equal errors.

    Parameters
    ----------
    genuine, impostor
        (n,) and (m,) scores, higher where more alike.

    Returns
    -------
    EqualErrors
        The rate is 0.5 where scores tell nothing. The threshold is the one whose two errors differ least, the
        stricter of two.

    Raises
    ------
    HarmonicFaceError
        No score of a kind, NaN or infinity, another shape.

    Examples
    --------
    >>> equal_error_rate([4, 3, 2, 1], [0, 0, 0, 1.5])
    EqualErrors(rate=0.25, threshold=1.5)
    """
    curve = error_curve(genuine, impostor)
    difference = curve.fmr - curve.fnmr  # rises from -1 to 1
    after = int((difference >= 0).argmax())
    step = difference[after] - difference[after - 1]
    share = difference[after] / step
    equal = curve.fmr[after] + share * (curve.fmr[after - 1] - curve.fmr[after])
    return EqualErrors(float(equal), float(curve.thresholds[np.abs(difference).argmin()]))


def threshold_at_fmr(impostor: ArrayLike, fmr: float) -> float:
    """Return the lowest threshold that accepts at most a share of impostors.

    Parameters
    ----------
    impostor
        (m,) scores, higher where more alike. With fewer than 1 / fmr of them none may be accepted; what rate that
        makes likely is told by the interval of `rates_at`, not by this number.
    fmr
        0 to 1.

    Returns
    -------
    float
        The smallest number above the first score that must be refused; the least score where all may be accepted.

    Raises
    ------
    HarmonicFaceError
        No score, NaN or infinity, another shape, a rate outside 0 to 1.

    Examples
    --------
    >>> round(threshold_at_fmr([1, 2, 3, 4], fmr=0.25), 9)
    3.0
    """
    scores = np.sort(checked_scores(impostor, "impostor"))[::-1]
    allowed = int(_validate.fraction(fmr, "fmr") * scores.size * (1 + ROUNDING))
    if allowed >= scores.size:
        return float(scores[-1])
    return float(np.nextafter(scores[allowed], np.inf))


def curve_of(genuine: Scores, impostor: Scores) -> ErrorCurve:
    """Return the curve of scores that were checked; minus infinity is refused at every threshold of the curve."""
    both = np.concatenate([genuine, impostor])
    thresholds = np.concatenate([[np.inf], np.unique(both[both > -np.inf])[::-1]])
    return ErrorCurve(
        thresholds,
        (impostor.size - np.searchsorted(np.sort(impostor), thresholds)) / impostor.size,
        np.searchsorted(np.sort(genuine), thresholds) / genuine.size,
    )


def checked_scores(scores: ArrayLike, name: str) -> Scores:
    """Return (n,) finite scores, n of at least 1.

    Raises
    ------
    HarmonicFaceError
        None, another shape, NaN or infinity.
    """
    array = _validate.finite(scores, f"{name} scores")
    if array.ndim != 1:
        raise HarmonicFaceError(f"{name} scores: expected shape (n,), got {_validate.describe(array)}")
    if array.size == 0:
        raise HarmonicFaceError(f"{name} scores: expected at least one, got none")
    return array.astype(np.float64)
