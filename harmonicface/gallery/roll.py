"""Roll: who is in a gallery, and how people come in and go."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.enrolment import Enrolment, Model, enrolment_of
from harmonicface.gallery.enrolled.people import People
from harmonicface.gallery.enrolled.promised import Promise
from harmonicface.gallery.names import checked_name
from harmonicface.gallery.search.index import LEARNED_AT
from harmonicface.surfaces.surface import Surface

PIECE = 1 << 27  # bytes of people who are written together


class Roll:
    """Who is enrolled.

    Parameters
    ----------
    enrolled_as
        What is made of each person.
    people
        Who they are.
    """

    def __init__(self, enrolled_as: Model, people: People) -> None:
        self._model = enrolled_as
        self._people = people

    @property
    def mask(self) -> NDArray[np.bool_] | None:
        """The pixels that are compared; None before anybody is enrolled and without a mask given."""
        frame = self._people.known_frame
        return None if frame is None else frame.mask.copy()

    @property
    def names(self) -> tuple[str, ...]:
        """Everybody, in the order of enrolment."""
        return tuple(self._people.names)

    @property
    def bytes_per_person(self) -> float:
        """Bytes of a person, on average: her rows, and of the default model her template and pictures on the grid.

        Of a gallery in a folder, bytes on the disk.
        """
        return self._people.nbytes / len(self) if len(self) else 0.0

    def __len__(self) -> int:
        return len(self._people)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._people.find(name) is not None

    def enroll(self, name: str, source: Surface | ArrayLike, lights: ArrayLike | None = None) -> None:
        """Add a person.

        Parameters
        ----------
        name
            1 to 200 printable characters without slashes, not yet in the gallery.
        source
            A Surface of the gallery's shape. Or (n, h, w) photographs: with lights, n >= 3, they are registered to
            each other and their stereo is the Surface; without, the span of the photographs (its nine strongest
            directions) stands for her. The default model takes any number of them, registers those that show her at
            different places, and takes a single one, (h, w); the others need three under different lights,
            or one from which a prior of faces makes the most probable Surface (`exemplar`; not "harmonic_shadowed").
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
        self._refuse_known(checked_name(name))
        self._people.add([(name, enrolment_of(source, self._people.known_frame, self._model, lights))])

    def enroll_many(self, people: Iterable[tuple[str, Promise]], progress: Callable[[int], None] | None = None) -> int:
        """Add many people, in memory that does not grow with their number where the gallery is in a folder.

        They are written by the piece of 128 MB. Whoever came before one who is refused is enrolled. A gallery that was
        opened with the client of a cluster has its workers make people of sources, in order.

        Parameters
        ----------
        people
            Names and sources, as for `enroll`; a source may also be a file (of a mesh, seen from the front, points, a
            Surface or a photograph), or a function without arguments that returns a Surface or photographs.
        progress
            Is called with how many people have been made so far, after each.

        Returns
        -------
        int
            How many were added.

        Raises
        ------
        HarmonicFaceError
            As `enroll`, a file that cannot be read, or something else than pairs of a name and a source.

        Examples
        --------
        >>> import harmonicface as hf
        >>> gallery = hf.Gallery("harmonic9")
        >>> gallery.enroll_many((str(seed), hf.synthetic_person(seed, 24)) for seed in range(3))
        3
        """
        coming: deque[str] = deque()  # names of whom is being made
        piece: dict[str, Enrolment] = {}  # made, and still to be written
        done = nbytes = 0

        def sources() -> Iterator[Promise]:
            for name, source in _pairs(people):
                self._refuse_known(checked_name(name))
                if name in coming or name in piece:
                    raise HarmonicFaceError(f"name: expected everybody once, got {name!r} twice")
                coming.append(name)
                yield source

        try:
            for enrolled in self._people.enrolments(sources(), self._model):
                piece[coming.popleft()] = enrolled
                nbytes, done = nbytes + enrolled.nbytes, done + 1
                if progress is not None:
                    progress(done)
                if nbytes >= PIECE or len(piece) == self._people.room:
                    written, piece, nbytes = piece, {}, 0
                    self._people.add(list(written.items()))
        finally:
            if piece:
                self._people.add(list(piece.items()))
        return done

    def index(self, people: int = LEARNED_AT[-1], seed: int = 0) -> None:
        """Learn anew what a search without reading everybody needs, as happens by itself at 1,000 and at 4,000 people.

        A shared basis is learned from a sample of the people, and everybody is sketched in it. Answers are the same
        with any basis and with none. In a folder everything is written anew and switched to at once, which needs as
        much free space as it takes.

        Parameters
        ----------
        people
            How many the sample has, at least 1. Memory: about five times their rows.
        seed
            Of the sample and of a randomized factorization, at least 0.

        Raises
        ------
        HarmonicFaceError
            Nobody is in the gallery, or a full disk.
        """
        if not len(self):
            raise HarmonicFaceError("index: expected a gallery with somebody in it, got an empty one")
        self._people.learn(_validate.at_least(people, 1, "people"), _validate.at_least(seed, 0, "seed"))

    def remove(self, names: str | Iterable[str]) -> None:
        """Take a person out, or several: all or none.

        Raises
        ------
        HarmonicFaceError
            Nobody of such a name is in the gallery, the same name twice, or something else than names.
        """
        wanted = list(names) if isinstance(names, Iterable) and not isinstance(names, str) else [names]
        if not all(isinstance(name, str) for name in wanted):
            raise HarmonicFaceError(f"remove: expected names, got {_validate.describe(names)}")
        if len(set(wanted)) < len(wanted):
            raise HarmonicFaceError(f"remove: expected each name once, got {len(wanted)} of {len(set(wanted))} people")
        self._people.remove(wanted)

    def rename(self, old: str, new: str) -> None:
        """Give a person another name; she keeps her place in the order of enrolment.

        Raises
        ------
        HarmonicFaceError
            Nobody of the old name is in the gallery, or somebody of the new one; a new name that does not print.
        """
        if checked_name(new) != old:
            self._refuse_known(new)
        self._people.rename(old, new)

    def _refuse_known(self, name: str) -> None:
        if name in self:
            raise HarmonicFaceError(f"name: expected one that is not in the gallery yet, got {name!r}, who is")

    def pictures_of(self, name: str) -> Floats:
        """Return the pictures that stand for a person, (k, h, w), 0 outside the gallery's mask.

        Her harmonic images if she was enrolled with geometry, otherwise her photographs, as far as the nine strongest
        directions of their span go.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        subspace = self._people.subspace(self._people.place(name))
        images = np.linalg.pinv(subspace.to_coefficients) @ subspace.rows
        return np.stack([self._people.frame.picture(image) for image in images.astype(np.float32)])

    def source_of(self, name: str) -> str:
        """Return what a person was enrolled from, as in `Candidate`.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name is in the gallery.
        """
        return self._people.source(self._people.place(name))

    def reconstruct(self, name: str, photo: ArrayLike) -> Floats:
        """Return the picture of a person that is nearest to a photograph, (h, w), 0 outside the gallery's mask.

        Raises
        ------
        HarmonicFaceError
            Nobody of that name, another shape, NaN or infinity.
        """
        subspace, frame = self._people.subspace(self._people.place(name)), self._people.frame
        return frame.picture(subspace.nearest(frame.take(photo, "photo")))


def _pairs(people: Iterable[tuple[str, Promise]]) -> Iterator[tuple[str, Promise]]:
    """Yield names and sources; a text of two letters is no pair, as the names in a dictionary would be."""
    if not isinstance(people, Iterable):
        raise HarmonicFaceError(f"people: expected pairs of a name and a source, got {_validate.describe(people)}")
    for pair in people:
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise HarmonicFaceError(f"people: expected pairs of a name and a source, got {_validate.describe(pair)}")
        yield pair[0], pair[1]
