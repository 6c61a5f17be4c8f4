"""A gallery on many machines: Dask gives each worker its share of the people, and sends every question to all of them.

What a worker holds is the result of a task, its shelf. It stays where it is, because moving it is dearer than asking
it; when a worker dies, Dask makes its shelves anew on others from the same few words (`Share`), and asks again whatever
had not been answered.
"""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.distributed.share import Share, shares_of
from harmonicface.gallery.distributed.workers import memory_of_worker, threads_of
from harmonicface.gallery.search.cascade import FURTHEST, Found
from harmonicface.gallery.search.shelf import Shelf, merged
from harmonicface.store.manifest import Manifest

if TYPE_CHECKING:
    from distributed import Client, Future

NEAR = 0.1  # where nearly everybody is whose photograph is good, and nobody else
MANY = 100_000  # people of a shelf, whose search takes longer than a message and its answer
SMALL = 1 << 16  # bytes of photographs that are sent to every worker
MESSAGE = 1 << 22  # bytes of photographs that are asked for together
MAPPED = 4  # of a worker's memory, pages of files take at most one part in so many
Units = NDArray[np.float64]
Result = TypeVar("Result")


class SharedShelf:
    """Everybody in a gallery, on the workers of a Dask cluster: the answers of one `Shelf` of everybody.

    Parameters
    ----------
    path
        The gallery's folder, on a file system that all workers see under this path; or a path of fsspec's, from which
        each worker copies its own shards to the disk of its machine.
    client
        Of the cluster. Every thread of its workers gets one share of the people, as even as can be.
    manifest
        Which version of the gallery, if it is not the one that is there now; as of `shares_of`.

    Raises
    ------
    HarmonicFaceError
        No dask.distributed, no workers, no gallery, a worker that cannot read it.
    """

    def __init__(self, path: str, client: Client, manifest: Manifest | None = None) -> None:
        self._client = client
        self._shares = shares_of(path, sum(threads_of(client).values()), manifest)
        self._held: list[Future] = []
        self.spread()

    def __len__(self) -> int:
        return sum(share.people for share in self._shares)

    def spread(self) -> None:
        """Give the shares to the workers that are there now; when some have come or gone, this evens out their work.

        Raises
        ------
        HarmonicFaceError
            As the constructor.
        """
        workers = [worker for worker, threads in sorted(threads_of(self._client).items()) for _ in range(threads)]
        # a worker that has gone meanwhile is no hindrance
        self._held = [
            self._client.submit(
                Held, share, key=f"shelf-{uuid.uuid4().hex}", workers=[worker], allow_other_workers=True
            )
            for share, worker in zip(self._shares, cycle(workers), strict=False)
        ]
        self._on_all(_ready)

    def search(self, unit: Units, top: int | None = 1, distance: float = FURTHEST) -> Found:
        """Find the people nearest to a photograph; as `Shelf.search`.

        Raises
        ------
        HarmonicFaceError
            What a shelf refuses; shards that a new worker does not find because the gallery was changed since.
        """
        return self.search_many(unit[None], top, distance)[0]

    def search_many(self, units: Units, top: int | None = 1, distance: float = FURTHEST) -> list[Found]:
        """Find the people nearest to each of several photographs; raises as `search`.

        All photographs are one message to each shelf. Where shelves are large and one person is asked for, she is
        looked for nearby first: a shelf that does not hold her excludes its people sooner if it may stop there.
        """
        if top != 1 or distance <= NEAR or len(self) < MANY * len(self._held):
            return self._asked(units, top, distance)
        found = self._asked(units, top, NEAR)
        left = [number for number, one in enumerate(found) if not one.people]
        if left:
            for number, one in zip(left, self._asked(units[left], top, distance), strict=True):
                found[number] = replace(one, measured=one.measured + found[number].measured)
        return found

    def closeness(self, units: Units) -> NDArray[np.float32]:
        """Return |Q y|^2 of everybody for unit photographs, (n, q) from (q, p); raises as `search`."""
        return np.concatenate(self._on_all(_closeness, units))

    def _asked(self, units: Units, top: int | None, distance: float) -> list[Found]:
        """Return the answers of all shelves together."""
        found: list[Found] = []
        step = max(1, MESSAGE // units[:1].nbytes) if len(units) else 1
        for start in range(0, len(units), step):
            answers = self._on_all(_searched, units[start : start + step], top, distance)
            found += [merged(some, top) for some in zip(*answers, strict=True)]
        return found

    def _on_all(self, function: Callable[..., Result], units: Units | None = None, *more: object) -> list[Result]:
        """Ask every shelf where it is, and return the answers in their order."""
        name, question = uuid.uuid4().hex, units
        if units is not None and units.nbytes > SMALL:  # once to one worker, from which the others have it
            question = self._client.submit(_given, units, key=f"photographs-{name}")
        # tasks of a name of their own are no mass of equal ones, which Dask would spread over all workers
        keys = [(f"ask-{name}", number) for number in range(len(self._held))]
        rest = [[one] * len(keys) for one in (question, *more)]
        return list(self._client.gather(self._client.map(function, self._held, *rest, key=keys)))


class Held:
    """A shelf in the memory of a worker; what is sent of it to another one is the share, by which it is made there.

    Parameters
    ----------
    share
        Whom it holds.
    """

    def __init__(self, share: Share) -> None:
        self.share = share
        self.shelf: Shelf = share.shelf()

    def __reduce__(self) -> tuple[type[Held], tuple[Share]]:
        return Held, (self.share,)

    def __sizeof__(self) -> int:
        return self.shelf.nbytes


def _ready(held: Held, nothing: None) -> None:
    """Do nothing on the worker that holds a shelf."""


def _given(units: Units) -> Units:
    """Have photographs as the result of a task, which Dask makes again where it is lost."""
    return units


def _searched(held: Held, units: Units, top: int | None, distance: float) -> list[Found]:
    """Search a shelf on the worker that holds it."""
    if len(units) == 1:
        found = [held.shelf.search(units[0], top, distance)]
    else:
        found = held.shelf.search_many(units, top, distance)
    _tidy(held)
    return found


def _closeness(held: Held, units: Units) -> NDArray[np.float32]:
    """Look at everybody on the worker that holds them."""
    found = held.shelf.closeness(units)
    _tidy(held)
    return found


def _tidy(held: Held) -> None:
    """Give pages of files back before they are much of the worker's memory: its nanny counts them."""
    statistics = Path("/proc/self/statm")
    if statistics.exists():
        mapped = int(statistics.read_text(encoding="ascii").split()[2]) * os.sysconf("SC_PAGE_SIZE")
        if mapped > memory_of_worker() // MAPPED:
            held.shelf.forget()
