"""Rates with their uncertainty: a share of trials, and the interval that holds the true one."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.special import betaincinv, ndtri

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

METHODS = "exact", "wilson"


@dataclass(frozen=True)
class Rate:
    """So many events in so many trials.

    Parameters
    ----------
    events, trials
        Counts.
    value
        Their ratio, 0 to 1.
    low, high
        The confidence interval of the true rate, which assumes that trials do not depend on each other. Photographs
        of one person do: with few people the truth may lie farther away.
    """

    events: int
    trials: int
    value: float
    low: float
    high: float

    def __str__(self) -> str:
        """Spell in per cent, as "1.2 % (0.4 to 3.1)"."""
        return f"{100 * self.value:.3g} % ({100 * self.low:.3g} to {100 * self.high:.3g})"


def rate(events: int, trials: int, confidence: float = 0.95, method: str = "exact") -> Rate:
    r"""Return a rate with a confidence interval.

    "exact" is Clopper & Pearson's interval (1934), which holds the true rate at least as often as it says: its ends
    are where so few or so many events have the probability :math:`(1 - confidence) / 2`. "wilson" (1927) solves
    :math:`(p - \hat p)^2 = z^2 p (1 - p) / n` and is shorter; it says so often on average.

    Parameters
    ----------
    events
        From 0 to trials.
    trials
        At least 1.
    confidence
        From 0 to 1.
    method
        "exact" or "wilson".

    Raises
    ------
    HarmonicFaceError
        No trials, more events than trials, another method, a confidence that is no fraction.

    Examples
    --------
    >>> str(rate(0, 299))  # the rule of three, on one side of a two-sided interval
    '0 % (0 to 1.23)'
    >>> print(rate(5, 100, method="wilson"))
    5 % (2.15 to 11.2)
    """
    if method not in METHODS:
        raise HarmonicFaceError(f"method: expected one of {', '.join(METHODS)}, got {method!r}")
    count = _validate.at_least(trials, 1, "trials")
    happened = _validate.at_least(events, 0, "events")
    if happened > count:
        raise HarmonicFaceError(f"events: expected at most as many as trials, {count}, got {happened}")
    level = _validate.fraction(confidence, "confidence")
    low, high = (_exact if method == "exact" else _wilson)(happened, count, level)
    return Rate(happened, count, happened / count, low, high)


def _exact(events: int, trials: int, confidence: float) -> tuple[float, float]:
    """Invert the binomial distribution, whose tails are incomplete beta functions."""
    tail = (1 - confidence) / 2
    low = betaincinv(events, trials - events + 1, tail) if events else 0.0
    high = betaincinv(events + 1, trials - events, 1 - tail) if events < trials else 1.0
    return float(low), float(high)


def _wilson(events: int, trials: int, confidence: float) -> tuple[float, float]:
    """Solve the quadratic equation of the normal approximation."""
    z = float(ndtri((1 + confidence) / 2))
    middle, spread = events + z * z / 2, z * (events * (trials - events) / trials + z * z / 4) ** 0.5
    low, high = (middle - spread) / (trials + z * z), (middle + spread) / (trials + z * z)
    return (low if events else 0.0), (high if events < trials else 1.0)
