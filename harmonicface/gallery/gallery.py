"""Gallery: enrol people, then ask whose face a photograph shows."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery import storage
from harmonicface.gallery.enrolment import MOST_ROWS, enrolment_of
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.match import Candidate, Match
from harmonicface.gallery.names import checked_name
from harmonicface.gallery.ranking import rank
from harmonicface.gallery.rows import StackedRows
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.models import subspace_model
from harmonicface.recognition.subspace import unit_photo
from harmonicface.surfaces.surface import Surface

FEWEST_PIXELS = 4 * MOST_ROWS  # as many pixels as rows are explained by anybody
FARTHEST = 0.5  # beyond it a quarter of the photograph's energy is nobody's
DEFAULT_THRESHOLD = 0.1
DEFAULT_MARGIN = 4 / 3


class Gallery:
    """People, each as the subspace of her pictures, in one frame of pixels.

    Parameters
    ----------
    model
        What spans the pictures of a Surface: "harmonic9" (nine images, the default), "ambient4" or "linear3".
    mask
        (h, w) booleans: the pixels that are compared. By default all pixels of the first person enrolled. Where
        photographs have a background, leave it out of the mask; outside a person's own mask her images are 0.
    threshold
        A person at most so far from the photograph is named whatever the others are, 0 to 1. 0.1 is what the nine
        images themselves leave over of a matte head under one lamp, the hardest light (8.8 % on a sphere).
    margin
        A person farther than that, up to 0.5, is named if she is so many times nearer than the next, at least 1;
        infinity leaves the threshold alone. Distances grow together as light gets harder, so their ratio tells the
        known from the unknown where no single distance can. With 4/3, on Yale B up to 51 degrees, of 100 strangers
        0.3 are named by galleries of ten people, 1.8 of five, 4.9 of three, 15 of two; of 100 enrolled people 2 to 7
        are refused (`scripts/unknown_people.py`). Somebody enrolled under two names is named by the threshold only.

    Raises
    ------
    HarmonicFaceError
        An unknown model, an empty mask, a threshold outside 0 to 1, a margin below 1.

    Examples
    --------
    >>> import harmonicface as hf
    >>> gallery = hf.Gallery()
    >>> for number, name in enumerate(["ada", "emmy", "sofia"]):
    ...     gallery.enroll(name, hf.synthetic_person(number))
    >>> photo = hf.render(hf.synthetic_person(1), hf.lights.directional([1, 1, 1]))
    >>> gallery.match(photo).name
    'emmy'
    """

    def __init__(
        self,
        model: str = "harmonic9",
        mask: ArrayLike | None = None,
        threshold: float = DEFAULT_THRESHOLD,
        margin: float = DEFAULT_MARGIN,
    ) -> None:
        self._pictures = subspace_model(model)
        self.model = model
        self.threshold = threshold
        self.margin = margin
        self._frame = None if mask is None else Frame.of(mask)
        self._rows: StackedRows | None = None
        self._sources: dict[str, str] = {}  # from what each person was enrolled: "surface" or "photographs"

    @property
    def threshold(self) -> float:
        """The distance up to which the nearest person is named, whatever the others are."""
        return self._threshold

    @threshold.setter
    def threshold(self, value: float) -> None:
        self._threshold = _validate.fraction(value, "threshold")

    @property
    def margin(self) -> float:
        """The ratio of the second distance to the first from which the nearest person is named."""
        return self._margin

    @margin.setter
    def margin(self, value: float) -> None:
        margin = np.inf if value == np.inf else _validate.positive(value, "margin")
        if margin < 1:
            raise HarmonicFaceError(f"margin: expected a number of at least 1, got {value}")
        self._margin = margin

    @property
    def mask(self) -> NDArray[np.bool_] | None:
        """The pixels that are compared; None before anybody is enrolled and without a mask given."""
        return None if self._frame is None else self._frame.mask.copy()

    @property
    def names(self) -> tuple[str, ...]:
        """Everybody, in the order of enrolment."""
        return tuple(self._sources)

    @property
    def bytes_per_person(self) -> float:
        """Memory of a person's rows, on average."""
        return 0.0 if self._rows is None or not len(self) else self._rows.array.nbytes / len(self)

    def __len__(self) -> int:
        return len(self._sources)

    def __contains__(self, name: object) -> bool:
        return name in self._sources

    def __repr__(self) -> str:
        frame = "no frame yet" if self._frame is None else "{} x {} pixels".format(*self._frame.shape)
        return f"<Gallery of {len(self)} people, {frame}, model {self.model}>"

    def enroll(self, name: str, source: Surface | ArrayLike) -> None:
        """Add a person.

        Parameters
        ----------
        name
            1 to 200 printable characters, not yet in the gallery.
        source
            A Surface of the gallery's shape, or (n, h, w) photographs under n >= 3 different lights, whose span (its
            nine strongest directions) then stands for her.

        Raises
        ------
        HarmonicFaceError
            A name that is taken or does not print, another shape than the gallery's, fewer than three different
            photographs, negative ones, NaN, nothing inside the gallery's mask.
        """
        if checked_name(name) in self._sources:
            raise HarmonicFaceError(f"name: expected one that is not in the gallery yet, got {name!r}, who is")
        enrolled = enrolment_of(source, self._frame, self._pictures)
        self._frame = enrolled.frame
        if self._rows is None:
            self._rows = StackedRows(np.empty((0, enrolled.frame.pixels), np.float32))
        self._rows.append(enrolled.subspace)
        self._sources[name] = enrolled.source

    def remove(self, name: str) -> None:
        """Take a person out.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        index = self._index(name)
        self._stack.remove(index)
        del self._sources[name]

    def match(self, photo: ArrayLike, top: int = 5, mask: ArrayLike | None = None) -> Match:
        """Rank the people by how well they explain a photograph under some light.

        Parameters
        ----------
        photo
            (h, w) or (h, w, 3) linear intensities of the gallery's shape, in any unit; colour is taken as luminance.
        top
            How many candidates to return, at least 1.
        mask
            (h, w) booleans, false where the photograph is bad: burnt out, hidden, not the face. Every person is then
            projected through this mask, which takes longer.

        Returns
        -------
        Match
            `.name` is None when the nearest person is farther than the threshold and the next nearly as near, or when
            nobody explains three quarters of the photograph's energy.

        Raises
        ------
        HarmonicFaceError
            An empty gallery, another shape, NaN or infinity, a photograph that is all 0 or negative, fewer than 36
            good pixels.
        """
        count = _validate.at_least(top, 1, "top")
        if self._frame is None or not len(self):
            raise HarmonicFaceError("match: expected a gallery with somebody in it, got an empty one")
        pixels = self._frame.take(photo, "photo")
        good = np.ones(len(pixels), np.bool_)
        if mask is not None:
            shared = self._frame.mask & _validate.mask(mask, "mask", self._frame.shape)
            good = _validate.mask(shared, "mask inside the gallery's mask", self._frame.shape)[self._frame.mask]
        if good.sum() < FEWEST_PIXELS:
            raise HarmonicFaceError(f"match: expected at least {FEWEST_PIXELS} good pixels, got {good.sum()}")
        ranked = rank(self._stack, unit_photo(pixels[good], int(good.sum())), good, max(count, 2))
        distance, best = ranked[0]
        margin = _ratio(ranked[1][0], distance) if len(ranked) > 1 else 1.0
        names = self.names
        return Match(
            name=names[best] if self.is_known(distance, margin) else None,
            distance=distance,
            margin=margin,
            light=self._light(best, pixels[good], good),
            candidates=tuple(Candidate(names[index], value) for value, index in ranked[:count]),
        )

    def is_known(self, distance: float, margin: float) -> bool:
        """Say whether the nearest person is named: surely near, or clearly nearer than the next."""
        return distance <= self.threshold or (margin >= self.margin and distance <= FARTHEST)

    def reconstruct(self, name: str, photo: ArrayLike) -> Floats:
        """Return the picture of a person that is nearest to a photograph, (h, w), 0 outside the gallery's mask.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name, another shape, NaN or infinity.
        """
        index = self._index(name)
        assert self._frame is not None
        return self._frame.picture(self._stack.subspace(index).nearest(self._frame.take(photo, "photo")))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the gallery to one file, replaced whole or not at all.

        Raises
        ------
        HarmonicFaceError
            Nobody is in it, or the file cannot be written.
        """
        if self._frame is None or not len(self):
            raise HarmonicFaceError("save: expected a gallery with somebody in it, got an empty one")
        storage.write(
            path,
            storage.Contents(
                self.model, self.threshold, self.margin, self._frame.mask, self._stack, dict(self._sources)
            ),
        )

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Gallery:
        """Read what `save` wrote.

        Raises
        ------
        HarmonicFaceError
            The file is missing, damaged, of another kind or of a version that this one does not know.
        """
        contents = storage.read(path)
        gallery = cls(contents.model, contents.mask, contents.threshold, contents.margin)
        gallery._rows = contents.rows
        gallery._sources = dict(contents.sources)
        return gallery

    def _light(self, index: int, pixels: Floats, good: NDArray[np.bool_]) -> HarmonicLight | None:
        """Return the light of a photograph, if this person was enrolled with geometry."""
        if self._sources[self.names[index]] != "surface":
            return None
        subspace = self._stack.subspace(index)
        if not good.all():
            subspace = subspace.restrict(good)
        coefficients = subspace.coefficients(pixels)
        if self.model == "linear3":  # it has no picture for ambient light
            coefficients = np.concatenate([[0.0], coefficients])
        return HarmonicLight(coefficients)

    @property
    def _stack(self) -> StackedRows:
        assert self._rows is not None, "somebody is enrolled"
        return self._rows

    def _index(self, name: str) -> int:
        if name not in self._sources:
            raise HarmonicFaceError(f"name: expected somebody in the gallery, got {name!r}, who is not")
        return self.names.index(name)


def _ratio(second: float, first: float) -> float:
    """Return second over first, for distances that may both be zero."""
    if first == 0:
        return 1.0 if second == 0 else np.inf
    return second / first
