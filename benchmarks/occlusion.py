"""How wrong is recognition as a face is hidden, by blocks of 0 to 50 % and by glasses, and what of them is found.

Beside OpenCV's `cv2.face` (LBPH), Tan-Triggs and plain projection on nine harmonic images, on Yale B (subsets 2 to 5,
enrolled from subset 1) and on synthetic people. Settings were chosen on people 1 to 5 of Yale B; notes tell the error
on the others alone.

python benchmarks/occlusion.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.appearance.render import render
from harmonicface.appearance.sensor import photograph
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.contenders import Contender, Person
from harmonicface.bench.measure import Record
from harmonicface.bench.occlusion import Picture, behind_block, behind_glasses
from harmonicface.bench.ordeals import YALE_EYES
from harmonicface.bench.peers import stopwatch_of
from harmonicface.bench.table import WRONG
from harmonicface.bench.timing import Stopwatch, record
from harmonicface.bench.yale_b import learned
from harmonicface.bench.yale_contenders import yale_contender
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.gallery.gallery import Gallery
from harmonicface.lighting.lights import directional
from harmonicface.people.synthetic import synthetic_people

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
METHODS = ("default", "harmonic9", "lbph", "tan_triggs")
OURS, PEER = "default", "lbph"
SYNTHETIC_EYES = (0.24, 0.28, 0.71)
UNSEEN = 6  # people from this number on had no say in any setting
SHARES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)

Hide = Callable[[Picture, int], Picture]  # a photograph and a seed


@dataclass(frozen=True, eq=False)
class Question:
    """A photograph, who is in it (place and number), and its subset."""

    photo: Picture
    index: int
    number: int
    subset: int


def occlusions(eyes: tuple[float, float, float], quick: bool) -> dict[str, Hide]:
    """Return what hides faces."""
    hides: dict[str, Hide] = {}
    for share in SHARES[::5] if quick else SHARES:
        for fill in ("texture", "grey")[: 1 if share == 0 else 2]:
            name = f"block {100 * share:.0f} %" + (f" {fill}" if share else "")
            hides[name] = lambda photo, seed, share=share, fill=fill: behind_block(photo, share, seed, fill)  # type: ignore[misc]
    hides["glasses"] = lambda photo, _: behind_glasses(photo, eyes)
    hides["sunglasses"] = lambda photo, _: behind_glasses(photo, eyes, dark=True)
    return hides


def asked(
    methods: dict[str, Contender], questions: Sequence[Question], hides: dict[str, Hide], size: str
) -> Iterator[Record]:
    """Ask all methods for everybody behind everything; first seen by people with a say in settings, then the others."""
    numbers, subsets = (np.array([getattr(one, name) for one in questions]) for name in ("number", "subset"))
    for name, hide in hides.items():
        photos = [np.clip(hide(one.photo, seed), 0, 1) for seed, one in enumerate(questions)]
        wrong, timings = {}, {}
        for method, contender in methods.items():
            watch = stopwatch_of(method, contender)
            missed = [
                watch.run(partial(contender.nearest, photo)) != one.index
                for one, photo in zip(questions, photos, strict=True)
            ]
            wrong[method], timings[method] = np.array(missed), watch.timing()
        others = "; ".join(f"{method} {100 * missed.mean():.2f}" for method, missed in wrong.items() if method != OURS)
        yield record(
            f"{name}: {OURS}",
            size,
            timings[OURS],
            timings[PEER],
            error=100 * float(wrong[OURS].mean()),
            peer_error=100 * float(wrong[PEER].mean()),
            unit=WRONG,
            question=f"who is it? {size}",
            note=f"{by_part(wrong[OURS], numbers, subsets)}others: {others}",
        )


def by_part(wrong: NDArray[np.bool_], numbers: NDArray[np.int64], subsets: NDArray[np.int64]) -> str:
    """Say the error on people without a say in settings, and by subset, where there are several."""
    if len(np.unique(subsets)) == 1:
        return ""
    parts = " / ".join(f"{100 * wrong[subsets == subset].mean():.1f}" for subset in np.unique(subsets))
    unseen = f"{100 * wrong[numbers >= UNSEEN].mean():.2f}" if (numbers >= UNSEEN).any() else "-"
    return f"people {UNSEEN} and up {unseen}; subsets 2 / 3 / 4 / 5: {parts}; "


def enrolled(people: Sequence[Person]) -> dict[str, Contender]:
    """Return all methods with everybody enrolled."""
    methods = {name: yale_contender(name) for name in METHODS}
    for method in methods.values():
        method.enroll(people)
    return methods


def yale_records(every: int, quick: bool) -> Iterator[Record]:
    """Ask for people of Yale B."""
    faces = load_yale_b(DATA, range(1, 12))
    frontal = [face.subsets == 1 for face in faces]
    methods = enrolled(
        [
            learned(str(face.number), face.photographs[chosen], face.lights[chosen])
            for face, chosen in zip(faces, frontal, strict=True)
        ]
    )
    questions = [
        Question(face.photographs[place], index, face.number, int(face.subsets[place]))
        for index, face in enumerate(faces)
        for place in np.flatnonzero(face.subsets >= 2)[index % every :: every]
    ]
    size = f"{len(faces)} people of Yale B 168x192, {len(questions)} photographs"
    yield from asked(methods, questions, occlusions(YALE_EYES, quick), size)
    gallery = Gallery()
    for face, chosen in zip(faces, frontal, strict=True):
        gallery.enroll(str(face.number), face.photographs[chosen], face.lights[chosen])
    lit = [one for one in questions if one.subset <= 4][::3]
    size = f"{len(faces)} people of Yale B 168x192, {len(lit)} photographs"
    yield from found(gallery, lit, occlusions(YALE_EYES, quick), size)


def found(gallery: Gallery, questions: Sequence[Question], hides: dict[str, Hide], size: str) -> Iterator[Record]:
    """Say how much of what hides a face is in `match.left_out`, and how much of the face."""
    for name, hide in hides.items():
        of_hidden, of_face, watch = [], [], Stopwatch()
        for seed, one in enumerate(questions):
            photo = np.clip(hide(one.photo, seed), 0, 1)
            hidden = photo != one.photo
            match = gallery.match(photo)
            left_out = watch.run(lambda match=match: match.left_out)  # type: ignore[misc]
            of_hidden += [left_out[hidden].mean()] if hidden.any() else []
            of_face.append(left_out[~hidden].mean())
        yield record(
            f"{name}: what is left out",
            size,
            watch.timing(),
            error=100 * float(1 - np.mean(of_hidden)) if of_hidden else None,
            unit="% of hidden pixels that are not in match.left_out",
            question="what is left out",
            note="of the others "
            f"{100 * np.mean(of_face):.1f} % are (cast shadows, gloss, the neighbourhood); "
            "subsets 2 to 4",
        )


def synthetic_records(people: int, quick: bool) -> Iterator[Record]:
    """Ask for synthetic people under one lamp up to 45 degrees from the camera."""
    surfaces = list(synthetic_people(people, 64, seed=5))
    towards = [(0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)]
    lights = [np.array([x, y, 1.0]) / np.hypot(np.hypot(x, y), 1) for x, y in towards]
    rng = np.random.default_rng(0)
    crowd = [
        Person(str(index), np.stack([photograph(render(one, directional(light)), rng) for light in lights]), one)
        for index, one in enumerate(surfaces)
    ]
    questions = [
        Question(photograph(render(one, directional([*rng.uniform(-1, 1, 2), 1.5])), rng), index, 0, 0)
        for index, one in enumerate(surfaces)
        for _ in range(4)
    ]
    size = f"{people} synthetic people 64x64, {len(questions)} photographs"
    yield from asked(enrolled(crowd), questions, occlusions(SYNTHETIC_EYES, quick), size)


def records(quick: bool) -> Iterator[Record]:
    """Synthetic people, then Yale B."""
    yield from synthetic_records(20 if quick else 30, quick)
    if DATA.is_dir():
        yield from yale_records(12 if quick else 4, quick)
    else:
        print(f"skipped: the photographs of Yale B are not in {DATA} (set HARMONICFACE_DATA)")


if __name__ == "__main__":
    run_benchmark(__doc__, records, "20 synthetic people, a twelfth of the photographs; else a quarter", seed="0, 5")
