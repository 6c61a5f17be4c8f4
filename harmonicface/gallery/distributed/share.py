"""Share: which people of a gallery a process holds, said in so few bytes that any process can take them over."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.layout import BASIS
from harmonicface.gallery.disk.section import Section
from harmonicface.gallery.disk.staging import copy_of, fetch, is_url, staged_manifest
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.shelf import Shelf
from harmonicface.store.manifest import Manifest, read_manifest
from harmonicface.store.part import Part
from harmonicface.store.shard import Shard
from harmonicface.store.version import CommonArrays, Version

STOPS = "stops"  # what a gallery says of its sketches


@dataclass(frozen=True)
class Share:
    """Neighbours in a gallery, whatever shards they are in.

    Parameters
    ----------
    path
        The gallery's folder, on a file system that all processes see, or a path of fsspec's.
    copy
        The checksum of the manifest, by which copies of object storage are kept; "" on a file system.
    manifest
        Of the gallery, with those shards only in which these people are.
    skip, people
        How many people of these shards come before them, and how many they are.
    first_place
        The place of the first of them in the gallery.
    """

    path: str
    copy: str
    manifest: Manifest
    skip: int
    people: int
    first_place: int

    def shelf(self) -> Shelf:
        """Map the shards, which are copied to this machine first if they are in object storage.

        Raises
        ------
        HarmonicFaceError
            The gallery has changed since it was shared out, or it is damaged.
        """
        folder = Path(self.path)
        common, stops = self.manifest.common, tuple(self.manifest.about.get(STOPS, ()))
        if self.copy:
            folder = copy_of(self.copy)
            folder.mkdir(parents=True, exist_ok=True)
            wanted = [(one.record.file, one.record.nbytes) for one in self.manifest.shards]
            fetch(self.path, folder, wanted + ([(common.file, common.nbytes)] if common else []))
        elif missing := [file for file in sorted(self.manifest.files) if not (folder / file).exists()]:
            expected = f"the files of generation {self.manifest.generation}"
            raise HarmonicFaceError(
                f"{self.path:.200}: expected {expected}, got a gallery that was changed since, "
                f"without {missing[0]}: open it again"
            )
        kinds = self.manifest.kinds
        parts = tuple(Part(Shard(folder / one.record.file, one.record, kinds), one) for one in self.manifest.shards)
        own = CommonArrays(folder / common.file, common) if common else None
        version = Version(self.manifest, parts, own, leave_out_damaged=False)
        sections, begin, place = [], self.skip, self.first_place
        for part in version.parts:
            some = np.asarray(part.indices, np.intp)[begin : begin + self.people - (place - self.first_place)]
            sections.append(Section(part, some, place))
            begin, place = max(0, begin - len(part)), place + len(some)
        return Shelf(sections, SharedBasis(version.common[BASIS]) if stops else None, stops)


def shares_of(path: str, count: int, manifest: Manifest | None = None) -> list[Share]:
    """Share a gallery out, as evenly as can be; shards may be cut.

    Parameters
    ----------
    path
        The gallery's folder or a path of fsspec's.
    count
        Into how many shares, at least 1; they are fewer if there are fewer people.
    manifest
        What of it is shared out, if that is not all that is there now: the version that somebody has opened, without
        damaged shards.

    Raises
    ------
    HarmonicFaceError
        No gallery, or another one than the manifest says.
    """
    copy = ""
    if is_url(path):
        folder, found = staged_manifest(path)
        copy = folder.name
    else:
        path = str(Path(path).resolve())
        found = read_manifest(Path(path)) if manifest is None else manifest
    if manifest is not None and found.generation != manifest.generation:
        expected, got = f"generation {manifest.generation} of the gallery", f"generation {found.generation}"
        raise HarmonicFaceError(f"{path:.200}: expected {expected}, got {got}: open it again")
    manifest = manifest or found
    words = {name: word for name, word in manifest.about.items() if name == STOPS}
    firsts = np.cumsum([0, *(one.record.entries - len(one.removed) for one in manifest.shards)])
    edges = np.linspace(0, firsts[-1], max(1, min(count, int(firsts[-1]))) + 1).round().astype(int).tolist()
    shares = []
    for begin, behind in pairwise(edges):
        inside = np.flatnonzero((firsts[1:] > begin) & (firsts[:-1] < behind))
        shards = tuple(manifest.shards[number] for number in inside.tolist())
        skip = begin - int(firsts[inside[0]]) if len(inside) else 0
        shares.append(Share(path, copy, replace(manifest, about=words, shards=shards), skip, behind - begin, begin))
    return shares
