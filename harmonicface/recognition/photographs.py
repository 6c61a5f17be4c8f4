"""Photographs: what recognition without geometry is given, checked once for all of its methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError


@dataclass(frozen=True, eq=False)
class Photographs:
    """Photographs of all people in one stack; made by `stacked`.

    Parameters
    ----------
    images
        (n, h, w) float32.
    people
        (n,) int32, the index of the person in each.
    count
        How many people there are.
    """

    images: NDArray[np.float32]
    people: NDArray[np.int32]
    count: int


def stacked(photographs: Sequence[ArrayLike]) -> Photographs:
    """Stack each person's photographs.

    Parameters
    ----------
    photographs
        For each person, (n_i, h, w) linear grey intensities, n_i of at least 1, all of one h and w.

    Raises
    ------
    HarmonicFaceError
        Nobody, a person without photographs, unequal shapes, NaN or infinity.

    Examples
    --------
    >>> stacked([np.zeros((2, 4, 3)), np.zeros((1, 4, 3))]).people
    array([0, 0, 1], dtype=int32)
    """
    if len(photographs) == 0:
        raise HarmonicFaceError("photographs: expected those of at least one person, got none")
    checked: list[Floats] = []
    for index, given in enumerate(photographs):
        stack = _validate.finite(given, f"photographs of person {index}")
        if stack.ndim != 3 or stack.size == 0:
            got = _validate.describe(stack)
            raise HarmonicFaceError(f"photographs of person {index}: expected shape (n, h, w), got {got}")
        if checked and stack.shape[1:] != checked[0].shape[1:]:
            expected = f"images of shape {checked[0].shape[1:]} as those of person 0"
            raise HarmonicFaceError(f"photographs of person {index}: expected {expected}, got {stack.shape[1:]}")
        checked.append(stack)
    people = np.repeat(np.arange(len(checked), dtype=np.int32), [len(stack) for stack in checked])
    return Photographs(np.concatenate(checked).astype(np.float32, copy=False), people, len(checked))


def one_photo(photo: ArrayLike, shape: tuple[int, int] | None) -> NDArray[np.float32]:
    """Return a query of the shape that was enrolled, (h, w) float32.

    Raises
    ------
    HarmonicFaceError
        Nobody is enrolled (`shape` is None), another shape, NaN or infinity.
    """
    if shape is None:
        raise HarmonicFaceError("expected people to be enrolled before a photo is matched, got a photo first")
    array = _validate.finite(photo, "photo")
    if array.shape != shape:
        raise HarmonicFaceError(f"photo: expected shape {shape}, got {_validate.describe(array)}")
    return array.astype(np.float32, copy=False)
