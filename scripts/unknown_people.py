"""Measure how often galleries of few people name strangers: python scripts/unknown_people.py YALE_B_FOLDER."""

from __future__ import annotations

import argparse

import numpy as np

from harmonicface.bench.yale_b import enrolled_people
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.gallery.gallery import Gallery

DRAWS = 4000
SIZES = (2, 3, 5, 10)
GROUPS = {"to 51 degrees": (2, 3), "to 77 degrees": (4,), "beyond": (5,)}


def main() -> None:
    """Draw galleries from the people at random; ask for somebody in them, and for somebody who is not."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", help="of yaleB01, yaleB02, ...")
    faces = load_yale_b(parser.parse_args().folder)
    gallery = Gallery("harmonic9")
    for person in enrolled_people(faces):
        gallery.enroll(person.name, person.surface)
    photos = [
        (index, subset, photo)
        for index, face in enumerate(faces)
        for subset, photo in zip(face.subsets, face.photographs, strict=True)
    ]
    distances = np.array([_distances(gallery, photo) for _, _, photo in photos])
    people = np.array([index for index, _, _ in photos])
    subsets = np.array([subset for _, subset, _ in photos])
    rng = np.random.default_rng(0)
    print(f"{len(faces)} people, {DRAWS} draws; in %")
    print(f"{'light':>14} {'people':>7} {'strangers named':>16} {'enrolled refused':>17}")
    for name, group in GROUPS.items():
        for size in SIZES:
            chosen = rng.choice(np.flatnonzero(np.isin(subsets, group)), DRAWS)
            named, refused = np.mean([_answers(gallery, distances[i], people[i], size, rng) for i in chosen], axis=0)
            print(f"{name:>14} {size:7d} {100 * named:16.1f} {100 * refused:17.1f}")


def _distances(gallery: Gallery, photo: np.ndarray) -> list[float]:
    """Return the distance to everybody, in the order of enrolment."""
    found = {c.name: c.distance for c in gallery.match(photo, top=len(gallery)).candidates}
    return [found[name] for name in gallery.names]


def _answers(
    gallery: Gallery, distances: np.ndarray, person: int, size: int, rng: np.random.Generator
) -> tuple[bool, bool]:
    """Say whether a gallery without the person names somebody, and whether one with her names nobody."""
    others = rng.permutation(np.delete(distances, person))
    without, having = others[:size], np.append(others[: size - 1], distances[person])
    return _names(gallery, without), not _names(gallery, having)


def _names(gallery: Gallery, distances: np.ndarray) -> bool:
    first, second = np.sort(distances)[:2]
    return gallery.is_known(first, second / first)


if __name__ == "__main__":
    main()
