"""People in a folder of several shards, photographs of them, and the answers of a scan of everybody."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from harmonicface.gallery.search.cascade import Found
from harmonicface.gallery.search.packing import packed, sketch_kinds
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import sketch
from harmonicface.recognition.subspace import Subspace
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder

PIXELS, STOPS = 80, (8, 24)
RNG = np.random.default_rng(0)
COMMON = RNG.normal(size=(25, PIXELS))
BASIS = SharedBasis(np.linalg.qr(RNG.normal(size=(PIXELS, STOPS[-1])))[0].T)


def drawn(rank: int, dtype: str) -> np.ndarray:
    """Return rows of a person who looks somewhat like everybody."""
    return Subspace.of(COMMON[:rank] + 0.7 * RNG.normal(size=(rank, PIXELS))).rows.astype(dtype)


def made(
    path: Path, people: Sequence[np.ndarray], unsketched: Sequence[int] = (), dtype: str = "float32"
) -> ArrayFolder:
    """Write people into a folder of several shards."""
    kinds = {"rows": Kind(np.dtype(dtype), (PIXELS,))}
    kinds |= {name: Kind(*kind) for name, kind in sketch_kinds(STOPS).items()}
    nothing = {name: np.empty((0, *kind.shape), kind.dtype) for name, kind in kinds.items()}
    folder = ArrayFolder.create(path, kinds, {"stops": STOPS}, {"basis": BASIS.rows})
    entries = [
        Entry(
            f"person {number}",
            nothing | ({} if number in unsketched else packed(sketch(rows, BASIS, STOPS))) | {"rows": rows},
        )
        for number, rows in enumerate(people)
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("harmonicface.store.writing.taken_in", lambda sizes, new: 0)
        for start in range(0, len(people), 7):
            folder.append(entries[start : start + 7])
    return folder


def scan(people: Sequence[np.ndarray], unit: np.ndarray, top: int | None, distance: float) -> list[tuple[float, int]]:
    """Measure everybody."""
    spans = [Subspace(rows.astype(np.float32), np.empty((len(rows), 0))) for rows in people]
    found = sorted((span.distance(unit), place) for place, span in enumerate(spans))
    return [one for one in found if one[0] <= distance][:top]


def pairs(found: Found) -> list[tuple[float, int]]:
    """Return distances and places."""
    return list(zip(found.distances, found.people, strict=True))


def units(people: Sequence[np.ndarray], count: int = 4) -> np.ndarray:
    """Return photographs of some people, and of nobody."""
    rng = np.random.default_rng(1)
    photos = [rng.normal(size=len(people[i])) @ people[i] + 0.03 * rng.normal(size=PIXELS) for i in range(count - 1)]
    photos.append(rng.normal(size=PIXELS))
    return np.stack([photo / np.linalg.norm(photo) for photo in photos])
