"""The main job: people who do not exist, asked for under light that no gallery picture showed."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface._validate import Floats
from harmonicface.appearance.render import render
from harmonicface.appearance.sensor import photograph
from harmonicface.bench.contenders import METHODS, Contender, GalleryContender, Person, contender
from harmonicface.bench.crowds import SYNTHETIC, Crowd
from harmonicface.bench.enrolment import ENROLMENTS, enrol_by
from harmonicface.bench.peers import stopwatch_of
from harmonicface.bench.tiers import TIERS, Tier, gallery_lights
from harmonicface.bench.timing import UNTIMED, Timing
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.storage import DEFAULT_MODEL
from harmonicface.gallery.gallery import Gallery
from harmonicface.gallery.recall import missed_by_stage_one
from harmonicface.lighting.light import Light
from harmonicface.recognition.intervals import Rate
from harmonicface.surfaces.surface import Surface

MARGIN_METHOD = "harmonic9"
STRANGERS = 20
RECALLED = 10  # photographs a tier that the default compares with everybody, not with a shortlist alone
Progress = Callable[[str, int, int], None]  # what is being done, how much of it, of how much


@dataclass(frozen=True, eq=False)
class Query:
    """A photograph to be recognized, and the truth about it."""

    person: int
    light: Light
    photo: Floats


@dataclass(frozen=True)
class MethodResult:
    """How one method did: errors by tier, time and memory; `query` is the time under the name of what was called."""

    method: str
    errors: dict[str, int]
    milliseconds: float
    enrolment_seconds: float
    bytes_per_person: float
    query: Timing = UNTIMED


@dataclass(frozen=True)
class Margin:
    """Distance of the nearest wrong person over that of the right one: below 1 is an error."""

    median: float
    worst: float


@dataclass(frozen=True)
class OpenSet:
    """Share of queries that the gallery calls unknown: of enrolled people (wrong) and of strangers (right)."""

    enrolled_refused: float
    strangers_refused: float


@dataclass(frozen=True)
class EnrolmentResult:
    """How methods that enrol Surfaces do when those come from a scanner, or from photographs.

    Parameters
    ----------
    kind
        Of enrolment.
    degrees
        Mean angle between the normals and the true ones.
    seconds
        A person, photographs not counted.
    refused
        How many people photometric stereo refused.
    methods
        Errors by tier.
    margin
        Median over all photographs, of nine harmonic images (see `Margin`).
    """

    kind: str
    degrees: float
    seconds: float
    refused: int
    methods: tuple[MethodResult, ...]
    margin: float


@dataclass(frozen=True, eq=False)
class BenchmarkResult:
    """Everything that the report tells."""

    faces: int
    size: int
    seed: int
    queries: dict[str, int]
    methods: list[MethodResult]
    margins: dict[str, Margin]
    open_set: dict[str, OpenSet]
    people: Sequence[Person]
    asked: dict[str, list[Query]]
    gallery: Gallery
    crowd: str = SYNTHETIC.name
    enrolments: tuple[EnrolmentResult, ...] = ()
    missed: Rate | None = None  # by the default's shortlist, see `missed_by_stage_one`


def run_benchmark(
    faces: int,
    size: int,
    seed: int,
    queries: int = 2,
    methods: Sequence[str] = METHODS,
    progress: Progress | None = None,
    crowd: Crowd = SYNTHETIC,
    enroll: Sequence[str] = ("geometry",),
) -> BenchmarkResult:
    """Enrol people who do not exist, ask for them in every tier by every method.

    Surfaces enrol the subspace methods; the others learn from seven photographs a person under frontal lamps. Every
    photograph is an exact sum of clamped cosines over the light's directions, then noise, saturation and 8 bits.

    Parameters
    ----------
    faces
        How many people, at least 2.
    size
        Height and width of a photograph in pixels, at least 16.
    seed
        The same seed gives the same people, photographs and errors.
    queries
        Photographs of each person in each tier, at least 1.
    methods
        Names of methods, as in the design of the command line.
    progress
        Called as work goes on.
    crowd
        Whom to enrol and ask for; the built-in people by default.
    enroll
        How Surfaces come about, see `enrol_by`; more than "geometry" adds a comparison of all of them. Everything else
        is told of people enrolled by geometry.

    Raises
    ------
    HarmonicFaceError
        A number below its least, an unknown method or enrolment.
    """
    kinds = checked_enrolments(enroll)
    for value, least, name in ((faces, 2, "faces"), (size, 16, "size"), (seed, 0, "seed"), (queries, 1, "queries")):
        _validate.at_least(value, least, name)
    require(4 * size**2 * faces * (7 + 18 + len(TIERS) * queries), f"{faces} people at {size} x {size} pixels")
    tell = progress or (lambda *_: None)
    if len(set(methods)) < len(methods):
        raise HarmonicFaceError(f"methods: expected each once, got {', '.join(methods)}")
    contenders = {method: contender(method) for method in methods}
    everybody = []
    for surface in crowd.draw(faces + STRANGERS, size, seed):
        everybody.append(surface)
        tell("people", len(everybody), faces + STRANGERS)
    people = _enrolled(everybody[:faces], seed, tell)
    asked = {tier.name: _queries(everybody[:faces], tier, [seed, 1, i], queries) for i, tier in enumerate(TIERS)}
    compared = [_enrolment(kind, people, contenders, asked, seed, tell) for kind in kinds] if len(kinds) > 1 else []
    strangers = {tier.name: _queries(everybody[faces:], tier, [seed, 2, i], 1) for i, tier in enumerate(TIERS)}
    results = [_judge(name, method, people, asked, tell) for name, method in contenders.items()]
    tell("margins and strangers", 0, 1)
    gallery = _gallery(contenders, people)
    result = BenchmarkResult(
        faces=faces,
        size=size,
        seed=seed,
        queries={tier: len(photos) for tier, photos in asked.items()},
        methods=results,
        margins={tier: _margin(gallery, people, photos) for tier, photos in asked.items()},
        open_set={tier: _open_set(gallery, asked[tier], strangers[tier]) for tier in asked},
        people=people,
        asked=asked,
        gallery=gallery,
        crowd=crowd.name,
        enrolments=tuple(compared),
        missed=_missed(contenders, asked),
    )
    tell("margins and strangers", 1, 1)
    return result


def _enrolled(surfaces: Sequence[Surface], seed: int, tell: Progress) -> list[Person]:
    """Return people with the photographs that the picture-based methods learn from."""
    people = []
    rng = np.random.default_rng([seed, 0])
    for index, surface in enumerate(surfaces):
        photographs = np.stack([photograph(render(surface, light), rng) for light in gallery_lights()])
        people.append(Person(f"person {index:04d}", photographs, surface))
        tell("photographs for the gallery", index + 1, len(surfaces))
    return people


def _queries(surfaces: Sequence[Surface], tier: Tier, seed: list[int], each: int) -> list[Query]:
    """Photograph everybody under the lights of a tier, every photograph under a light of its own."""
    rng = np.random.default_rng(seed)
    queries = []
    for index, surface in enumerate(surfaces):
        for _ in range(each):
            light = tier.light(rng)
            queries.append(Query(index, light, photograph(render(surface, light), rng, noise=tier.noise)))
    return queries


def _judge(
    name: str, method: Contender, people: Sequence[Person], asked: dict[str, list[Query]], tell: Progress
) -> MethodResult:
    """Enrol everybody with one method and count its errors."""
    total = sum(len(queries) for queries in asked.values())
    tell(name, 0, total)
    start = time.perf_counter()
    method.enroll(people)
    enrolment = time.perf_counter() - start
    errors, watch = dict.fromkeys(asked, 0), stopwatch_of(name, method)
    for tier, queries in asked.items():
        for query in queries:
            errors[tier] += watch.run(partial(method.nearest, query.photo)) != query.person
            tell(name, len(watch.seconds), total)
    timing = watch.timing()
    return MethodResult(name, errors, 1e3 * timing.seconds, enrolment, method.bytes_per_person, timing)


def checked_enrolments(enroll: Sequence[str]) -> list[str]:
    """Return ways of enrolment with geometry, to which they are compared, each once and in the usual order.

    Raises
    ------
    HarmonicFaceError
        Another way than those of `enrol_by`.
    """
    unknown = [kind for kind in enroll if kind not in ENROLMENTS]
    if unknown:
        raise HarmonicFaceError(f"enroll: expected some of {', '.join(ENROLMENTS)}, got {unknown[0]!r}")
    return [kind for kind in ENROLMENTS if kind in {"geometry", *enroll}]


def _enrolment(
    kind: str,
    people: Sequence[Person],
    contenders: dict[str, Contender],
    asked: dict[str, list[Query]],
    seed: int,
    tell: Progress,
) -> EnrolmentResult:
    """Judge the methods that enrol Surfaces on people who were enrolled in one way; who was refused is never found."""
    seen = enrol_by(kind, [person.surface for person in people], seed, lambda *done: tell(f"enrolment: {kind}", *done))
    known = [index for index, surface in enumerate(seen.surfaces) if surface is not None]
    enrolled = [replace(people[index], known=seen.surfaces[index]) for index in known]
    place = {index: number for number, index in enumerate(known)}
    queries = {
        tier: [replace(query, person=place.get(query.person, -1)) for query in of_tier]
        for tier, of_tier in asked.items()
    }
    methods = [name for name, method in contenders.items() if isinstance(method, GalleryContender)]
    results = [_judge(name, contender(name), enrolled, queries, lambda *_: None) for name in methods if enrolled]
    if not known:
        return EnrolmentResult(kind, float("nan"), seen.seconds, len(people), (), float("nan"))
    nine = GalleryContender(MARGIN_METHOD)
    nine.enroll(enrolled)
    found = [query for of_tier in queries.values() for query in of_tier if query.person >= 0]
    margin = _margin(nine.gallery, enrolled, found).median if len(known) > 1 else float("nan")
    refused = len(people) - len(known)
    return EnrolmentResult(kind, float(np.nanmean(seen.degrees)), seen.seconds, refused, tuple(results), margin)


def _gallery(contenders: dict[str, Contender], people: Sequence[Person]) -> Gallery:
    """Return the gallery of nine harmonic images, enrolled already or now."""
    known = contenders.get(MARGIN_METHOD)
    if not isinstance(known, GalleryContender):
        known = GalleryContender(MARGIN_METHOD)
        known.enroll(people)
    return known.gallery


def _missed(contenders: dict[str, Contender], asked: dict[str, list[Query]]) -> Rate | None:
    """Return how often the default's shortlist misses whom its second look would name, in a few photographs a tier."""
    default = contenders.get(DEFAULT_MODEL)
    if not isinstance(default, GalleryContender):
        return None
    some = [query.photo for queries in asked.values() for query in queries[:: -(-len(queries) // RECALLED)]]
    return missed_by_stage_one(default.gallery, some)


def _margin(gallery: Gallery, people: Sequence[Person], queries: Sequence[Query]) -> Margin:
    """Return by how much the right person is nearer than the nearest wrong one."""
    ratios = []
    for query in queries:
        right = people[query.person].name
        answer = gallery.match(query.photo, top=2)
        if right not in {candidate.name for candidate in answer.candidates}:
            answer = gallery.match(query.photo, top=len(gallery))
        distances = {candidate.name: candidate.distance for candidate in answer.candidates}
        ratios.append(min(d for name, d in distances.items() if name != right) / distances[right])
    return Margin(float(np.median(ratios)), min(ratios))


def _open_set(gallery: Gallery, enrolled: Sequence[Query], strangers: Sequence[Query]) -> OpenSet:
    """Return how often the gallery refuses to name those who are in it, and those who are not."""

    def refused(queries: Sequence[Query]) -> float:
        return float(np.mean([gallery.match(query.photo, top=1).name is None for query in queries]))

    return OpenSet(refused(enrolled), refused(strangers))
