"""How fast is one match? Beside the one matrix product that any scan of all people has to do.

python benchmarks/match.py [--quick] [--json FILE]
"""

from __future__ import annotations

from functools import partial

import numpy as np

import harmonicface as hf
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.table import WRONG
from harmonicface.bench.timing import Call, best, record

SIZE = 64
QUERIES = 40


def records(quick: bool) -> list[Record]:
    """Time `Gallery.match` of one photograph against the product of all rows with it."""
    people = 200 if quick else 1000
    gallery = hf.Gallery("harmonic9")
    everybody = list(hf.synthetic_people(people, SIZE, seed=0))
    for index, surface in enumerate(everybody):
        gallery.enroll(str(index), surface)
    rng = np.random.default_rng(0)
    asked = rng.choice(people, QUERIES, replace=False)
    photos = [hf.photograph(hf.render(everybody[i], hf.lights.directional(_towards(rng))), rng) for i in asked]
    wrong = sum(gallery.match(photo).name != str(i) for i, photo in zip(asked, photos, strict=True))
    stacked = np.concatenate([hf.Subspace.of(_all_pixels(surface)).rows for surface in everybody])
    vector = photos[0].ravel()
    product = np.empty(len(stacked), np.float32)
    about = f"{stacked.shape[0]} x {stacked.shape[1]} float32 with the photo"
    ours = sorted((best(partial(gallery.match, photo), 3) for photo in photos), key=lambda timing: timing.seconds)
    peer = best(Call(partial(np.dot, stacked, vector, out=product), about=about), 3 * QUERIES)
    return [
        record(
            "match one photo",
            f"{people} people {SIZE}x{SIZE}",
            ours[len(ours) // 2],
            peer,
            error=100 * wrong / QUERIES,
            unit=WRONG,
            bytes=stacked.nbytes,
            note=f"the median of {QUERIES} photos under one lamp; the product names nobody",
        )
    ]


def _towards(rng: np.random.Generator) -> np.ndarray:
    """Return a direction in front of the face."""
    return rng.normal(size=3) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]


def _all_pixels(surface: hf.Surface) -> np.ndarray:
    """Return the harmonic images over all pixels, 0 outside the mask."""
    images = np.zeros((9, surface.mask.size), np.float32)
    images[:, surface.mask.ravel()] = hf.harmonic_images(surface)
    return images


if __name__ == "__main__":
    run_benchmark(__doc__, records, "200 people instead of 1,000", seed=0)
