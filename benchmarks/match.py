"""How fast is one match? Beside the one matrix product that any scan of all people has to do.

Run it as `python benchmarks/match.py [--quick] [--json FILE]`.
"""

from __future__ import annotations

import argparse

import numpy as np

import harmonicface as hf
from harmonicface.bench.measure import Record, best_seconds, print_records, write_records

SIZE = 64
QUERIES = 40


def records(people: int) -> list[Record]:
    """Time `Gallery.match` of one photograph against the product of all rows with it."""
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
    seconds = float(np.median([best_seconds(lambda: gallery.match(photo), repeats=3) for photo in photos]))  # noqa: B023
    peer = float(np.median([best_seconds(lambda: np.dot(stacked, vector, out=product), repeats=3) for _ in photos]))
    return [
        Record(
            name="match one photo",
            size=f"{people} people {SIZE}x{SIZE}",
            seconds=seconds,
            bytes=stacked.nbytes,
            error=100 * wrong / QUERIES,
            peer=f"numpy product of {stacked.shape[0]} x {stacked.shape[1]} float32 with the photo",
            peer_seconds=peer,
            note=f"error: % of {QUERIES} photos under one lamp given to the wrong person; the product names nobody",
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


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="200 people instead of 1,000")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    found = records(200 if options.quick else 1000)
    print_records(found)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
