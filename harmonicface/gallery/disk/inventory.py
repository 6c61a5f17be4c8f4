"""Inventory: what a gallery on disk holds and what it takes, told without reading its people."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.disk import layout, storage
from harmonicface.gallery.disk.paths import is_folder, refuse_nothing
from harmonicface.gallery.search.packing import DOUBTS
from harmonicface.store.archive import read_about
from harmonicface.store.manifest import NAME
from harmonicface.store.part import Part
from harmonicface.store.version import Version, opened


@dataclass(frozen=True)
class Index:
    """The shared basis by which a gallery is searched.

    Parameters
    ----------
    rows
        Of the basis.
    stages
        How many of them each stage of a search has seen.
    sample
        From how many people it was learned.
    sketched
        How many people have a sketch in it; the others are scanned.
    """

    rows: int
    stages: tuple[int, ...]
    sample: int
    sketched: int


@dataclass(frozen=True)
class Inventory:
    """What a gallery holds and takes.

    Parameters
    ----------
    version
        Of the gallery format.
    model, threshold, margin, shortlist
        As of `Gallery`; a margin of None is infinite.
    shape, pixels
        Height and width of the pictures, and how many of their pixels are compared.
    dtype
        Of the rows.
    people, rows
        How many there are, and how many rows they have together; without those in damaged shards.
    nbytes
        Of all files.
    shards
        How many files hold people; 0 for a gallery that is one file.
    removed_bytes
        Of the arrays of people who were removed: `compact` frees them.
    damaged
        How many shards cannot be opened; `verify` says which, and reads the others too.
    index
        The shared basis, if one was learned.
    """

    version: str
    model: str
    threshold: float
    margin: float | None
    shortlist: int
    shape: tuple[int, int]
    pixels: int
    dtype: str
    people: int
    rows: int
    nbytes: int
    shards: int
    removed_bytes: int
    damaged: int
    index: Index | None

    @property
    def bytes_per_person(self) -> float:
        """Bytes a person takes, those of removed people not counted; 0 of an empty gallery."""
        return (self.nbytes - self.removed_bytes) / self.people if self.people else 0.0


def inventory(path: str | os.PathLike[str]) -> Inventory:
    """Say what a gallery holds; of a folder the manifest and the directories of its shards are read, no more.

    Parameters
    ----------
    path
        A gallery's folder, or its one file, which is read as a whole.

    Raises
    ------
    HarmonicFaceError
        No gallery, a damaged manifest or a damaged file.

    Examples
    --------
    >>> import tempfile
    >>> import harmonicface as hf
    >>> with tempfile.TemporaryDirectory() as place:
    ...     gallery = hf.Gallery.create(place + "/people")
    ...     gallery.enroll("ada", hf.synthetic_person(1, 24))
    ...     found = inventory(place + "/people")
    >>> found.people, found.rows, found.shape, found.dtype, found.shards
    (1, 9, (24, 24), 'float32', 1)
    """
    refuse_nothing(path)
    place = Path(path)
    return _of_folder(place, opened(place, {}, leave_out_damaged=True)) if is_folder(place) else _of_file(place)


def _of_folder(path: Path, version: Version) -> Inventory:
    """Say what is in a folder."""
    about = layout.About.read(version, str(path))
    mask, counts = version.common[layout.MASK], _counts(version)
    index = None
    if about.stops:
        index = Index(about.stops[-1], about.stops, about.sample, sketched=int((counts[DOUBTS] > 0).sum()))
    return Inventory(
        version=layout.VERSION,
        model=about.model,
        threshold=about.threshold,
        margin=about.margin,
        shortlist=about.shortlist,
        shape=(mask.shape[0], mask.shape[1]),
        pixels=int(mask.sum()),
        dtype=about.dtype,
        people=len(version),
        rows=int(counts[layout.ROWS].sum()),
        nbytes=version.nbytes + (path / NAME).stat().st_size,
        shards=len(version.all_parts),
        removed_bytes=sum(map(_removed_bytes, version.parts)),
        damaged=len(version.damaged),
        index=index,
    )


def _counts(version: Version) -> dict[str, NDArray[np.int64]]:
    """Return how many rows everybody has in each array, (n,) by its name."""
    names = sorted(version.kinds)
    nobody = np.zeros((0, len(names)), np.int64)
    counts = np.concatenate([nobody, *(part.shard.directory.counts[part.alive] for part in version.parts)])
    return dict(zip(names, counts.T, strict=True))


def _removed_bytes(part: Part) -> int:
    """Return the bytes of the arrays of entries that were removed."""
    kinds = part.shard.kinds
    row_bytes = np.array([kinds[name].row_bytes for name in sorted(kinds)])
    return int((part.shard.directory.counts[~part.alive] @ row_bytes).sum())


def _of_file(path: Path) -> Inventory:
    """Say what is in a file."""
    contents = storage.read(path)
    rows, mask = contents.rows.array, contents.mask
    return Inventory(
        version=read_about(path)["version"],
        model=contents.model,
        threshold=contents.threshold,
        margin=None if contents.margin == np.inf else contents.margin,
        shortlist=contents.shortlist,
        shape=(mask.shape[0], mask.shape[1]),
        pixels=int(mask.sum()),
        dtype=str(rows.dtype),
        people=len(contents.sources),
        rows=len(rows),
        nbytes=path.stat().st_size,
        shards=0,
        removed_bytes=0,
        damaged=0,
        index=None,
    )
