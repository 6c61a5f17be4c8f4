"""What stands for a person: the span of the pictures that her Surface or her photographs give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.frame import Frame
from harmonicface.recognition.subspace import Subspace
from harmonicface.surfaces.surface import Surface

FEWEST_PHOTOGRAPHS = 3  # fewer do not span the pictures of even a surface without shadows
MOST_ROWS = 9


@dataclass(frozen=True, eq=False)
class Enrolment:
    """A person's subspace, the frame it is in, and what it was made from: "surface" or "photographs"."""

    subspace: Subspace
    frame: Frame
    source: str


def enrolment_of(
    source: Surface | ArrayLike, frame: Frame | None, pictures_of: Callable[[Surface], Floats]
) -> Enrolment:
    """Return what stands for a person.

    Parameters
    ----------
    source
        A Surface, or (n, h, w) photographs under n >= 3 different lights, of which the nine strongest directions count.
    frame
        The gallery's; None for the first person, whose every pixel then becomes the frame.
    pictures_of
        The model: the pictures that span those of a Surface.

    Raises
    ------
    HarmonicFaceError
        Another shape than the frame's, fewer than three different photographs, negative ones, NaN, an empty overlap.
    """
    if isinstance(source, Surface):
        frame = frame or Frame(np.ones(source.shape, np.bool_))
        return Enrolment(Subspace.of(frame.place(pictures_of(source), source.mask)), frame, "surface")
    stack = _validate.floats(source, "photographs")
    if stack.ndim not in (3, 4) or len(stack) < FEWEST_PHOTOGRAPHS or stack.size == 0:
        expected = f"a Surface, or at least {FEWEST_PHOTOGRAPHS} photographs of shape (n, h, w)"
        raise HarmonicFaceError(f"source: expected {expected}, got {_validate.describe(stack)}")
    frame = frame or Frame(np.ones(stack.shape[1:3], np.bool_))
    subspace = Subspace.of(np.stack([frame.take(photo, "photographs") for photo in stack]), MOST_ROWS)
    if subspace.rank < FEWEST_PHOTOGRAPHS:
        expected = f"at least {FEWEST_PHOTOGRAPHS} photographs that differ, under different lights"
        raise HarmonicFaceError(f"source: expected {expected}, got {subspace.rank} different of {len(stack)}")
    return Enrolment(subspace, frame, "photographs")
