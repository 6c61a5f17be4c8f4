"""Real photographs: the published protocols on the Extended Yale Face Database B."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.bench.contenders import Contender, Person
from harmonicface.bench.degradation import compressed, noisy
from harmonicface.bench.yale_contenders import NEEDING_DEPTH, YALE_METHODS, Scoring, yale_contender
from harmonicface.bench.yale_protocols import SUBSETS, Chosen, Split, yale_protocol
from harmonicface.bench.yale_result import Answers, Query, YaleMethod, YaleResult
from harmonicface.datasets.yale_b import YalePerson, load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.stereo.reconstruction import reconstruct

Progress = Callable[[str, int, int], None]


def evaluate_yale_b(
    folder: str | os.PathLike[str],
    people: Sequence[int] | None = None,
    train: str = "subset1",
    methods: Sequence[str] = YALE_METHODS,
    progress: Progress | None = None,
    noise: float = 0.0,
    jpeg: int | None = None,
) -> YaleResult:
    """Enrol people of Yale B from some of their photographs, ask for them in others.

    Surfaces come from calibrated photometric stereo on the training photographs, shadowed pixels left out; methods
    that learn from pictures get the same photographs. Queries are at full size, as they are: linear intensities, no
    alignment, no filtering (Georghiades, Belhumeur & Kriegman 2001; Lee, Ho & Kriegman 2005).

    Trained on subset 1, or 1 and 2, every photograph is a query, the training ones too: the published tables count
    them (subsets 1 to 4 of people 1 to 10 are their 450). Under nine lights, one frontal photograph or a random half,
    a photograph that was learned from is no query.

    Methods with cast shadows get the same training photographs registered to each other first, and the depth that the
    normals integrate to; the others take the photographs as they are, as was published. "harmonic_shadowed" looks for
    a shift of the query by up to 6 pixels while it projects, at half the size; "harmonic_shadowed_fixed" does not.

    Parameters
    ----------
    folder
        With the folders yaleB01, yaleB02, ...
    people
        Their numbers; everybody there by default.
    train
        "subset1": light within 12 degrees of the camera. "subset12": within 25. "nine-lights": Lee, Ho & Kriegman's.
        "frontal": one photograph. "random-half": half of each person's photographs, mean of ten divisions.
    methods
        Names of methods. One that cannot learn from such photographs is left out, with the reason.
    progress
        Called as work goes on.
    noise
        Standard deviation of Gaussian noise added to queries, white being 1.
    jpeg
        Quality of the JPEG that queries go through, after noise; None leaves them as they are.

    Raises
    ------
    HarmonicFaceError
        A folder or person that is not there, a damaged image, an unknown method or training set, fewer than two
        people, a person without such photographs, noise or a quality out of range, no method that can learn from them.
    """
    protocol = yale_protocol(train)
    deviation = _validate.fraction(noise, "noise")
    if jpeg is not None:
        compressed(np.zeros((8, 8), np.float32), jpeg)  # a quality that is none is known before the work
    running = {name: _Run(name, yale_contender(name)) for name in methods}
    faces = load_yale_b(folder, people)
    if len(faces) < 2:
        raise HarmonicFaceError(f"people: expected at least two to tell apart, got {len(faces)}")
    splits = protocol.splits(faces)
    total = sum(int(chosen.sum()) for split in splits for chosen in split.queries)
    left_out: dict[str, str] = {}
    for split in splits:
        queries = _queries(faces, split, deviation, jpeg)
        enrolled = {depth: _enrolled(faces, split.training, depth) for depth in {n in NEEDING_DEPTH for n in running}}
        for name in list(running):
            try:
                running[name].ask(enrolled[name in NEEDING_DEPTH], queries, progress or (lambda *_: None), total)
            except _CannotLearnError as refusal:
                left_out[name] = str(refusal)
                del running[name]
    if not running:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in left_out.items())
        raise HarmonicFaceError(f"methods: expected one that can learn from {protocol.about}, got none ({reasons})")
    return YaleResult(
        protocol="yale-b",
        train=train,
        people=[face.number for face in faces],
        n={str(subset): _asked(faces, splits, subset) for subset in SUBSETS},
        methods={name: run.result(len(splits)) for name, run in running.items()},
        noise=deviation,
        jpeg=jpeg,
        splits=len(splits),
        left_out=left_out,
    )


def enrolled_people(faces: Sequence[YalePerson], train: str = "subset1", depth: bool = False) -> list[Person]:
    """Return people with their training photographs and the Surfaces that these give.

    With depth, the photographs are registered to each other before stereo, and the normals are integrated; without,
    stereo takes them as they are.
    """
    return _enrolled(faces, yale_protocol(train).splits(faces)[0].training, depth)


def learned(name: str, photographs: NDArray[np.float32], lights: NDArray[np.float64], depth: bool = False) -> Person:
    """Return a person with her photographs, and the Surface that photometric stereo finds in them, if any."""
    try:
        surface = reconstruct(photographs, lights) if depth else calibrated_stereo(photographs, lights).surface
    except HarmonicFaceError as problem:
        return Person(name, photographs, None, lights, str(problem))
    return Person(name, photographs, surface, lights)


def _enrolled(faces: Sequence[YalePerson], training: Sequence[Chosen], depth: bool) -> list[Person]:
    """Return people with their training photographs, lights and Surfaces."""
    people = []
    for face, chosen in zip(faces, training, strict=True):
        people.append(learned(f"yaleB{face.number:02d}", face.photographs[chosen], face.lights[chosen], depth))
    return people


def _queries(faces: Sequence[YalePerson], split: Split, noise: float, jpeg: int | None) -> list[Query]:
    """Return what is asked for, spoiled in the same way for every method."""
    found = []
    for index, (face, chosen) in enumerate(zip(faces, split.queries, strict=True)):
        for place in np.flatnonzero(chosen).tolist():
            photo = face.photographs[place]
            if noise:
                photo = noisy(photo, noise, np.random.default_rng((face.number, place)))
            if jpeg is not None:
                photo = compressed(photo, jpeg)
            found.append(Query(index, int(face.subsets[place]), photo, face.files[place].stem))
    return found


def _asked(faces: Sequence[YalePerson], splits: Sequence[Split], subset: int) -> int:
    """Return how many photographs of a subset are asked for in all divisions."""
    pairs = [pair for split in splits for pair in zip(faces, split.queries, strict=True)]
    return sum(int((face.subsets[chosen] == subset).sum()) for face, chosen in pairs)


class _CannotLearnError(HarmonicFaceError):
    """A method refuses what a protocol gives it to learn from."""


class _Run:
    """A method and its answers so far, over all divisions."""

    def __init__(self, name: str, method: Contender) -> None:
        self._name = name
        self._fresh: Contender | None = method
        self._queries: list[Query] = []
        self._named: list[int] = []
        self._distances: list[NDArray[np.float64]] = []
        self._seconds: list[float] = []

    def ask(self, people: Sequence[Person], queries: Sequence[Query], tell: Progress, total: int) -> None:
        """Enrol everybody and ask for all photographs."""
        method = self._fresh or yale_contender(self._name)
        self._fresh = None
        tell(self._name, len(self._named), total)
        try:
            method.enroll(people)
        except HarmonicFaceError as problem:
            raise _CannotLearnError(str(problem)) from problem
        for query in queries:
            start = time.perf_counter()
            if isinstance(method, Scoring):
                distances = method.distances(query.photo)
                named = int(distances.argmin())
                self._distances.append(distances)
            else:
                named = method.nearest(query.photo)
            self._seconds.append(time.perf_counter() - start)
            self._named.append(named)
            tell(self._name, len(self._named), total)
        self._queries.extend(queries)

    def result(self, splits: int) -> YaleMethod:
        """Return how the method did."""
        distances = np.stack(self._distances) if self._distances else None
        return YaleMethod.of(Answers(self._queries, self._named, distances), self._seconds, splits)
