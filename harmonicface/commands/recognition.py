"""Commands that keep a gallery of people and say whose face a photograph shows."""

from __future__ import annotations

import json
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from harmonicface.commands.options import (
    AsJson,
    Distance,
    FlipTexture,
    FrameOption,
    Intrinsics,
    Rotation,
    Size,
    Texture,
    Transfer,
    view,
)
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.paths import is_file, is_free
from harmonicface.gallery.enrolled.sources import read_face, read_lamps, read_mask, read_source
from harmonicface.gallery.gallery import Gallery
from harmonicface.gallery.match import Match
from harmonicface.io.files import alone_in
from harmonicface.io.images import read_image
from harmonicface.recognition.detection import FaceBox

CROPPED = 96, 84  # height and width of faces cut out for a new gallery: the proportions of the built-in people


def enroll(
    gallery: Annotated[Path, typer.Argument(help="The gallery's folder; made if it is not there.", show_default=False)],
    name: Annotated[str, typer.Argument(help="Who it is.", show_default=False)],
    source: Annotated[
        list[Path],
        typer.Argument(
            help="A mesh, points, a saved Surface, or photographs, one or several.",
            show_default=False,
        ),
    ],
    lights: Annotated[
        Path | None,
        typer.Option(
            help="Where the light of each of three or more photographs stood: a line x y z each.",
            show_default="unknown",
        ),
    ] = None,
    mask: Annotated[
        Path | None, typer.Option(help="For a new gallery: a picture, white where photographs are compared.")
    ] = None,
    detect: Annotated[
        bool, typer.Option("--detect", help="Find the face in each photograph first, and cut it out at --size.")
    ] = False,
    transfer: Transfer = None,
    size: Size = None,
    texture: Texture = None,
    flip_texture: FlipTexture = False,
    rotation: Rotation = None,
    frame: FrameOption = None,
    intrinsics: Intrinsics = None,
    distance: Distance = None,
) -> None:
    """Add a person to a gallery."""
    looks = view(None if detect else size, texture, flip_texture, rotation, frame, intrinsics, distance)
    lamps = None if lights is None else read_lamps(lights, source)
    with alone_in(gallery.parent) if is_file(gallery) else nullcontext():  # a folder has its own lock
        people = _gallery(gallery, mask)
        cropped = _size_of_crops(people, size) if detect else None
        people.enroll(name, read_source(source, looks, transfer, usual_size=64, cropped=cropped), lamps)
        if people.path is None:
            people.save(gallery)
    typer.echo(f"{name} enrolled; {gallery} holds {len(people)} {'person' if len(people) == 1 else 'people'}")


def _size_of_crops(people: Gallery, size: int | None) -> tuple[int, int]:
    """Return height and width at which faces are cut out: the gallery's, if it has one."""
    if people.mask is not None:
        if size is not None and people.mask.shape != (size, size):
            raise HarmonicFaceError(f"size: expected the gallery's shape {people.mask.shape}, got {size}")
        return people.mask.shape[0], people.mask.shape[1]
    return CROPPED if size is None else (size, size)


def _gallery(path: Path, mask: Path | None) -> Gallery:
    """Open a gallery, or begin one."""
    if is_free(path):
        return Gallery.create(path, mask=None if mask is None else read_mask(mask))
    if mask is not None:
        raise HarmonicFaceError(f"mask: expected it with a new gallery only, got {path}, which has its own")
    return Gallery.open(path)


def match(
    gallery: Annotated[Path, typer.Argument(help="The gallery's folder, or its one file.", show_default=False)],
    photo: Annotated[
        list[Path],
        typer.Argument(help="Photographs of the gallery's size; of any size with --detect.", show_default=False),
    ],
    top: Annotated[int, typer.Option(help="How many candidates to name.")] = 5,
    detect: Annotated[
        bool, typer.Option("--detect", help="Find the face in each photograph first, and cut it out.")
    ] = False,
    transfer: Transfer = None,
    as_json: AsJson = False,
) -> None:
    """Say whose face each photograph shows."""
    people = Gallery.open(gallery)
    answers = []
    for path in photo:
        face: FaceBox | None = None
        if detect:
            picture, face = read_face(path, transfer, _size_of_crops(people, None))
        else:
            picture = read_image(path, transfer)
        try:
            found = people.match(picture, top)
        except HarmonicFaceError as error:
            raise HarmonicFaceError(f"{path}: {error}") from None
        answers.append(_as_dict(path, found, face))
        if not as_json:
            if face is not None:
                place = f"{face.side:.0f} pixels, from ({face.left:.0f}, {face.top:.0f})"
                typer.echo(f"{path}: a face of {place}, seen by {face.support} windows")
            typer.echo(f"{path}: {_said(found)}")
            for candidate in found.candidates:
                score = "" if candidate.score is None else f"{candidate.score:6.1f}  "
                typer.echo(f"    {score}{candidate.distance:.4f}  {candidate.name}")
    if as_json:
        typer.echo(json.dumps({"gallery": str(gallery), "matches": answers}))


def _said(found: Match) -> str:
    """Say whom a match names and how a photograph shows her, or why it names nobody."""
    score = found.candidates[0].score
    ranked = f"score {score:.1f}, " if score else ""  # 0 where there is nobody else to compare with
    measures = f"{ranked}distance {found.distance:.4f}, margin {found.margin:.2f}"
    if found.name is None:
        return f"unknown ({measures}): {found.reason}"
    where = "" if found.motion is None else f"; {found.motion.said}"
    return f"{found.name} ({measures}{where})"


def _as_dict(path: Path, found: Match, face: FaceBox | None) -> dict[str, object]:
    return {
        "photo": str(path),
        **({} if face is None else {"face": asdict(face)}),
        "name": found.name,
        "reason": found.reason,
        "source": found.source,
        "distance": found.distance,
        "margin": found.margin if np.isfinite(found.margin) else None,
        "light": None if found.light is None else found.light.values.tolist(),
        "motion": None if found.motion is None else asdict(found.motion),
        "candidates": [
            {
                "name": candidate.name,
                "distance": candidate.distance,
                "score": candidate.score,
                "source": candidate.source,
            }
            for candidate in found.candidates
        ],
    }
