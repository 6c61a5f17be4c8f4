"""Times that carry the name of what was called: a row cannot name one function and time another.

The name is made from the function itself. Where the function is called by another one (a lambda, a helper of the
benchmark), the first call is watched, and it is an error if the function that the row names is not among those called.
"""

from __future__ import annotations

import inspect
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib.metadata import packages_distributions
from pathlib import Path
from types import BuiltinFunctionType, FrameType, MethodDescriptorType
from typing import Any, Generic, TypeVar

import numpy as np

from harmonicface.bench.measure import Record, version_of
from harmonicface.errors import HarmonicFaceError

Result = TypeVar("Result")
Function = Callable[..., Any]


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
        inner = _inner(run)
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


class Watch:
    """Functions that are to be called, and the name that they give to what calls them."""

    def __init__(self, *named: Function, about: str = "") -> None:
        self._named, self._about = named, about

    @property
    def name(self) -> str:
        """The functions, then what else is to be known."""
        functions = " + ".join(name_of(function) for function in self._named)
        return f"{functions}, {self._about}" if self._about and functions else functions

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the packages that the functions are from."""
        packages = {_package_of(function) for function in self._named} - {""}
        return {package: version_of(package) for package in sorted(packages)}

    def first(self, run: Callable[[], Result]) -> Result:
        """Call, and see that all functions are called."""
        if self._named == (_inner(run),):
            return run()
        wanted = {_seen_as(function): name_of(function) for function in self._named}
        with _watching(set(wanted)) as missed:
            result = run()
        if missed:
            missing = ", ".join(sorted(wanted[one] for one in missed))
            raise HarmonicFaceError(f"{self.name}: expected a call of {missing}, got none")
        return result


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
    """Return the shortest of several timed calls, after one that is watched and not timed."""
    call = _as_call(run)
    call.first()
    return call.timing(min(_seconds(call.run) for _ in range(repeats)))


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


def name_of(function: Function) -> str:
    """Return where a function is found: the shortest public way to it, or the modules that are not private.

    A function of a script is named with the script's file.

    Examples
    --------
    >>> name_of(np.linalg.svd), name_of(np.ones(3).sum), name_of(best)
    ('numpy.linalg.svd', 'numpy.ndarray.sum', 'harmonicface.bench.timing.best')
    """
    kind = _class_of(function)
    name = str(getattr(function, "__name__", repr(function)))
    whole = str(getattr(kind or function, "__qualname__", name))
    found = name if "<locals>" in whole else whole
    module = _module_of(function)
    file = getattr(sys.modules.get(module), "__file__", None)
    if module == "__main__" and file:
        return f"{found if kind is None else f'{found}.{name}'} of {Path(file).name}"
    parts = module.split(".")
    public = [part for part in parts if not part.startswith("_")]
    for end in range(1, len(parts) + 1):
        if _attribute(sys.modules.get(".".join(parts[:end])), found) is (kind or function):
            public = parts[:end]
            break
    return ".".join([*public, found, *([] if kind is None else [name])])


def _attribute(owner: object, path: str) -> object:
    """Return what lies at a path of names, None if nothing does."""
    for name in path.split("."):
        owner = getattr(owner, name, None)
    return owner


def _class_of(function: Function) -> type | None:
    """Return the class of a method that is bound, or of a built-in type; None for a function."""
    owner = getattr(function, "__self__", getattr(function, "__objclass__", None))
    if owner is None or inspect.ismodule(owner):
        return None
    return owner if inspect.isclass(owner) else type(owner)


def _module_of(function: Function) -> str:
    """Return the module that a function, or the class of its object, is defined in."""
    return str(getattr(_class_of(function) or function, "__module__", None) or "")


def _package_of(function: Function) -> str:
    """Return the distribution that a function comes with, "" if none is known."""
    return next(iter(_distributions().get(_module_of(function).partition(".")[0], [])), "")


@cache
def _distributions() -> Mapping[str, list[str]]:
    return packages_distributions()


def _inner(run: Function) -> Function:
    """Return the function that a partial is of."""
    while isinstance(run, partial):
        run = run.func
    return run


def _as_call(run: Call[Result] | Callable[[], Result]) -> Call[Result]:
    return run if isinstance(run, Call) else Call(run)


def _seen_as(function: Function) -> object:
    """Return what a profiler sees of a function: its code, or the class or module and the name of a built-in one.

    Raises
    ------
    HarmonicFaceError
        It is compiled in a way that no profiler sees.
    """
    plain = inspect.unwrap(getattr(function, "__func__", function))
    plain = getattr(plain, "_implementation", plain)
    code = getattr(plain, "__code__", None)
    if code is not None:
        for cell in getattr(plain, "__closure__", None) or ():  # a decorator that does not say what it wraps
            inside = cell.cell_contents
            if inspect.isfunction(inside) and inside.__name__ == plain.__name__ != code.co_name:
                return inside.__code__
        return code
    if plain is function and isinstance(plain, BuiltinFunctionType | MethodDescriptorType):
        return _class_of(plain) or _module_of(plain), plain.__name__
    raise HarmonicFaceError(f"{name_of(function)}: expected a function whose calls can be seen; time it by itself")


@contextmanager
def _watching(wanted: set[object]) -> Iterator[set[object]]:
    """Take out of a set what is called; watching ends with the last of them, for it costs time."""
    missed, before = set(wanted), sys.getprofile()

    def look(frame: FrameType, event: str, argument: Any) -> None:
        if event == "call":
            missed.discard(frame.f_code)
        elif event == "c_call":
            owners = (_class_of(argument) or type(None)).__mro__
            missed.difference_update((owner, argument.__name__) for owner in (*owners, _module_of(argument)))
        if not missed:
            sys.setprofile(before)

    if missed:
        sys.setprofile(look)
    try:
        yield missed
    finally:
        sys.setprofile(before)


def _seconds(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start
