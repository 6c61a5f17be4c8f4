"""Saving: people of a gallery, wherever they are kept, into a folder or one portable file, whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk import storage
from harmonicface.gallery.disk.layout import BASIS, DTYPES, MASK, About, entries_of
from harmonicface.gallery.disk.paths import PathLike, is_file
from harmonicface.gallery.enrolled.people import People
from harmonicface.gallery.enrolled.rows import StackedRows
from harmonicface.gallery.rule import Rule
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME as MANIFEST
from harmonicface.store.whole import make_whole


def save_folder(path: Path, people: People, rule: Rule, places: Sequence[int], dtype: str | None) -> None:
    """Write people into a new folder, or in the place of a gallery's.

    Parameters
    ----------
    path
        The folder.
    people, rule
        Of the gallery.
    places
        Of whom to write, at least one.
    dtype
        Of their rows; None for as they are.

    Raises
    ------
    HarmonicFaceError
        Another dtype; something else than a gallery is there, or it cannot be written.
    """
    about, frame = About.of(rule, people.dtype if dtype is None else checked_dtype(dtype)), people.frame
    common: dict[str, NDArray[Any]] = {MASK: frame.mask}
    if people.index is not None:
        about = replace(about, stops=people.index.stops, sample=people.index.sample)
        common[BASIS] = people.index.basis.rows
    pairs = ((people.name(place), people.enrolment(place)) for place in places)
    kept = entries_of(pairs, about.dtype, people.index), about.kinds(frame), about.words(), common
    if not (path / MANIFEST).exists():
        make_whole(path, *kept)
        return
    folder = ArrayFolder(path)
    About.read(folder.version(leave_out_damaged=True), str(path))  # it is a gallery's
    folder.replace(*kept)


def save_file(path: PathLike, people: People, rule: Rule, places: Sequence[int], dtype: str | None) -> None:
    """Write people into one portable file; as `save_folder`, but in memory and as float32."""
    if dtype not in (None, DTYPES[0]):
        raise HarmonicFaceError(f"dtype: expected {DTYPES[0]} for a portable file, got {dtype!r:.40}")
    if is_file(path):
        storage.check_kind(path)
    rows = StackedRows(np.empty((0, people.frame.pixels), np.float32))
    sources, templates = {}, []
    for place in places:
        enrolled = people.enrolment(place)
        rows.append(enrolled.subspace)
        sources[people.name(place)] = enrolled.source
        templates += [] if enrolled.template is None else [enrolled.template]
    mask = people.frame.mask
    storage.write(
        path,
        storage.Contents(rule.model, rule.threshold, rule.margin, rule.shortlist, mask, rows, sources, templates),
    )


def checked_dtype(dtype: str) -> str:
    """Return a type of rows.

    Raises
    ------
    HarmonicFaceError
        Another than "float32" and "float16".
    """
    if dtype not in DTYPES:
        raise HarmonicFaceError(f"dtype: expected one of {', '.join(DTYPES)}, got {_validate.describe(dtype)}")
    return dtype
