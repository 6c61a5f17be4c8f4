"""Options that several commands take, and what their texts mean."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.sources import MeshView

Source = Annotated[
    Path,
    typer.Argument(
        help="A mesh (GLB, OBJ, PLY, STL), points with normals (PLY, XYZ, NPY) or a saved Surface (.npz).",
        show_default=False,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
SIZE_HELP = "Height and width in pixels at which a mesh is seen."
Size = Annotated[int | None, typer.Option(help=SIZE_HELP, show_default="64")]
LargeSize = Annotated[int | None, typer.Option(help=SIZE_HELP, show_default="256")]
Texture = Annotated[Path | None, typer.Option(help="Picture with the mesh's colours.")]
FlipTexture = Annotated[bool, typer.Option("--flip-texture", help="The texture's rows run upward.")]
Rotation = Annotated[str | None, typer.Option(help="Yaw, pitch, roll of the mesh in degrees.", show_default="0,0,0")]
FrameOption = Annotated[str | None, typer.Option(help="x0,y0,x1,y1 of the view in the mesh's units.")]
Intrinsics = Annotated[
    str | None, typer.Option(help="fx,fy,cx,cy of a pinhole camera in pixels.", show_default="an orthographic camera")
]
Distance = Annotated[
    float | None,
    typer.Option(help="From the pinhole to the mesh's middle, in its units.", show_default="all of it in view"),
]
Transfer = Annotated[
    str | None, typer.Option(help="srgb or linear: what the photographs' numbers mean.", show_default="by file type")
]


def view(
    size: int | None,
    texture: Path | None,
    flip_texture: bool,
    rotation: str | None,
    frame: str | None,
    intrinsics: str | None,
    distance: float | None,
) -> MeshView:
    """Parse the options of a view."""
    return MeshView(
        size,
        texture,
        flip_texture,
        None if rotation is None else numbers(rotation, 3, "rotation"),
        None if frame is None else numbers(frame, 4, "frame"),
        None if intrinsics is None else numbers(intrinsics, 4, "intrinsics"),
        distance,
    )


def numbers(text: str, count: int, name: str) -> tuple[float, ...]:
    """Parse comma-separated numbers."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count:
        raise HarmonicFaceError(f"{name}: expected {count} comma-separated numbers, got {text!r}")
    return found


def make_folder(path: Path) -> None:
    """Make a folder if it is not there."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot make the folder {path}: {error.strerror}") from None
