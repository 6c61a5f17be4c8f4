"""Real photographs: the published protocol on the Extended Yale Face Database B."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from harmonicface.bench.contenders import EVERY_METHOD, SHADOWED, Contender, Person, contender
from harmonicface.datasets.yale_b import YalePerson, load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.calibrated import calibrated_stereo
from harmonicface.stereo.reconstruction import reconstruct

SUBSETS = (1, 2, 3, 4, 5)
TRAINING = {"subset1": (1,), "subset12": (1, 2)}
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class YaleMethod:
    """How one method did: error in % and milliseconds a photograph."""

    error_percent: dict[str, float]
    ms_per_query: float


@dataclass(frozen=True)
class YaleResult:
    """The table of the protocol: photographs per subset, and each method's errors on them."""

    protocol: str
    train: str
    people: list[int]
    n: dict[str, int]
    methods: dict[str, YaleMethod]


def evaluate_yale_b(
    folder: str | os.PathLike[str],
    people: Sequence[int] | None = None,
    train: str = "subset1",
    methods: Sequence[str] = EVERY_METHOD,
    progress: Progress | None = None,
) -> YaleResult:
    """Enrol people of Yale B from their frontal photographs, ask for them in all five subsets.

    Surfaces come from calibrated photometric stereo on the training photographs, shadowed pixels left out; methods
    that learn from pictures get the same photographs. Queries are all photographs, at full size, as they are: linear
    intensities, no alignment, no filtering (Georghiades, Belhumeur & Kriegman 2001; Lee, Ho & Kriegman 2005).

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
        "subset1": light within 12 degrees of the camera. "subset12": within 25.
    methods
        Names of methods.
    progress
        Called as work goes on.

    Raises
    ------
    HarmonicFaceError
        A folder or person that is not there, a damaged image, an unknown method or training set, fewer than two
        people, a person with fewer than three training photographs.
    """
    if train not in TRAINING:
        raise HarmonicFaceError(f"train: expected one of {', '.join(TRAINING)}, got {train!r}")
    tell = progress or (lambda *_: None)
    contenders = {method: contender(method) for method in methods}
    faces = load_yale_b(folder, people)
    if len(faces) < 2:
        raise HarmonicFaceError(f"people: expected at least two to tell apart, got {len(faces)}")
    enrolled = {depth: enrolled_people(faces, train, depth) for depth in {name in SHADOWED for name in methods}}
    return YaleResult(
        protocol="yale-b",
        train=train,
        people=[face.number for face in faces],
        n={str(subset): sum(int((face.subsets == subset).sum()) for face in faces) for subset in SUBSETS},
        methods={
            name: _judge(name, method, enrolled[name in SHADOWED], faces, tell) for name, method in contenders.items()
        },
    )


def enrolled_people(faces: Sequence[YalePerson], train: str = "subset1", depth: bool = False) -> list[Person]:
    """Return people with their training photographs and the Surfaces that these give.

    With depth, the photographs are registered to each other before stereo, and the normals are integrated; without,
    stereo takes them as they are.
    """
    people = []
    for face in faces:
        chosen = np.isin(face.subsets, TRAINING[train])
        photographs, lights = face.photographs[chosen], face.lights[chosen]
        surface = reconstruct(photographs, lights) if depth else calibrated_stereo(photographs, lights).surface
        people.append(Person(f"yaleB{face.number:02d}", photographs, surface))
    return people


def _judge(
    name: str, method: Contender, enrolled: Sequence[Person], faces: Sequence[YalePerson], tell: Progress
) -> YaleMethod:
    """Enrol everybody with one method and count its errors per subset."""
    total = sum(len(face.subsets) for face in faces)
    tell(name, 0, total)
    method.enroll(enrolled)
    asked, wrong, times = dict.fromkeys(SUBSETS, 0), dict.fromkeys(SUBSETS, 0), []
    for index, face in enumerate(faces):
        for photo, subset in zip(face.photographs, face.subsets.tolist(), strict=True):
            start = time.perf_counter()
            answer = method.nearest(photo)
            times.append(time.perf_counter() - start)
            asked[subset] += 1
            wrong[subset] += answer != index
            tell(name, len(times), total)
    percent = {str(subset): 100 * wrong[subset] / count for subset, count in asked.items() if count}
    return YaleMethod(percent, 1e3 * float(np.median(times)))
