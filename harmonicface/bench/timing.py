"""Times that carry the name of what was called: a row cannot name one function and time another.

The name is made from the function itself. Where the function is called by another one (a lambda, a helper of the
benchmark), the first call is watched, and it is an error if the function that the row names is not among those called;
so is the last one of a few that are quick, as remembered answers are.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np

from harmonicface.bench.measure import Record
from harmonicface.bench.watching import Function, Watch, inner_of
from harmonicface.errors import HarmonicFaceError

Result = TypeVar("Result")
QUICK = 0.1  # seconds: what takes longer than this is no remembered answer


@dataclass(frozen=True)
class Timing:
    """How long a call takes, and of what.

    Parameters
    ----------
    name
        What was called; "" where it is not said.
    seconds
        Wall time.
    versions
        Of the packages that were called.
    """

    name: str
    seconds: float
    versions: dict[str, str] = field(default_factory=dict)

    def times(self, factor: float) -> Timing:
        """Return the time of so many times as much, of the same: of one of many, or of more than was timed.

        Examples
        --------
        >>> Timing("numpy.dot", 3.0).times(0.5)
        Timing(name='numpy.dot', seconds=1.5, versions={})
        """
        return replace(self, seconds=self.seconds * factor)


UNTIMED = Timing("", 0.0)


class Call(Generic[Result]):
    """A call to be timed, under the name of the functions that it calls.

    Parameters
    ----------
    run
        What is timed, called without arguments.
    named
        Functions that it calls, and that stand for it; by default `run` itself, or the function that it is a
        `functools.partial` of; a lambda that does not say what it calls has no name.
    about
        What else a reader has to know of the call, as "on all pixels".

    Examples
    --------
    >>> Call(partial(np.dot, np.eye(2), np.ones(2)), about="of two numbers").name
    'numpy.dot, of two numbers'
    """

    def __init__(self, run: Callable[[], Result], *named: Function, about: str = "") -> None:
        inner = inner_of(run)
        if not named and getattr(inner, "__name__", "") != "<lambda>":
            named = (inner,)
        self.run, self._watch = run, Watch(*named, about=about)

    @property
    def name(self) -> str:
        """What is called, in words."""
        return self._watch.name

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the packages that are called."""
        return self._watch.versions

    def first(self) -> Result:
        """Call, and see that what is named is called.

        Raises
        ------
        HarmonicFaceError
            It is not.
        """
        return self._watch.first(self.run)

    def timing(self, seconds: float) -> Timing:
        """Return so many seconds under this name."""
        return Timing(self.name, seconds, self.versions)


class Stopwatch:
    """Times of one thing that is done again and again with different arguments; its first call is watched.

    Parameters
    ----------
    named, about
        As for `Call`; without `named` the times have no name.

    Examples
    --------
    >>> watch = Stopwatch(np.linalg.qr)
    >>> factors = [watch.run(lambda size=size: np.linalg.qr(np.eye(size))) for size in (2, 3)]
    >>> watch.timing().name, len(watch.seconds)
    ('numpy.linalg.qr', 2)
    """

    def __init__(self, *named: Function, about: str = "") -> None:
        self._watch = Watch(*named, about=about)
        self.seconds: list[float] = []

    def run(self, call: Callable[[], Result]) -> Result:
        """Call, and keep the time."""
        run = partial(self._watch.first, call) if not self.seconds else call
        start = time.perf_counter()
        result = run()
        self.seconds.append(time.perf_counter() - start)
        return result

    def timing(self, of: Callable[[Sequence[float]], Any] = np.median) -> Timing:
        """Return the median, or what else is wanted of all times."""
        return Timing(self._watch.name, float(of(self.seconds)), self._watch.versions)


def best(run: Call[Any] | Callable[[], object], repeats: int = 7) -> Timing:
    """Return the shortest of several timed calls, after one that is watched and not timed; quick ones before one too.

    What is named may be called once and its answer be remembered: then the later calls are quick, and do not call it.
    """
    call = _as_call(run)
    call.first()
    shortest = min(_seconds(call.run) for _ in range(repeats))
    if shortest < QUICK:
        call.first()
    return call.timing(shortest)


def once(run: Call[Result] | Callable[[], Result]) -> tuple[Timing, Result]:
    """Return the time of one call and its result."""
    call = _as_call(run)
    start = time.perf_counter()
    result = call.first()
    return call.timing(time.perf_counter() - start), result


def in_turn(
    ours: Call[Any] | Callable[[], object], peer: Call[Any], rounds: int = 3, repeats: int = 3
) -> tuple[Timing, Timing]:
    """Return the best times of both, taken in turns, so that what else the machine does falls on both.

    Several calls of one before the other has its turn: OpenMP's threads spin for a while after their work.
    """
    calls = _as_call(ours), _as_call(peer)
    times = [[best(call, repeats).seconds for call in calls] for _ in range(rounds)]
    first, second = np.min(times, axis=0)
    return calls[0].timing(float(first)), calls[1].timing(float(second))


def record(
    name: str,
    size: str,
    ours: Timing,
    peer: Timing | None = None,
    *,
    error: float | None = None,
    unit: str = "",
    peer_error: float | None = None,
    bytes: int | None = None,
    seed: int | str | None = None,
    question: str = "",
    note: str = "",
) -> Record:
    """Return the record of our time and a peer's; see `Record` for the rest.

    Raises
    ------
    HarmonicFaceError
        A peer of which nobody knows what it calls.

    Examples
    --------
    >>> ours = best(lambda: sum([1.0, 2.0]))
    >>> peer = best(Call(np.ones(2).sum))
    >>> record("add two numbers", "two", ours, peer, error=0.0).peer
    'numpy.ndarray.sum'
    """
    if peer is not None and not peer.name:
        raise HarmonicFaceError(f"{name}: expected a peer that tells which function it calls, got one without a name")
    usual = Record(name, size, ours.seconds).versions
    return Record(
        name=name,
        size=size,
        seconds=ours.seconds,
        error=error,
        bytes=bytes,
        peer=None if peer is None else peer.name,
        peer_seconds=None if peer is None else peer.seconds,
        note=note,
        unit=unit,
        peer_error=peer_error,
        seed=seed,
        question=question,
        call=ours.name,
        versions={**usual, **ours.versions, **({} if peer is None else peer.versions)},
    )


def _as_call(run: Call[Result] | Callable[[], Result]) -> Call[Result]:
    return run if isinstance(run, Call) else Call(run)


def _seconds(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start
