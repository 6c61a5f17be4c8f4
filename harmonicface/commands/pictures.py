"""The command that writes a face's harmonic images as pictures, with a page about the face."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from harmonicface.bench.surface_folder import write_surface_folder
from harmonicface.commands.options import (
    Distance,
    FlipTexture,
    FrameOption,
    Intrinsics,
    LargeSize,
    Rotation,
    Source,
    Texture,
    view,
)
from harmonicface.gallery.sources import read_surface


def images(
    source: Source,
    out: Annotated[Path, typer.Option(help="Folder for the pictures.")],
    order: Annotated[int, typer.Option(help="Highest degree: 2 gives nine pictures.")] = 2,
    shadows: Annotated[bool, typer.Option("--shadows", help="With cast shadows.")] = False,
    bounces: Annotated[
        int, typer.Option(help="How often light is thrown back within the face; more than 0 implies --shadows.")
    ] = 0,
    size: LargeSize = None,
    texture: Texture = None,
    flip_texture: FlipTexture = False,
    rotation: Rotation = None,
    frame: FrameOption = None,
    intrinsics: Intrinsics = None,
    distance: Distance = None,
) -> None:
    """Write the harmonic images of a face as pictures, its normals, albedo and depth, and a page that shows them."""
    surface = read_surface(
        source, view(size, texture, flip_texture, rotation, frame, intrinsics, distance), usual_size=256
    )
    count = write_surface_folder(surface, out, source.name, order, shadows, bounces)
    typer.echo(f"{count} harmonic images, pictures of the surface, surface.npz and surface.html are in {out}")
