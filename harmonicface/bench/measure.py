"""One record type for a measurement, and what must be known of the machine to read it."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing

PACKAGES = ("harmonicface", "numpy", "scipy", "opencv-contrib-python-headless", "scikit-learn", "trimesh")
ALWAYS = ("harmonicface", "numpy")  # packages whose versions every record has


@cache
def version_of(package: str) -> str:
    """Return the version of an installed package, "" where it is not told."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


@dataclass(frozen=True)
class Record:
    """A measurement: how fast, how wrong, and beside whom.

    A record with a peer is made by `bench.timing.record`, which takes the peer's name from the function that was timed.

    Parameters
    ----------
    name
        The question, as "match one photo".
    size
        What it was asked of, as "1000 people 64x64".
    seconds
        Wall time of ours.
    error
        How far our answer is from the right one, in `unit`.
    bytes
        Memory that ours reads or keeps.
    peer
        What was timed beside it in the same run.
    peer_seconds
        Wall time of the peer.
    note
        What a reader has to know.
    unit
        What an error counts, as "% given to the wrong person" or "relative L2".
    peer_error
        The peer's error, in the same unit; 0 where its answer is the right one.
    seed
        What randomness began with, one number or in words ("0 to 15"); None where there is none.
    question
        Records that answer the same question, in the same unit, are drawn in one plot: each is another way to it.
    call
        The function of ours that was timed.
    versions
        Of the packages that were timed.
    """

    name: str
    size: str
    seconds: float
    error: float | None = None
    bytes: int | None = None
    peer: str | None = None
    peer_seconds: float | None = None
    note: str = ""
    unit: str = ""
    peer_error: float | None = None
    seed: int | str | None = None
    question: str = ""
    call: str = ""
    versions: dict[str, str] = field(default_factory=lambda: {name: version_of(name) for name in ALWAYS})

    @property
    def ratio(self) -> float | None:
        """Our time over the peer's."""
        return None if self.peer_seconds is None else self.seconds / self.peer_seconds

    def as_dict(self) -> dict[str, object]:
        """Return the fields and the ratio."""
        return {**asdict(self), "ratio": self.ratio}


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


def read_records(path: str | os.PathLike[str]) -> list[Record]:
    """Return the records that `write_records` has written.

    Raises
    ------
    HarmonicFaceError
        The file cannot be read, or holds something else.
    """
    known = {one.name for one in fields(Record)}
    try:
        found: list[dict[str, Any]] = json.loads(Path(path).read_text(encoding="utf-8"))
        return [Record(**{name: value for name, value in one.items() if name in known}) for one in found]
    except OSError as error:
        raise HarmonicFaceError(f"cannot read {path}: {error.strerror}") from None
    except (ValueError, TypeError, AttributeError):
        raise HarmonicFaceError(f"{path}: expected a JSON list of records") from None


def _processor() -> str:
    """Return the name of the processor."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
