"""Many photographs at once: what each finds alone, by either way; see test_cascade.py for the scan."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from harmonicface.gallery.search import batches
from harmonicface.gallery.search.cascade import search
from harmonicface.gallery.search.shared_basis import SharedBasis


@pytest.mark.parametrize("share", [-1.0, 2.0])
@pytest.mark.parametrize(("top", "distance"), [(1, 1.0), (5, 1.0), (None, 0.3), (None, 0.0), (3, 0.5)])
def test_each_finds_what_it_finds_alone(
    make: Callable[..., Any], draw: Callable[..., Any], share: float, top: int | None, distance: float
) -> None:
    rng = np.random.default_rng(4)
    rows = draw(rng, [9, 5, 25, 9] * 60, 300, 0.7)
    known = make(rows, SharedBasis.of(np.concatenate(rows[:80]), np.ones(20 * 48), 60), [8, 30, 60])
    units = np.stack([rng.normal(size=len(rows[who])) @ rows[who] + 0.01 * rng.normal(size=300) for who in range(12)])
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    everybody = known.companies, known.pixels, known.basis
    alone = [search(*everybody, unit, top, distance) for unit in units]
    with patch.object(batches, "DENSE", share), patch("harmonicface.gallery.search.dense.PRODUCTS", 2_000):
        together = batches.search_many(*everybody, units, top, distance)
    for one, other in zip(alone, together, strict=True):
        assert (one.people, one.distances) == (other.people, other.distances)
        assert list(other.survivors) == sorted(other.survivors, reverse=True)
        assert len(other.people) <= other.measured <= len(rows)
