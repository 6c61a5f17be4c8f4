"""Gallery: enrol people, then ask whose face a photograph shows."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery import storage
from harmonicface.gallery.calibration import Calibration, calibration
from harmonicface.gallery.enrolment import MOST_ROWS, WITH_GEOMETRY, Model, enrolment_of
from harmonicface.gallery.explanation import Evidence, named, unknown
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.match import INTENSITIES, PATTERNS, Candidate, Match, SearchScores
from harmonicface.gallery.names import checked_name
from harmonicface.gallery.portrait import Portrait
from harmonicface.gallery.ranking import rank, shortlist
from harmonicface.gallery.rows import StackedRows
from harmonicface.gallery.second_look import judged, second_look
from harmonicface.gallery.storage import DEFAULT_MODEL
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.grid import grid
from harmonicface.recognition.models import SUBSPACE_MODELS, harmonic9
from harmonicface.recognition.patterns import Template
from harmonicface.recognition.render_compare import Photograph
from harmonicface.recognition.subspace import unit_photo
from harmonicface.surfaces.surface import Surface

FEWEST_PIXELS = 4 * MOST_ROWS  # as many pixels as rows are explained by anybody
FARTHEST = 0.5  # beyond it a quarter of the photograph's energy is nobody's
DEFAULT_THRESHOLD = 0.1
DEFAULT_SCORE = 6.0
DEFAULT_MARGIN = 4 / 3
DEFAULT_SHORTLIST = 50


class Gallery:
    """People, each as the subspace of her pictures and a template of her looks, in one frame of pixels.

    Parameters
    ----------
    model
        "default": a plain projection finds a shortlist, on which everybody's local patterns are compared with the
        photograph's, and everybody is lit as the photograph is and compared again (`second_look`); it bears light
        from the side with its cast shadows, shifts by up to 4 of 96 rows, noise and compression. Or a projection
        alone, by what spans the pictures of a Surface: "harmonic9" (nine images), "harmonic_shadowed", "ambient4",
        "linear3".
    mask
        (h, w) booleans: the pixels that are compared. By default all pixels of the first person enrolled. Where
        photographs have a background, leave it out of the mask; outside a person's own mask her images are 0.
    threshold
        Of the default model: the score from which the first candidate is named, above 0; the score says by how many
        deviations she is more alike than strangers are. In a gallery of one or two, who have no strangers to be
        compared with, she must also be alike by herself. Of the others: a person at most so far from the photograph
        is named whatever the others are, 0 to 1; 0.1 is what the nine images themselves leave over of a matte head
        under one lamp, the hardest light (8.8 % on a sphere).
    margin
        Of the models without patterns: a person farther than the threshold, up to 0.5, is named if she is so many
        times nearer than the next, at least 1; infinity leaves the threshold alone. Distances grow together as light
        gets harder, so their ratio tells the known from the unknown where no single distance can. With 4/3, on Yale B
        up to 51 degrees, of 100 strangers 0.3 are named by galleries of ten people, 1.8 of five, 4.9 of three, 15 of
        two; of 100 enrolled people 2 to 7 are refused (`scripts/unknown_people.py`). Somebody enrolled under two
        names is named by the threshold only.
    shortlist
        Of the default model: at how many people it takes the second look, at least 2; what a look costs does not
        depend on how many people there are beside them.

    Raises
    ------
    HarmonicFaceError
        An unknown model, an empty mask, a threshold outside its range, a margin below 1, a shortlist below 2.

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
        model: str = DEFAULT_MODEL,
        mask: ArrayLike | None = None,
        threshold: float | None = None,
        margin: float = DEFAULT_MARGIN,
        shortlist: int = DEFAULT_SHORTLIST,
    ) -> None:
        if model not in (DEFAULT_MODEL, *SUBSPACE_MODELS):
            expected = f"one of {', '.join((DEFAULT_MODEL, *SUBSPACE_MODELS))}"
            raise HarmonicFaceError(f"model: expected {expected}, got {model!r}")
        self.model = model
        self._looks = model == DEFAULT_MODEL
        self._model = Model(harmonic9, 1, True) if self._looks else Model(SUBSPACE_MODELS[model])
        self.threshold = (DEFAULT_SCORE if self._looks else DEFAULT_THRESHOLD) if threshold is None else threshold
        self.margin = margin
        self.shortlist = _validate.at_least(shortlist, 2, "shortlist")
        self._frame = None if mask is None else Frame.of(mask)
        self._rows: StackedRows | None = None
        self._portraits: list[Portrait] = []  # of everybody, with the default model
        self._sources: dict[str, str] = {}  # from what each person was enrolled

    @property
    def threshold(self) -> float:
        """The score from which the first candidate is named; without patterns, the distance up to which she is."""
        return self._threshold

    @threshold.setter
    def threshold(self, value: float) -> None:
        check = _validate.positive if self._looks else _validate.fraction
        self._threshold = check(value, "threshold")

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
        """Memory of a person, on average: her rows, and of the default model her template and pictures on the grid."""
        if self._rows is None or not len(self):
            return 0.0
        return (self._rows.array.nbytes + sum(portrait.nbytes for portrait in self._portraits)) / len(self)

    def __len__(self) -> int:
        return len(self._sources)

    def __contains__(self, name: object) -> bool:
        return name in self._sources

    def __repr__(self) -> str:
        frame = "no frame yet" if self._frame is None else "{} x {} pixels".format(*self._frame.shape)
        return f"<Gallery of {len(self)} people, {frame}, model {self.model}>"

    def enroll(self, name: str, source: Surface | ArrayLike, lights: ArrayLike | None = None) -> None:
        """Add a person.

        Parameters
        ----------
        name
            1 to 200 printable characters, not yet in the gallery.
        source
            A Surface of the gallery's shape. Or (n, h, w) photographs: with lights, n >= 3, they are registered to
            each other and their stereo is the Surface; without, the span of the photographs (its nine strongest
            directions) stands for her. The default model takes any number of them, and a single one, (h, w); the
            others need three under different lights.
        lights
            (n, 3) directions from the person to the light of each photograph (x right, y up, z toward the camera),
            times its strength; intensities are then from 0 to 1.

        Raises
        ------
        HarmonicFaceError
            A name that is taken or does not print, another shape than the gallery's, too few different photographs,
            negative ones, NaN, nothing inside the gallery's mask, photographs that stereo cannot use; for the default
            model fewer than 24 pixels a side.
        """
        if checked_name(name) in self._sources:
            raise HarmonicFaceError(f"name: expected one that is not in the gallery yet, got {name!r}, who is")
        enrolled = enrolment_of(source, self._frame, self._model, lights)
        self._frame = enrolled.frame
        if self._rows is None:
            self._rows = StackedRows(np.empty((0, enrolled.frame.pixels), np.float32))
        self._rows.append(enrolled.subspace)
        self._sources[name] = enrolled.source
        if enrolled.template is not None:
            self._portraits.append(self._portrait(name, enrolled.template))

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
        del self._portraits[index : index + 1]

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
            `.name` is None for somebody unknown. With the default model: when the first score is below the threshold,
            or when the photograph has no detail to compare: darkness, a wall, a burnt-out picture. With the others:
            when the nearest person is farther than the threshold and the next nearly as near, or when nobody explains
            three quarters of the photograph's energy.

        Raises
        ------
        HarmonicFaceError
            An empty gallery, another shape, NaN or infinity, more negative than positive intensities, fewer than 36
            good pixels; except with the default model, a photograph that is all 0.
        """
        count = _validate.at_least(top, 1, "top")
        pixels, good = self._asked(photo, mask)
        return self._looked(pixels, good, count) if self._looks else self._projected(pixels, good, count)

    def search_scores(
        self, photo: ArrayLike, mask: ArrayLike | None = None, among: Sequence[str] | None = None
    ) -> SearchScores:
        """Compare a photograph with everybody, without a shortlist and without a decision; `match` explains the rest.

        Parameters
        ----------
        photo, mask
            As for `match`.
        among
            Names of whom to compare with, as if nobody else were enrolled; everybody by default.

        Raises
        ------
        HarmonicFaceError
            As `match`; nobody to compare with, or somebody who is not in the gallery.
        """
        pixels, good = self._asked(photo, mask)
        names = self.names if among is None else tuple(among)
        if not names:
            raise HarmonicFaceError("among: expected at least one name, got none")
        chosen = range(len(self)) if among is None else [self._index(name) for name in names]
        if not self._looks:
            ranked = rank(self._stack, unit_photo(pixels[good], int(good.sum())), good, len(self))
            distances = np.array([distance for distance, _ in sorted(ranked, key=lambda one: one[1])])[chosen]
            return SearchScores(names, -distances, distances, np.zeros((len(names), 2)))
        look = second_look(self._photograph(pixels, good), [self._portraits[index] for index in chosen])
        verdict = judged(look, self._pixels_of_grid())
        return SearchScores(names, verdict.scores, verdict.distances, verdict.shifts, verdict.blocks)

    def calibrate(
        self, fpir: float = 0.01, photographs: Sequence[ArrayLike] | None = None, names: Sequence[str] | None = None
    ) -> Calibration:
        """Set the threshold so that a search by a stranger names somebody at a rate, and say what that rests on.

        Strangers are the enrolled people themselves, each searched for without herself in the gallery, by her
        photographs or renderings as the gallery keeps them; or the people on given photographs. How high others will
        score is predicted from these comparisons (`Strangers`), and no search of these reaches the threshold more
        often than asked. One threshold serves everybody; it holds for a gallery of this size, so calibrate again when
        it has grown. With a model without patterns the threshold alone decides from then on (`margin` is infinite).

        Parameters
        ----------
        fpir
            Above 0 and below 1, per search, whatever the size of the gallery.
        photographs
            Each (h, w) or (h, w, 3), as for `match`: of people who are not enrolled, or of enrolled people, who are
            then left out of their own searches. At least two people. Photographs under the light of later searches
            tell most.
        names
            Of who is in each photograph; enrolled people by their names. Without it each shows another stranger.

        Raises
        ------
        HarmonicFaceError
            Fewer than three people without photographs or two with them, another rate, photographs that `match`
            refuses, names that do not go with photographs.

        Examples
        --------
        >>> import harmonicface as hf
        >>> gallery = hf.Gallery()
        >>> for number in range(4):
        ...     gallery.enroll(str(number), hf.synthetic_person(number, 48))
        >>> found = gallery.calibrate(fpir=0.01)
        >>> gallery.threshold == found.threshold, found.searches, found.strangers
        (True, 20, 4)
        """
        found = calibration(self, fpir, photographs, names)
        self.threshold = found.threshold
        if not self._looks:
            self.margin = np.inf
        return found

    @property
    def by_score(self) -> bool:
        """Whether the threshold is a score, larger for more alike, rather than a distance."""
        return self._looks

    def pictures_of(self, name: str) -> Floats:
        """Return the pictures that stand for a person, (k, h, w), 0 outside the gallery's mask.

        Her harmonic images if she was enrolled with geometry, otherwise her photographs, as far as the nine strongest
        directions of their span go.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        subspace = self._stack.subspace(self._index(name))
        assert self._frame is not None
        images = np.linalg.pinv(subspace.to_coefficients) @ subspace.rows
        return np.stack([self._frame.picture(image) for image in images.astype(np.float32)])

    def source_of(self, name: str) -> str:
        """Return what a person was enrolled from, as in `Candidate`.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        self._index(name)
        return self._sources[name]

    def _asked(self, photo: ArrayLike, mask: ArrayLike | None) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the compared pixels of a photograph, and which of them are good."""
        if self._frame is None or not len(self):
            raise HarmonicFaceError("match: expected a gallery with somebody in it, got an empty one")
        pixels = self._frame.take(photo, "photo")
        good = np.ones(len(pixels), np.bool_)
        if mask is not None:
            shared = self._frame.mask & _validate.mask(mask, "mask", self._frame.shape)
            good = _validate.mask(shared, "mask inside the gallery's mask", self._frame.shape)[self._frame.mask]
        if good.sum() < FEWEST_PIXELS:
            raise HarmonicFaceError(f"match: expected at least {FEWEST_PIXELS} good pixels, got {good.sum()}")
        return pixels, good

    def _projected(self, pixels: Floats, good: NDArray[np.bool_], count: int) -> Match:
        """Match by plain projection."""
        ranked = rank(self._stack, unit_photo(pixels[good], int(good.sum())), good, max(count, 2))
        distance, best = ranked[0]
        margin = _ratio(ranked[1][0], distance) if len(ranked) > 1 else 1.0
        names, known = self.names, self.is_known(distance, margin)
        reason = None if known else "nobody is near, or clearly nearer than the next"
        return Match(
            name=names[best] if known else None,
            distance=distance,
            margin=margin,
            light=self._light(best, pixels, good),
            candidates=tuple(
                Candidate(names[index], value, source=self._sources[names[index]]) for value, index in ranked[:count]
            ),
            domain=INTENSITIES,
            reason=reason,
            evidence=self._evidence(best, pixels, good, (0.0, 0.0), distance, reason),
        )

    def _looked(self, pixels: Floats, good: NDArray[np.bool_], count: int) -> Match:
        """Match by a second look at a shortlist."""
        chosen = shortlist(self._stack, pixels[good].astype(np.float64), good, max(count, self.shortlist))
        look = second_look(self._photograph(pixels, good), [self._portraits[index] for index in chosen])
        verdict = judged(look, self._pixels_of_grid())
        names, order = self.names, verdict.order[: max(count, 2)]
        candidates = [
            Candidate(
                name=names[chosen[place]],
                distance=float(verdict.distances[place]),
                score=float(verdict.scores[place]),
                shift=(float(verdict.shifts[place, 0]), float(verdict.shifts[place, 1])),
                source=self._sources[names[chosen[place]]],
            )
            for place in order
        ]
        first = candidates[0]
        reason = verdict.unknown(self.threshold)
        return Match(
            name=first.name if reason is None else None,
            distance=first.distance,
            margin=_ratio(candidates[1].distance, first.distance) if len(candidates) > 1 else 1.0,
            light=self._light(int(chosen[order[0]]), pixels, good, first.shift) if pixels[good].any() else None,
            candidates=tuple(candidates[:count]),
            domain=PATTERNS,
            reason=reason,
            evidence=self._evidence(int(chosen[order[0]]), pixels, good, first.shift, first.score or 0.0, reason),
        )

    def _evidence(
        self,
        index: int,
        pixels: Floats,
        good: NDArray[np.bool_],
        shift: tuple[float, float],
        value: float,
        reason: str | None,
    ) -> Evidence:
        """Return what `Match.explain` needs."""
        assert self._frame is not None
        name = self.names[index]
        said = (name, None if self._looks and len(self) == 1 else value, self.threshold, self._looks)
        return Evidence(
            frame=self._frame,
            pixels=pixels,
            good=good,
            subspace=self._stack.subspace(index),
            shift=(round(shift[0]), round(shift[1])),
            geometry=self._sources[name] in WITH_GEOMETRY,
            ambient=self.model != "linear3",
            reason=named(*said) if reason is None else unknown(*said, reason),
        )

    def _photograph(self, pixels: Floats, good: NDArray[np.bool_]) -> Photograph:
        """Return a photograph for the second look."""
        assert self._frame is not None
        seen = self._frame.mask.copy()
        seen[self._frame.mask] = good
        return Photograph(self._frame.picture(pixels), seen)

    def _portrait(self, name: str, template: Template) -> Portrait:
        """Return a portrait that takes its pictures from the rows of whom it shows, wherever they have moved to."""
        frame = self._frame
        assert frame is not None

        def pictures() -> Floats:
            return np.stack([frame.picture(row) for row in self._stack.subspace(self._index(name)).rows])

        return Portrait(template, pictures, frame.mask)

    def _pixels_of_grid(self) -> float:
        """Return how many pixels of a photograph a pixel of the grid is wide."""
        assert self._frame is not None
        return self._frame.shape[0] / grid(self._frame.shape)[0]

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
                self.model,
                self.threshold,
                self.margin,
                self._frame.mask,
                self._stack,
                dict(self._sources),
                [portrait.template for portrait in self._portraits],
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
        gallery._portraits = [gallery._portrait(*one) for one in zip(gallery.names, contents.templates, strict=False)]
        return gallery

    def _light(
        self, index: int, pixels: Floats, good: NDArray[np.bool_], shift: tuple[float, float] = (0.0, 0.0)
    ) -> HarmonicLight | None:
        """Return the light of a photograph, if this person was enrolled with geometry, where she was found."""
        if self._sources[self.names[index]] not in WITH_GEOMETRY:
            return None
        assert self._frame is not None
        if any(shift):
            pixels, good = self._frame.moved(pixels, good, (-round(shift[0]), -round(shift[1])))
        subspace = self._stack.subspace(index)
        if not good.all():
            subspace = subspace.restrict(good)
        coefficients = subspace.coefficients(pixels[good])
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
