"""The command line: parse, call the library, print. Bad input is one line and exit code 2."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, NoReturn, cast

import numpy as np
import typer

from harmonicface.appearance.basis import harmonic_images
from harmonicface.bench.benchmark import run_benchmark
from harmonicface.bench.console import print_table, progress
from harmonicface.bench.contenders import METHODS
from harmonicface.bench.report import results, write_report
from harmonicface.bench.table import error_table, margin_table, yale_table
from harmonicface.bench.yale_b import TRAINING, evaluate_yale_b
from harmonicface.datasets.yale_b import parse_people
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.gallery import Gallery
from harmonicface.gallery.match import Match
from harmonicface.gallery.sources import MeshView, read_mask, read_source, read_surface
from harmonicface.io.files import alone_in
from harmonicface.io.images import read_image, write_image
from harmonicface.io.pictures import signed_colours
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.layouts import LAYOUTS

# What typer raises for a wrong option; it has no public name.
USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[1]

app = typer.Typer(
    help="Recognize faces under any lighting with harmonic subspaces.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
evaluate = typer.Typer(help="Published protocols on data that you have.", no_args_is_help=True)
app.add_typer(evaluate, name="evaluate")

Source = Annotated[
    Path, typer.Argument(help="A mesh (GLB, OBJ, PLY, STL) or a saved Surface (.npz).", show_default=False)
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
SIZE_HELP = "Height and width in pixels at which a mesh is seen."
Size = Annotated[int | None, typer.Option(help=SIZE_HELP, show_default="64")]
LargeSize = Annotated[int | None, typer.Option(help=SIZE_HELP, show_default="256")]
Texture = Annotated[Path | None, typer.Option(help="Picture with the mesh's colours.")]
FlipTexture = Annotated[bool, typer.Option("--flip-texture", help="The texture's rows run upward.")]
Rotation = Annotated[str | None, typer.Option(help="Yaw, pitch, roll of the mesh in degrees.", show_default="0,0,0")]
FrameOption = Annotated[str | None, typer.Option(help="x0,y0,x1,y1 of the view in the mesh's units.")]
Transfer = Annotated[
    str | None, typer.Option(help="srgb or linear: what the photographs' numbers mean.", show_default="by file type")
]
Methods = Annotated[str | None, typer.Option(help=f"Comma-separated, of {', '.join(METHODS)}.", show_default="all")]


@app.command()
def bench(
    faces: Annotated[int, typer.Option(help="How many people.")] = 100,
    size: Annotated[int, typer.Option(help="Height and width of a photograph in pixels.")] = 64,
    seed: Annotated[int, typer.Option(help="The same seed gives the same errors.")] = 0,
    queries: Annotated[int, typer.Option(help="Photographs of each person in each kind of light.")] = 2,
    methods: Methods = None,
    out: Annotated[Path, typer.Option(help="Folder for results.json and report.html.")] = Path("report"),
    as_json: AsJson = False,
) -> None:
    """Recognize synthetic people under light that no gallery picture showed, by every method."""
    _make_folder(out)  # before the work rather than after it
    with progress() as tell:
        result = run_benchmark(faces, size, seed, queries, _methods(methods), tell)
    page = write_report(result, out)
    if as_json:
        typer.echo(json.dumps(results(result)))
        return
    print_table("Wrong answers by kind of light, %; milliseconds a photograph; KiB a person", *error_table(result))
    print_table("Nine harmonic images: margin of the right person; who is refused as unknown, %", *margin_table(result))
    typer.echo(f"\nReport: {page.resolve()}")


@app.command()
def enroll(
    gallery: Annotated[Path, typer.Argument(help="The gallery's file; made if it is not there.", show_default=False)],
    name: Annotated[str, typer.Argument(help="Who it is.", show_default=False)],
    source: Annotated[
        list[Path],
        typer.Argument(
            help="A mesh, a saved Surface, or at least three photographs under different lights.", show_default=False
        ),
    ],
    mask: Annotated[
        Path | None, typer.Option(help="For a new gallery: a picture, white where photographs are compared.")
    ] = None,
    transfer: Transfer = None,
    size: Size = None,
    texture: Texture = None,
    flip_texture: FlipTexture = False,
    rotation: Rotation = None,
    frame: FrameOption = None,
) -> None:
    """Add a person to a gallery."""
    with alone_in(gallery.parent):
        people = _gallery(gallery, mask)
        people.enroll(
            name, read_source(source, _view(size, texture, flip_texture, rotation, frame), transfer, usual_size=64)
        )
        people.save(gallery)
    typer.echo(f"{name} enrolled; {gallery} holds {len(people)} {'person' if len(people) == 1 else 'people'}")


def _gallery(path: Path, mask: Path | None) -> Gallery:
    """Open a gallery, or begin one."""
    try:
        begun = path.exists()
    except (OSError, ValueError):  # a name that no file can have: opening it says so
        begun = True
    if begun and mask is not None:
        raise HarmonicFaceError(f"mask: expected it with a new gallery only, got {path}, which has its own")
    if begun:
        return Gallery.open(path)
    return Gallery(mask=None if mask is None else read_mask(mask))


@app.command()
def match(
    gallery: Annotated[Path, typer.Argument(help="The gallery's file.", show_default=False)],
    photo: Annotated[list[Path], typer.Argument(help="Photographs of the gallery's size.", show_default=False)],
    top: Annotated[int, typer.Option(help="How many candidates to name.")] = 5,
    transfer: Transfer = None,
    as_json: AsJson = False,
) -> None:
    """Say whose face each photograph shows."""
    people = Gallery.open(gallery)
    answers = []
    for path in photo:
        picture = read_image(path, transfer)
        try:
            found = people.match(picture, top)
        except HarmonicFaceError as error:
            raise HarmonicFaceError(f"{path}: {error}") from None
        answers.append(_as_dict(path, found))
        if not as_json:
            typer.echo(f"{path}: {found.name or 'unknown'} (distance {found.distance:.4f}, margin {found.margin:.2f})")
            for candidate in found.candidates:
                typer.echo(f"    {candidate.distance:.4f}  {candidate.name}")
    if as_json:
        typer.echo(json.dumps({"gallery": str(gallery), "matches": answers}))


@app.command()
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
    surface = read_surface(source, _view(size, texture, flip_texture, rotation, frame), usual_size=256)
    pictures = harmonic_images(surface, order)
    scale = float(np.quantile(np.abs(pictures), 0.995))
    _make_folder(out)
    for index, pixels in enumerate(pictures):
        degree = int(np.sqrt(index))
        picture = np.zeros(surface.shape, pixels.dtype)
        picture[surface.mask] = pixels
        name = out / f"harmonic_{index}_l{degree}_m{index - degree * (degree + 1):+d}.png"
        write_image(name, signed_colours(picture, surface.mask, scale), transfer="linear")
    surface.save(out / "surface.npz")
    typer.echo(f"{len(pictures)} pictures and surface.npz are in {out}")


@app.command()
def light(
    map_: Annotated[
        Path,
        typer.Argument(
            metavar="MAP", help="HDR, EXR, PFM, TIFF, NPY, PNG, JPEG; of a cube also its folder.", show_default=False
        ),
    ],
    layout: Annotated[str, typer.Option(help=f"One of {', '.join(LAYOUTS)}.")] = "latlong",
    order: Annotated[int, typer.Option(help="Highest degree: 2 gives nine coefficients a colour.")] = 2,
    as_json: AsJson = False,
) -> None:
    """Print the harmonic coefficients of an environment map, red, green, blue."""
    environment = EnvironmentMap.load(map_, layout=layout)
    found = environment.coefficients(order)
    colours = np.broadcast_to(found.reshape(len(found), -1), (len(found), 3))  # grey is the same in all colours
    if as_json:
        typer.echo(json.dumps({"order": order, "coefficients": colours.tolist()}))
        return
    rows = [
        [
            f"{degree}",
            f"{mode:+d}" if mode else "0",
            *(f"{value:.5g}" for value in colours[degree * (degree + 1) + mode]),
        ]
        for degree in range(order + 1)
        for mode in range(-degree, degree + 1)
    ]
    print_table(f"{map_} ({layout})", ["l", "m", "red", "green", "blue"], rows)


@evaluate.command("yale-b")
def evaluate_yale(
    folder: Annotated[Path, typer.Argument(help="Folder of yaleB01, yaleB02, ...", show_default=False)],
    people: Annotated[str | None, typer.Option(help="As 1-10 or 1,3,5.", show_default="all")] = None,
    train: Annotated[str, typer.Option(help=f"One of {', '.join(TRAINING)}.")] = "subset1",
    methods: Methods = None,
    as_json: AsJson = False,
) -> None:
    """Recognize real photographs: the Extended Yale Face Database B, trained on frontal light."""
    numbers = None if people is None else parse_people(people)
    with progress() as tell:
        result = evaluate_yale_b(folder, numbers, train, _methods(methods), tell)
    if as_json:
        typer.echo(json.dumps(asdict(result)))
        return
    print_table(f"Wrong answers by subset, %, trained on {train}; milliseconds a photograph", *yale_table(result))


def main() -> None:
    """Run the command line; bad input ends in one line on standard error and exit code 2."""
    try:
        sys.exit(app(standalone_mode=False))
    except HarmonicFaceError as error:
        _refuse(str(error))
    except USAGE_ERROR as error:
        _refuse(cast(Any, error).format_message())
    except (typer.Abort, KeyboardInterrupt):
        sys.exit(130)


def _refuse(reason: str) -> NoReturn:
    print(f"harmonicface: {' '.join(reason.split())}", file=sys.stderr)
    sys.exit(2)


def _make_folder(path: Path) -> None:
    """Make a folder if it is not there."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot make the folder {path}: {error.strerror}") from None


def _view(
    size: int | None, texture: Path | None, flip_texture: bool, rotation: str | None, frame: str | None
) -> MeshView:
    """Parse the options of a view."""
    return MeshView(
        size,
        texture,
        flip_texture,
        None if rotation is None else _numbers(rotation, 3, "rotation"),
        None if frame is None else _numbers(frame, 4, "frame"),
    )


def _numbers(text: str, count: int, name: str) -> tuple[float, ...]:
    """Parse comma-separated numbers."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != count:
        raise HarmonicFaceError(f"{name}: expected {count} comma-separated numbers, got {text!r}")
    return numbers


def _methods(text: str | None) -> Sequence[str]:
    """Parse comma-separated names of methods; all of them by default."""
    return METHODS if text is None else [part.strip() for part in text.split(",")]


def _as_dict(path: Path, found: Match) -> dict[str, object]:
    return {
        "photo": str(path),
        "name": found.name,
        "distance": found.distance,
        "margin": found.margin if np.isfinite(found.margin) else None,
        "light": None if found.light is None else found.light.values.tolist(),
        "candidates": [{"name": candidate.name, "distance": candidate.distance} for candidate in found.candidates],
    }
