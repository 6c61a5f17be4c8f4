"""Memory: refuse what cannot fit before it is asked of the system, in one line that says how much it would take."""

from __future__ import annotations

import math
import os
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from harmonicface.errors import HarmonicFaceError

CONTAINER_LIMIT = Path("/sys/fs/cgroup/memory.max")


@cache
def physical_memory() -> int:
    """Return the bytes of memory that this process may use: the machine's, or its container's if that is less.

    Where the system does not tell, the largest address.
    """
    try:
        installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        installed = 2**63 - 1
    try:
        return min(installed, int(CONTAINER_LIMIT.read_text(encoding="ascii")))
    except (OSError, ValueError):  # no container, or one without a limit ("max")
        return installed


def require(needed: int, what: str) -> None:
    """Refuse work that needs more bytes than there is memory.

    Raises
    ------
    HarmonicFaceError
        More than the whole memory; what is free at the moment is not asked, since caches are given back on demand.

    Examples
    --------
    >>> require(10**21, "harmonics of order 10000 at 10 directions")
    Traceback (most recent call last):
    harmonicface.errors.HarmonicFaceError: harmonics of order 10000 at 10 directions: need 1e+12 GB of memory, ...
    """
    available = physical_memory()
    if needed > available:
        raise HarmonicFaceError(
            f"{what}: need {needed / 1e9:.3g} GB of memory, expected at most the {available / 1e9:.3g} GB there are"
        )


def empty(shape: tuple[int, ...], dtype: DTypeLike, what: str) -> NDArray[Any]:
    """Make an array without values, or say in one line what it would have needed.

    Raises
    ------
    HarmonicFaceError
        More than the whole memory, or more than the system gives.
    """
    needed = math.prod(shape) * np.dtype(dtype).itemsize
    require(needed, what)
    try:
        return np.empty(shape, dtype)
    except MemoryError:
        raise HarmonicFaceError(f"{what}: need {needed / 1e9:.3g} GB of memory, the system refused them") from None
