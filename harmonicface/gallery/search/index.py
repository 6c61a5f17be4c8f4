"""Index: the shared basis of a gallery, learned from a sample of its people, and everybody's sketch in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import COLUMNS, Sketch, sketches, stage_columns
from harmonicface.recognition.subspace import Subspace

# People at whose number a basis is learned, each time from so many. With fewer a scan of everybody is fast enough; what
# the second leaves over of people who come later is six tenths of what the first does; more would gain little.
LEARNED_AT = (1_000, 4_000)
FLOOR = 1e-3  # of a person's energy, for each of her rows: the weakest are needed by photographs under hard light


@dataclass(frozen=True, eq=False)
class Index:
    """What a search without reading everybody needs of a gallery; answers are exact whatever the basis is.

    Parameters
    ----------
    basis
        The shared basis.
    stops
        How many rows of it each stage of the sketches has seen.
    sample
        From how many people it was learned.
    """

    basis: SharedBasis
    stops: tuple[int, ...]
    sample: int

    @classmethod
    def learned(cls, sample: Sequence[Subspace], seed: int) -> Index:
        """Learn a shared basis.

        A row counts by the energy of pictures along it, the square of the singular value that it was made from, as
        `to_coefficients` tells. Memory: about five times the rows of the sample.

        Parameters
        ----------
        sample
            Of at least one person.
        seed
            Of the randomized factorization, at least 0.
        """
        rows = np.concatenate([one.rows for one in sample])
        weights = np.concatenate([_weights(one.to_coefficients) for one in sample])
        basis = SharedBasis.of(rows, weights, COLUMNS[-1], seed)
        return cls(basis, stage_columns(COLUMNS, len(basis.rows)), len(sample))

    def sketches(self, rows: Iterable[NDArray[np.floating]]) -> Iterator[Sketch]:
        """Yield the sketches of people from their rows as they are stored."""
        return sketches(list(rows), self.basis, self.stops)


def sampled(count: int, people: int, seed: int) -> list[int]:
    """Return the places of a sample of so many people, rising."""
    chosen = np.random.default_rng(seed).choice(count, min(people, count), replace=False)
    return sorted(chosen.tolist())


def _weights(to_coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how strongly pictures show each row, beside the floor (r,)."""
    energies = 1 / np.maximum(np.square(to_coefficients).sum(axis=1), np.finfo(np.float64).tiny)
    return np.asarray(energies / energies.sum() + FLOOR)
