"""The command that writes a face's harmonic images as pictures, with a page about the face."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from harmonicface.bench.console import waiting
from harmonicface.bench.surface_folder import checked_order, write_surface_folder
from harmonicface.commands.map_options import (
    Albedo,
    DepthMap,
    DepthScale,
    Green,
    MapOptions,
    NormalMap,
    PixelSize,
    read_shape,
)
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


def images(
    source: Source,
    out: Annotated[Path, typer.Option(help="Folder for the pictures.")],
    order: Annotated[int, typer.Option(help="Highest degree: 2 gives nine pictures; at most 12.")] = 2,
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
    depth_map: DepthMap = None,
    depth_scale: DepthScale = None,
    normal_map: NormalMap = False,
    green: Green = None,
    albedo: Albedo = None,
    pixel_size: PixelSize = None,
) -> None:
    """Write the harmonic images of a face as pictures, its normals, albedo and depth, and a page that shows them."""
    checked_order(order)  # before the work rather than after it
    maps = MapOptions(depth_map, depth_scale, normal_map, green, albedo, pixel_size)
    seen = view(size, texture, flip_texture, rotation, frame, intrinsics, distance)
    with waiting("reading") as tell:
        surface = read_shape(source, seen, maps, usual_size=256)
        count = write_surface_folder(surface, out, source.name, order, shadows, bounces, tell)
    typer.echo(f"{count} harmonic images, pictures of the surface, surface.npz and surface.html are in {out}")
    if surface.scene is not None and not (shadows or bounces):
        typer.echo("surface.npz is without the mesh: its shadows will be those of its depth, unless --shadows is given")
