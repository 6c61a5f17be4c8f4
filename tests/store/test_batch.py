"""Batches: as many bytes as asked for, in order."""

from __future__ import annotations

import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.batch import batches


def test_a_batch_is_full_when_it_has_the_bytes(kinds, make) -> None:
    entries = [make(number) for number in range(10)]
    size = max(entry.nbytes for entry in entries)
    found = list(batches(iter(entries), kinds, 3 * size))
    assert [key for batch in found for key in batch.keys] == [entry.key for entry in entries]
    assert all(3 * size <= batch.nbytes < 4 * size for batch in found[:-1])
    assert len(found) > 1


def test_a_batch_tells_everybodys_rows(kinds, make) -> None:
    (batch,) = batches([make(1), make(3)], kinds, 1 << 20)
    assert [len(piece) for piece in batch.pieces("rows")] == [2, 4]
    assert batch.directory.counts.tolist() == [[1, 2, 1], [3, 4, 1]]
    assert [batch.directory.key(i) for i in range(2)] == ["entry 1", "entry 3"]


def test_nothing_is_no_batch(kinds) -> None:
    assert list(batches([], kinds, 1)) == []


def test_a_key_twice(kinds, make) -> None:
    with pytest.raises(HarmonicFaceError, match="key: expected every one once, got 'a' twice"):
        list(batches([make(1, "a"), make(2, "a")], kinds, 1 << 20))
