"""Sources of people that are made where they are needed: by a call, or from a file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from numpy.typing import ArrayLike

from harmonicface.gallery.enrolled.enrolment import Enrolment, Model, enrolment_of
from harmonicface.gallery.enrolled.sources import MeshView, read_source
from harmonicface.gallery.frame import Frame
from harmonicface.surfaces.surface import Surface

USUAL_SIZE = 64  # pixels a side of a mesh, if nobody has said how large pictures are
Source = Surface | ArrayLike
Promise = Source | str | os.PathLike[str] | Callable[[], Source]


def fulfilled(source: Promise, frame: Frame | None) -> Source:
    """Return what a person is enrolled from.

    Parameters
    ----------
    source
        A Surface, photographs, a file of one of them (a mesh is seen from the front, as large as the frame), or a
        function without arguments that returns a Surface or photographs.
    frame
        The gallery's, if it has one.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read.
    """
    if isinstance(source, str | os.PathLike):
        size = USUAL_SIZE if frame is None else frame.shape[0]
        return read_source([Path(source)], MeshView(), None, size)
    return source() if callable(source) else source


def enrolled(source: Promise, frame: Frame | None, model: Model) -> Enrolment:
    """Return what stands for a person: `enrolment_of` of what `fulfilled` returns; raises as they do."""
    return enrolment_of(fulfilled(source, frame), frame, model)
