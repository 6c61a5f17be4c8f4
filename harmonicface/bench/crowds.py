"""Whom the benchmark asks for: the built-in people, or those of the ICT face model."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from harmonicface.errors import HarmonicFaceError
from harmonicface.people.ict import ict_person
from harmonicface.people.ict_model import read_ict_model
from harmonicface.people.synthetic import synthetic_people
from harmonicface.surfaces.surface import Surface

ICT_ALBEDOS = ("grey", "uniform")  # the benchmark's photographs are grey


@dataclass(frozen=True)
class Crowd:
    """People of one kind, by a seed.

    Parameters
    ----------
    name
        Of the kind, for the report.
    draw
        From a number of people, a size in pixels and a seed to their Surfaces; the first ones are the same however
        many are drawn.
    """

    name: str
    draw: Callable[[int, int, int], Iterable[Surface]]


SYNTHETIC = Crowd("synthetic", synthetic_people)


def ict_crowd(folder: str | os.PathLike[str], albedo: str = "grey") -> Crowd:
    """Return the people of the ICT face model.

    Parameters
    ----------
    folder
        `FaceXModel` of ICT-FaceKit.
    albedo
        "grey" skin, or "uniform": nothing but the shape tells people apart.

    Raises
    ------
    HarmonicFaceError
        Files that are missing, unreadable or of another model; another albedo.
    """
    if albedo not in ICT_ALBEDOS:
        raise HarmonicFaceError(f"albedo: expected one of {', '.join(ICT_ALBEDOS)}, got {albedo!r}")
    read_ict_model(folder)  # before the work rather than in the middle of it

    def draw(count: int, size: int, seed: int) -> Iterator[Surface]:
        for index in range(count):
            seen = ict_person(folder, index, size, seed=seed, albedo=albedo)
            # without the head behind it, which is a megabyte a person
            yield Surface(seen.normals, seen.albedo, seen.mask, seen.depth, seen.pixel_size)

    return Crowd("ict" if albedo == "grey" else f"ict, {albedo} albedo", draw)
