"""Workers: how many threads a Dask cluster has, and what its workers make of many things, in order.

This is the only file that imports Dask.
"""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeVar

from harmonicface._memory import physical_memory
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.enrolment import Enrolment, Model
from harmonicface.gallery.enrolled.promised import Promise, enrolled
from harmonicface.gallery.frame import Frame

if TYPE_CHECKING:
    from distributed import Client, Future

AT_ONCE = 8  # people whom one task enrols
Item = TypeVar("Item")
Result = TypeVar("Result")


def in_order(
    client: Client, function: Callable[[Item], Result], items: Iterable[Item], ahead: int | None = None
) -> Iterator[Result]:
    """Yield what a function makes of each item, in their order, made by the workers.

    Memory does not grow with the number of items: they are taken as the results are asked for, so many tasks ahead.

    Parameters
    ----------
    client
        Of the cluster.
    function
        Of a module that the workers have.
    items
        What it is called with, one by one.
    ahead
        How many tasks of a few items are under way, at least 1; two for each thread of the workers by default.

    Raises
    ------
    HarmonicFaceError
        No dask.distributed, no workers; what the function refuses, after the results of all items before.
    """
    tasks = ahead or 2 * sum(threads_of(client).values())
    waiting: deque[Future] = deque()
    try:
        left = iter(items)
        while some := tuple(islice(left, AT_ONCE)):
            waiting.append(client.submit(_made, function, some, key=f"enrol-{uuid.uuid4().hex}"))
            if len(waiting) == tasks:
                yield from _results(waiting.popleft())
        while waiting:
            yield from _results(waiting.popleft())
    finally:
        client.cancel(list(waiting))


def enrolments(client: Client, sources: Iterable[Promise], frame: Frame | None, model: Model) -> Iterator[Enrolment]:
    """Yield what stands for people, in their order, made by the workers.

    Parameters
    ----------
    client
        Of the cluster.
    sources
        As of `promised.fulfilled`: those that are functions or files are made or read by the workers.
    frame
        The gallery's; None if the first person brings it, who is then enrolled here.
    model
        What the gallery makes of people.

    Raises
    ------
    HarmonicFaceError
        As `in_order` and `enrolment_of`.
    """
    left = iter(sources)
    if frame is None:
        for first in islice(left, 1):
            found = enrolled(first, None, model)
            frame = found.frame
            yield found
    yield from in_order(client, partial(enrolled, frame=frame, model=model), left)


def threads_of(client: Client) -> dict[str, int]:
    """Return the addresses of a cluster's workers, and how many threads each has.

    Raises
    ------
    HarmonicFaceError
        No dask.distributed, no client of it, no workers.
    """
    try:
        from distributed import Client  # an extra, needed for galleries beyond one machine
    except ImportError:
        raise HarmonicFaceError(
            "client: expected dask.distributed, got none: pip install harmonicface[distributed]"
        ) from None
    if not isinstance(client, Client):
        raise HarmonicFaceError(f"client: expected a client of dask.distributed, got {type(client).__name__}")
    found = dict(client.nthreads())
    if not found:
        raise HarmonicFaceError("client: expected a cluster with workers, got one that has none now")
    return found


def memory_of_worker() -> int:
    """Return how many bytes of memory the worker may take that this is called on."""
    from distributed import get_worker

    return int(get_worker().memory_manager.memory_limit or physical_memory())


def _results(future: Future) -> Iterator[Any]:
    """Yield the results of a task, then raise what stopped it."""
    results, error = future.result()
    yield from results
    if error is not None:
        raise error


def _made(function: Callable[[Any], Any], items: tuple[Any, ...]) -> tuple[list[Any], HarmonicFaceError | None]:
    """Return what a function makes of items, and why it stopped."""
    results = []
    for item in items:
        try:
            results.append(function(item))
        except HarmonicFaceError as error:
            return results, error
    return results, None
