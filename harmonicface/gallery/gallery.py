"""Gallery: enrol people, then ask whose face a photograph shows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery import answers
from harmonicface.gallery.calibration import Calibration, calibration
from harmonicface.gallery.keeping import Keeping
from harmonicface.gallery.match import Candidate, Match, SearchScores


class Gallery(Keeping):
    """People, each as the subspace of her pictures and a template of her looks, in one frame of pixels.

    A gallery made so is in memory, until it is saved; one made by `Gallery.create` or opened from a folder keeps
    everything there. Photographs are searched for in two stages. The first is the plain projection of linear
    intensities, the same for every model: its answers are exactly those of a scan of everybody, from a thousand people
    on without reading them all (`index`). The second, of the default model, looks at the first one's shortlist.

    Parameters
    ----------
    model
        "default": a plain projection finds a shortlist, on which everybody's local patterns are compared with the
        photograph's, and everybody is lit as the photograph is and compared again (`second_look`); it bears light
        from the side with its cast shadows, shifts by up to 4 of 96 rows, noise and compression. If nobody is named,
        people are looked for displaced by up to 10 of 96 rows, turned or grown by up to 10 degrees or percent, and the
        photograph is compared once more as seen from there (`registered_look`). Or a projection alone, by what spans
        the pictures of a Surface: "harmonic9" (nine images), "harmonic_shadowed", "ambient4", "linear3",
        "nine_points_simulated", "pca3", "pca5" and "pca_auto" (analytic principal components under lamps in front), or
        "auto": as few of these as natural light takes of each person (`choose_model`).
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

    def __repr__(self) -> str:
        known = self._people.known_frame
        frame = "no frame yet" if known is None else "{} x {} pixels".format(*known.shape)
        return f"<Gallery of {len(self)} people, {frame}, model {self.model}>"

    def match(self, photo: ArrayLike, top: int = 5, mask: ArrayLike | None = None, explain: bool = False) -> Match:
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
        explain
            Whether `Match.search` says how many people each stage of the search excluded.

        Returns
        -------
        Match
            `.name` is None for somebody unknown. With the default model: when the first score is below the threshold,
            at rest and registered, or when the photograph has no detail to compare: darkness, a wall, a burnt-out
            picture. With the others: when the nearest person is farther than the threshold and the next nearly as near,
            or when nobody explains three quarters of the photograph's energy.

        Raises
        ------
        HarmonicFaceError
            An empty gallery, another shape, NaN or infinity, more negative than positive intensities, fewer than 36
            good pixels; except with the default model, a photograph that is all 0.
        """
        count = _validate.at_least(top, 1, "top")
        return self._answer(answers.stage_one(self._people, self._people.asked(photo, mask), count, self), explain)

    def match_many(self, photos: Iterable[ArrayLike], top: int = 5, explain: bool = False) -> list[Match]:
        """Match several photographs: the answers of `match`, by fewer passes over the people.

        Parameters
        ----------
        photos
            Each as for `match`.
        top, explain
            As for `match`.

        Raises
        ------
        HarmonicFaceError
            As `match`.
        """
        count = _validate.at_least(top, 1, "top")
        asked = [self._people.asked(photo, None) for photo in photos]
        return [self._answer(one, explain) for one in answers.stage_one_of_many(self._people, asked, count, self)]

    def within(self, photo: ArrayLike, distance: float, mask: ArrayLike | None = None) -> tuple[Candidate, ...]:
        """Return everybody within a distance of a photograph, nearest first, by stage one alone.

        Parameters
        ----------
        photo, mask
            As for `match`.
        distance
            0 to 1: the sine of the angle between the photograph and a person's pictures, on linear intensities.

        Raises
        ------
        HarmonicFaceError
            As `match`; a photograph that is all 0, another distance.

        Examples
        --------
        >>> import harmonicface as hf
        >>> gallery = hf.Gallery("harmonic9")
        >>> gallery.enroll("ada", hf.synthetic_person(1, 24))
        >>> photo = hf.render(hf.synthetic_person(1, 24), hf.lights.natural(0))
        >>> [candidate.name for candidate in gallery.within(photo, 0.2)]
        ['ada']
        """
        furthest = _validate.fraction(distance, "distance")
        return answers.within(self._people, self._people.asked(photo, mask), furthest)

    def _answer(self, question: answers.Question, explain: bool) -> Match:
        """Return a match from what stage one found."""
        match = (answers.by_second_look if self.by_score else answers.by_projection)(self._people, question, self)
        return replace(match, search=question.search(self._people)) if explain else match

    def search_scores(
        self, photo: ArrayLike, mask: ArrayLike | None = None, among: Sequence[str] | None = None
    ) -> SearchScores:
        """Compare a photograph with everybody, without a shortlist and without a decision; `match` explains the rest.

        People are compared where they are, up to the small shifts of a second look. `match` looks for them elsewhere if
        nobody reaches the threshold; it charges its scores so that strangers reach it no more often for that.

        Parameters
        ----------
        photo, mask
            As for `match`.
        among
            Names of whom to compare with, as if nobody else were enrolled; everybody by default.

        Raises
        ------
        HarmonicFaceError
            As `match`; nobody to compare with, somebody twice, or somebody who is not in the gallery.
        """
        asked = self._people.asked(photo, mask)
        names = self.names if among is None else tuple(among)
        if not names:
            raise HarmonicFaceError("among: expected at least one name, got none")
        if len(set(names)) < len(names):
            raise HarmonicFaceError(f"among: expected each name once, got {len(names)} of {len(set(names))} people")
        chosen = range(len(self)) if among is None else [self._people.place(name) for name in names]
        return (answers.scores_by_second_look if self.by_score else answers.scores_by_projection)(
            self._people, asked, names, chosen
        )

    def calibrate(
        self, fpir: float = 0.01, photographs: Sequence[ArrayLike] | None = None, names: Sequence[str] | None = None
    ) -> Calibration:
        """Set the threshold so that a search by a stranger names somebody at a rate, and say what that rests on.

        Strangers are the enrolled people themselves, each searched for without herself in the gallery, by her
        photographs or renderings as the gallery keeps them; or the people on given photographs. How high others will
        score is predicted from these comparisons (`Strangers`), and no search of these reaches the threshold more
        often than asked. One threshold serves everybody; it holds for a gallery of this size, so calibrate again when
        it has grown. With a model without patterns the threshold alone decides from then on (`margin` is infinite).
        Of a gallery in a folder, `save()` keeps it there.

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
        if not self.by_score:
            self.margin = np.inf
        return found
