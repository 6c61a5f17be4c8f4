"""Small crowds of any kind, and the scan of everybody that every search must equal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from harmonicface.gallery.search.crowd import Company, crowd
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import sketch, stage_columns
from harmonicface.recognition.subspace import Subspace


@dataclass(frozen=True)
class Known:
    """People as a search sees them."""

    rows: list[NDArray[np.float32]]
    basis: SharedBasis
    companies: tuple[Company, ...]
    pixels: Pixels


def known(
    rows: Sequence[NDArray[np.float32]], basis: SharedBasis, columns: Sequence[int], dtype: str = "float32"
) -> Known:
    """Sketch people."""
    sketches = [sketch(one, basis, columns, dtype) for one in rows]
    defects = np.array([one.defect for one in sketches])
    size = basis.rows.shape[1]
    companies = crowd(sketches, stage_columns(columns, len(basis.rows)))
    return Known(list(rows), basis, companies, Pixels(lambda person: rows[person], defects, size))


def scan(
    rows: Sequence[NDArray[np.float32]], unit: NDArray[np.float64], top: int | None, distance: float
) -> list[tuple[float, int]]:
    """Measure everybody: the answer, without any bound."""
    everybody = sorted((Subspace(one, np.empty((len(one), 0))).distance(unit), who) for who, one in enumerate(rows))
    return [one for one in everybody if one[0] <= distance][:top]


def drawn(
    rng: np.random.Generator, ranks: Sequence[int], pixels: int, alike: float, duplicates: bool = False
) -> list[NDArray[np.float32]]:
    """Draw people who share a common part of their pictures; `alike` 1 leaves nothing of their own."""
    common = rng.normal(size=(max(ranks), pixels))
    rows = []
    for rank in ranks:
        own = rng.normal(size=(rank, pixels))
        rows.append(Subspace.of(alike * common[:rank] + (1 - alike) * own).rows)
    if duplicates:
        rows += [rows[0], rows[-1]]
    return rows


@pytest.fixture(scope="session")
def make() -> Callable[..., Known]:
    return known


@pytest.fixture(scope="session")
def draw() -> Callable[..., list[NDArray[np.float32]]]:
    return drawn


@pytest.fixture(scope="session")
def everybody() -> Callable[..., list[tuple[float, int]]]:
    return scan
