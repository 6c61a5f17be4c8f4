"""The people of a gallery: everybody's rows, templates and sources in one frame, kept in step with each other."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolment import MOST_ROWS, WITH_GEOMETRY, Enrolment
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.portrait import Portrait
from harmonicface.gallery.rows import StackedRows
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.grid import grid
from harmonicface.recognition.patterns import Template
from harmonicface.recognition.render_compare import Photograph
from harmonicface.recognition.subspace import Subspace

FEWEST_PIXELS = 4 * MOST_ROWS  # as many pixels as rows are explained by anybody


class People:
    """Everybody who is enrolled, by index in the order of enrolment.

    Parameters
    ----------
    frame
        The pixels that are compared; None until the first person brings them.
    """

    def __init__(self, frame: Frame | None = None) -> None:
        self.known_frame = frame
        self.sources: dict[str, str] = {}  # from what each person was enrolled
        self.portraits: list[Portrait] = []  # of everybody, with the default model
        self._rows: StackedRows | None = None

    def __len__(self) -> int:
        return len(self.sources)

    @property
    def frame(self) -> Frame:
        """The frame, once there is one."""
        assert self.known_frame is not None, "somebody is enrolled"
        return self.known_frame

    @property
    def rows(self) -> StackedRows:
        """Everybody's rows, once there are some."""
        assert self._rows is not None, "somebody is enrolled"
        return self._rows

    @property
    def names(self) -> tuple[str, ...]:
        """Everybody's name."""
        return tuple(self.sources)

    @property
    def nbytes(self) -> int:
        """Memory of rows, templates and pictures."""
        rows = 0 if self._rows is None else self._rows.array.nbytes
        return rows + sum(portrait.nbytes for portrait in self.portraits)

    @property
    def pixels_of_grid(self) -> float:
        """How many pixels of a photograph a pixel of the grid is wide."""
        return self.frame.shape[0] / grid(self.frame.shape)[0]

    def index(self, name: str) -> int:
        """Return the index of a person.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        if name not in self.sources:
            raise HarmonicFaceError(f"name: expected somebody in the gallery, got {name!r}, who is not")
        return self.names.index(name)

    def subspace(self, name: str) -> Subspace:
        """Return a person's subspace; raises as `index` does."""
        return self.rows.subspace(self.index(name))

    def add(self, name: str, enrolled: Enrolment) -> None:
        """Add a person, whose name is new."""
        self.known_frame = enrolled.frame
        if self._rows is None:
            self._rows = StackedRows(np.empty((0, enrolled.frame.pixels), np.float32))
        self._rows.append(enrolled.subspace)
        self.sources[name] = enrolled.source
        if enrolled.template is not None:
            self.portraits.append(self._portrait(name, enrolled.template))

    def remove(self, name: str) -> None:
        """Take a person out."""
        index = self.index(name)
        self.rows.remove(index)
        del self.sources[name]
        del self.portraits[index : index + 1]

    def restore(self, rows: StackedRows, sources: dict[str, str], templates: Iterable[Template]) -> None:
        """Take in everybody from a file."""
        self._rows, self.sources = rows, dict(sources)
        self.portraits = [self._portrait(*one) for one in zip(self.names, templates, strict=False)]

    def asked(self, photo: ArrayLike, mask: ArrayLike | None) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the compared pixels of a photograph, and which of them are good, (p,) each.

        Raises
        ------
        HarmonicFaceError
            Nobody is there, another shape, NaN or infinity, more negative than positive intensities, fewer than 36
            good pixels.
        """
        if not len(self):
            raise HarmonicFaceError("match: expected a gallery with somebody in it, got an empty one")
        pixels = self.frame.take(photo, "photo")
        good = np.ones(len(pixels), np.bool_)
        if mask is not None:
            shared = self.frame.mask & _validate.mask(mask, "mask", self.frame.shape)
            good = _validate.mask(shared, "mask inside the gallery's mask", self.frame.shape)[self.frame.mask]
        if good.sum() < FEWEST_PIXELS:
            raise HarmonicFaceError(f"match: expected at least {FEWEST_PIXELS} good pixels, got {good.sum()}")
        return pixels, good

    def photograph(self, pixels: Floats, good: NDArray[np.bool_]) -> Photograph:
        """Return a photograph for the second look."""
        seen = self.frame.mask.copy()
        seen[self.frame.mask] = good
        return Photograph(self.frame.picture(pixels), seen)

    def light(
        self,
        index: int,
        pixels: Floats,
        good: NDArray[np.bool_],
        shift: tuple[float, float] = (0.0, 0.0),
        ambient: bool = True,
    ) -> HarmonicLight | None:
        """Return the light of a photograph, if this person was enrolled with geometry, where she was found.

        Without `ambient`, her pictures are those of linear3, which has none for ambient light.
        """
        if self.sources[self.names[index]] not in WITH_GEOMETRY:
            return None
        if any(shift):
            pixels, good = self.frame.moved(pixels, good, (-round(shift[0]), -round(shift[1])))
        subspace = self.rows.subspace(index)
        if not subspace.rows[:, good].any():
            return None
        if not good.all():
            subspace = subspace.restrict(good)
        coefficients = subspace.coefficients(pixels[good])
        return HarmonicLight(coefficients if ambient else np.concatenate([[0.0], coefficients]))

    def _portrait(self, name: str, template: Template) -> Portrait:
        """Return a portrait that takes its pictures from the rows of whom it shows, wherever they have moved to."""

        def pictures() -> Floats:
            return np.stack([self.frame.picture(row) for row in self.subspace(name).rows])

        return Portrait(template, pictures, self.frame.mask)
