"""The people of a gallery, wherever they are kept: everybody's rows, template and source, in one frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.album import Album
from harmonicface.gallery.enrolled.enrolment import MOST_ROWS, WITH_GEOMETRY, Enrolment, Model
from harmonicface.gallery.enrolled.portrait import Portrait
from harmonicface.gallery.enrolled.promised import Promise, enrolled
from harmonicface.gallery.enrolled.rows import RowBlock
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.index import LEARNED_AT, Index, sampled
from harmonicface.gallery.search.searcher import Searcher
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.grid import grid
from harmonicface.recognition.render_compare import Photograph
from harmonicface.recognition.subspace import Subspace

FEWEST_PIXELS = 4 * MOST_ROWS  # as many pixels as rows are explained by anybody


class People(ABC):
    """Everybody who is enrolled, by place in the order of enrolment.

    Parameters
    ----------
    frame
        The pixels that are compared; None until the first person brings them.
    """

    def __init__(self, frame: Frame | None = None) -> None:
        self.known_frame = frame
        self._album = Album(self._portrait)

    @abstractmethod
    def __len__(self) -> int: ...

    @property
    @abstractmethod
    def names(self) -> Sequence[str]:
        """Everybody's name."""

    @abstractmethod
    def find(self, name: str) -> int | None:
        """Return the place of a person; None if nobody has that name."""

    @abstractmethod
    def name(self, place: int) -> str:
        """Return a person's name."""

    @abstractmethod
    def enrolment(self, place: int) -> Enrolment:
        """Return what stands for a person."""

    @abstractmethod
    def blocks(self) -> Iterator[RowBlock]:
        """Yield everybody's rows, the people of each block one after the other."""

    @property
    @abstractmethod
    def dtype(self) -> str:
        """The type of the rows as they are kept, "float32" or "float16"."""

    @property
    @abstractmethod
    def rounding(self) -> float:
        """How far |Q y|^2 may be from 1 - distance^2 because stored rows are not quite orthonormal."""

    @property
    @abstractmethod
    def index(self) -> Index | None:
        """The shared basis that was learned of them, if one was."""

    @abstractmethod
    def learn(self, sample: int, seed: int) -> None:
        """Learn a shared basis from so many of the people, and sketch everybody in it."""

    @abstractmethod
    def searcher(self) -> Searcher | None:
        """Return who finds people without reading everybody; None as long as they are scanned."""

    @property
    @abstractmethod
    def nbytes(self) -> int:
        """Bytes of rows, templates and what else is kept of people."""

    @abstractmethod
    def add(self, people: Sequence[tuple[str, Enrolment]]) -> None:
        """Add people, at least one, whose names are new and different."""

    @abstractmethod
    def remove(self, names: Sequence[str]) -> None:
        """Take people out, all or none, each named once; raises if nobody has such a name."""

    @abstractmethod
    def rename(self, old: str, new: str) -> None:
        """Give a person another name, which is new; raises if nobody has the old one."""

    @property
    def frame(self) -> Frame:
        """The frame, once there is one."""
        assert self.known_frame is not None, "somebody is enrolled"
        return self.known_frame

    @property
    def pixels_of_grid(self) -> float:
        """How many pixels of a photograph a pixel of the grid is wide."""
        return self.frame.shape[0] / grid(self.frame.shape)[0]

    def place(self, name: str) -> int:
        """Return the place of a person.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        place = self.find(name) if isinstance(name, str) else None
        if place is None:
            raise HarmonicFaceError(f"name: expected somebody in the gallery, got {name!r:.80}, who is not")
        return place

    def subspace(self, place: int) -> Subspace:
        """Return a person's subspace."""
        return self.enrolment(place).subspace

    def source(self, place: int) -> str:
        """Return what a person was enrolled from."""
        return self.enrolment(place).source

    def portrait(self, place: int) -> Portrait:
        """Return what the default model keeps of a person; those that were asked for last stay in memory."""
        return self._album[place]

    def enrolments(self, sources: Iterable[Promise], model: Model) -> Iterator[Enrolment]:
        """Yield what stands for people, in their order."""
        frame = self.known_frame
        for source in sources:
            found = enrolled(source, frame, model)
            frame = found.frame
            yield found

    def learned(self, sample: int, seed: int) -> Index:
        """Return a shared basis that is learned from so many of the people, or all if they are fewer."""
        return Index.learned([self.subspace(place) for place in sampled(len(self), sample, seed)], seed)

    @property
    def room(self) -> int | None:
        """How many people may be added before a shared basis is learned; None if that is not ahead."""
        due = self._due
        return None if due is None or len(self) >= due else due - len(self)

    def learn_in_time(self) -> None:
        """Learn a shared basis when there are enough people for the first, or for a better one."""
        due = self._due
        if due is not None and len(self) >= due:
            self.learn(due, 0)

    @property
    def _due(self) -> int | None:
        """At how many people a basis is learned next; None if one was learned of another sample, as somebody asked."""
        learned = 0 if self.index is None else self.index.sample
        return dict(pairwise((0, *LEARNED_AT))).get(learned)

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
        place: int,
        pixels: Floats,
        good: NDArray[np.bool_],
        shift: tuple[float, float] = (0.0, 0.0),
        ambient: bool = True,
    ) -> HarmonicLight | None:
        """Return the light of a photograph, if this person was enrolled with geometry, where she was found.

        Without `ambient`, her pictures are those of linear3, which has none for ambient light.
        """
        enrolled = self.enrolment(place)
        if enrolled.source not in WITH_GEOMETRY:
            return None
        if any(shift):
            pixels, good = self.frame.moved(pixels, good, (-round(shift[0]), -round(shift[1])))
        subspace = enrolled.subspace
        if not subspace.rows[:, good].any():
            return None
        if not good.all():
            subspace = subspace.restrict(good)
        coefficients = subspace.coefficients(pixels[good])
        return HarmonicLight(coefficients if ambient else np.concatenate([[0.0], coefficients]))

    def _portrait(self, place: int) -> Portrait:
        """Return a portrait that puts a person's rows on the grid when it is asked for them."""
        template = self.enrolment(place).template
        assert template is not None, "the model keeps templates"

        def pictures() -> Floats:
            return np.stack([self.frame.picture(row) for row in self.subspace(place).rows])

        return Portrait(template, pictures, self.frame.mask)
