"""One record type for a measurement, and what must be known of the machine to read it."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

from harmonicface.io.files import replacing

PACKAGES = ("harmonicface", "numpy", "scipy", "opencv-contrib-python-headless", "scikit-learn", "trimesh")


@dataclass(frozen=True)
class Record:
    """A measurement: how fast, how wrong, and beside whom.

    Parameters
    ----------
    name
        The question, as "match one photo".
    size
        What it was asked of, as "1000 people 64x64".
    seconds
        Wall time of ours.
    error
        How far our answer is from the right one; `note` says in what.
    bytes
        Memory that ours reads or keeps.
    peer
        What was timed beside it in the same run.
    peer_seconds
        Wall time of the peer.
    note
        What a reader has to know, with the peer's error where it has one.
    """

    name: str
    size: str
    seconds: float
    error: float | None = None
    bytes: int | None = None
    peer: str | None = None
    peer_seconds: float | None = None
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """Our time over the peer's."""
        return None if self.peer_seconds is None else self.seconds / self.peer_seconds

    def as_dict(self) -> dict[str, object]:
        """Return the fields and the ratio."""
        return {**asdict(self), "ratio": self.ratio}


def best_seconds(function: Callable[[], object], repeats: int = 7) -> float:
    """Return the shortest of several timed calls, after one that is not timed."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def machine() -> dict[str, object]:
    """Return what a measurement depends on: processor, cores, Python and package versions."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "packages": {name: version(name) for name in PACKAGES},
    }


def write_records(path: str | os.PathLike[str], records: Sequence[Record]) -> None:
    """Write records as a JSON list."""
    with replacing(path) as temporary:
        text = json.dumps([record.as_dict() for record in records], indent=2)
        temporary.write_text(text + "\n", encoding="utf-8")


def print_records(records: Sequence[Record]) -> None:
    """Print records, one to a paragraph."""
    for record in records:
        print(f"{record.name}, {record.size}: {1e3 * record.seconds:.2f} ms", end="")
        if record.peer_seconds is not None:
            print(f"; {record.peer}: {1e3 * record.peer_seconds:.2f} ms; ratio {record.ratio:.2f}", end="")
        print(f"\n    error {record.error}; {record.note}")


def _processor() -> str:
    """Return the name of the processor."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
