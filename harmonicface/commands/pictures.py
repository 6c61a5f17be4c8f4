"""The command that writes a face's harmonic images as pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from harmonicface.appearance.basis import harmonic_images
from harmonicface.commands.options import (
    FlipTexture,
    FrameOption,
    LargeSize,
    Rotation,
    Source,
    Texture,
    make_folder,
    view,
)
from harmonicface.gallery.sources import read_surface
from harmonicface.io.images import write_image
from harmonicface.io.pictures import signed_colours


def images(
    source: Source,
    out: Annotated[Path, typer.Option(help="Folder for the pictures.")],
    order: Annotated[int, typer.Option(help="Highest degree: 2 gives nine pictures.")] = 2,
    size: LargeSize = None,
    texture: Texture = None,
    flip_texture: FlipTexture = False,
    rotation: Rotation = None,
    frame: FrameOption = None,
) -> None:
    """Write the harmonic images of a face as pictures: red adds light, blue takes it away."""
    surface = read_surface(source, view(size, texture, flip_texture, rotation, frame), usual_size=256)
    pictures = harmonic_images(surface, order)
    scale = float(np.quantile(np.abs(pictures), 0.995))
    make_folder(out)
    for index, pixels in enumerate(pictures):
        degree = int(np.sqrt(index))
        picture = np.zeros(surface.shape, pixels.dtype)
        picture[surface.mask] = pixels
        name = out / f"harmonic_{index}_l{degree}_m{index - degree * (degree + 1):+d}.png"
        write_image(name, signed_colours(picture, surface.mask, scale), transfer="linear")
    surface.save(out / "surface.npz")
    typer.echo(f"{len(pictures)} pictures and surface.npz are in {out}")
