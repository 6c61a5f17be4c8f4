"""The command that finds a surface in photographs under different lights."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, cast, get_args

import numpy as np
import typer
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.bench.console import progress
from harmonicface.bench.stereo_folder import as_json, checked_folder, checked_meshes, write_stereo_folder
from harmonicface.bench.stereo_statement import Circumstances, determined, headline, undetermined
from harmonicface.commands.known_lights import brightness_of, known_lights
from harmonicface.commands.options import AsJson, Transfer, numbers
from harmonicface.datasets.chrome_ball import mask_in
from harmonicface.datasets.photographs import Photographs, opened_photographs, photograph_files
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.sources import read_mask
from harmonicface.stereo.bright_part import bright_part
from harmonicface.stereo.colour import balance, with_colours
from harmonicface.stereo.motion import displacement, resample
from harmonicface.stereo.photometric_stereo import Integration, Method, photometric_stereo
from harmonicface.stereo.registration import Registration, register
from harmonicface.stereo.result import StereoResult
from harmonicface.stereo.squares import square_sums
from harmonicface.surfaces.textured_mesh import MOST_VERTICES

MODELS = ("auto", "linear3", "ambient4", "harmonic9")
Tell = Callable[[str, int, int], None]
Mask = NDArray[np.bool_]


def stereo(
    images: Annotated[
        list[Path], typer.Argument(help="Photographs from one place, or a folder of them.", show_default=False)
    ],
    out: Annotated[Path, typer.Option(help="Folder for the results.", show_default=False)],
    lights: Annotated[
        Path | None,
        typer.Option(
            help="Text file, a line a photograph: [name] x y z [intensity | r g b], or nine harmonic coefficients;"
            " or a folder with light_directions.txt and light_intensities.txt.",
            show_default="lights.txt or light_directions.txt beside the photographs",
        ),
    ] = None,
    intensities: Annotated[
        Path | None,
        typer.Option(help="Text file with the brightness of each lamp, one number or red green blue; or: unknown."),
    ] = None,
    ball: Annotated[
        Path | None,
        typer.Option(help="Folder with a photograph of a chrome ball for each light, and its mask unless --circle."),
    ] = None,
    circle: Annotated[
        str | None,
        typer.Option(help="x,y,radius of the chrome ball in pixels; without --ball, in the photographs themselves."),
    ] = None,
    unknown: Annotated[bool, typer.Option("--unknown", help="Find the lights, even if a file tells them.")] = False,
    mask: Annotated[
        str | None,
        typer.Option(
            help="Picture, white where the thing is; bright: what stands out from a dark background; or all.",
            show_default="the folder's mask, otherwise bright",
        ),
    ] = None,
    model: Annotated[str, typer.Option(help=f"Of light: {', '.join(MODELS)}.")] = "auto",
    method: Annotated[
        str, typer.Option(help=f"With known lamps: {', '.join(get_args(Method))}.".replace("_", "-"))
    ] = "robust",
    face: Annotated[
        bool, typer.Option("--face", help="It is a face, from the front: what one looks like helps.")
    ] = False,
    registered: Annotated[
        bool, typer.Option("--register", help="Undo small movements between the photographs first.")
    ] = False,
    saturation: Annotated[float, typer.Option(help="From this share of full scale on, pixels are burnt out.")] = 1.0,
    integration: Annotated[
        str, typer.Option(help=f"Normals to depth: {', '.join(get_args(Integration))}. bilateral keeps edges.")
    ] = "poisson",
    intrinsics: Annotated[
        str | None, typer.Option(help="fx,fy,cx,cy of the camera in pixels.", show_default="parallel rays")
    ] = None,
    distance: Annotated[
        float | None, typer.Option(help="From the camera to the thing: lengths are in its units.", show_default="1")
    ] = None,
    pixel_size: Annotated[
        float | None, typer.Option(help="World units a pixel, without --intrinsics.", show_default="1")
    ] = None,
    reduce: Annotated[int, typer.Option(help="Squares of so many pixels a side become one.")] = 1,
    mesh: Annotated[str, typer.Option(help="Kinds of mesh file: glb, obj, ply.")] = "glb",
    most_vertices: Annotated[int, typer.Option(help="Of the mesh.")] = MOST_VERTICES,
    transfer: Transfer = None,
    as_json_: AsJson = False,
) -> None:
    """Find normals, albedo, depth and lights in photographs of one thing under different lights."""
    start = time.perf_counter()
    kinds = checked_meshes(mesh.split(","))
    camera = None if intrinsics is None else tuple(number / reduce for number in numbers(intrinsics, 4, "intrinsics"))
    _together(camera, distance, pixel_size)
    files = photograph_files(images)
    folder = images[0] if len(images) == 1 and images[0].is_dir() else None
    disc = None if circle is None else numbers(circle, 3, "circle")
    known = known_lights(files, folder, lights, intensities, ball, disc, unknown, transfer)
    target = checked_folder(out)
    colours = known.intensities if known.intensities is not None and known.intensities.ndim == 2 else None
    with progress() as tell:
        reading = opened_photographs(
            files, transfer=transfer, balance=balance(colours), reduce=reduce, folder=target, tell=tell
        )
        with reading as photographs:
            inside, decided = _mask(mask, folder, photographs)
            moved = _registered(photographs, tell) if registered else None
            shown = photographs.images if moved is None else moved.photographs
            if moved is not None:
                inside = inside & moved.known.all(axis=0)
            result = photometric_stereo(
                shown,
                known.directions if known.coefficients is None else known.coefficients,
                inside,
                model=model,  # type: ignore[arg-type]
                method=method.replace("-", "_"),  # type: ignore[arg-type]
                face=face,
                intensities=brightness_of(known, intensities),
                saturation=saturation,
                integration=cast(Integration, integration),
                pixel_size=1.0 if pixel_size is None else pixel_size * reduce,
                intrinsics=camera,
                distance=1.0 if distance is None else distance,
                tell=tell,
            )
            if photographs.coloured:
                result = _coloured(result, photographs, moved, colours, tell)
            told = Circumstances(known.source, decided, _units(camera, distance, pixel_size), _farthest(moved))
            title = folder.resolve().name if folder is not None else files[0].resolve().parent.name
            seconds = time.perf_counter() - start
            written = write_stereo_folder(
                result,
                target,
                shown,
                photographs.names,
                told,
                title,
                meshes=kinds,
                intrinsics=camera,
                most_vertices=most_vertices,
                seconds=seconds,
                tell=tell,
            )
    if as_json_:
        typer.echo(
            json.dumps({"out": str(target), "files": written, **as_json(result, photographs.names, told, seconds)})
        )
        return
    _print(result, photographs, told, target)


def _print(result: StereoResult, photographs: Photographs, told: Circumstances, target: Path) -> None:
    """Print what could and could not be determined."""
    typer.echo(headline(result, told))
    typer.echo("\nDetermined:")
    for text in determined(result, told):
        typer.echo(f"  - {text}")
    typer.echo("\nNot determined:")
    for text in undetermined(result, told, photographs.names):
        typer.echo(f"  - {text}")
    typer.echo(f"\nReport: {(target / 'report.html').resolve()}")


def _together(camera: tuple[float, ...] | None, distance: float | None, pixel_size: float | None) -> None:
    """Refuse options that do not belong together."""
    if distance is not None and camera is None:
        raise HarmonicFaceError("distance: expected --intrinsics with it, got none")
    if pixel_size is not None and camera is not None:
        raise HarmonicFaceError("pixel-size: expected none beside --intrinsics, which tell it, got both")


def _mask(mask: str | None, folder: Path | None, photographs: Photographs) -> tuple[Mask, str]:
    """Return the mask, and who decided on it."""
    everything = np.ones(photographs.shape, bool)
    if mask == "all":
        return everything, "you: all of the picture"
    own = mask_in(folder) if mask is None and folder is not None else None
    if own is None and mask in (None, "bright"):
        found = bright_part(photographs.brightest)
        if found is None:
            if mask is None:
                return everything, "nothing: no part of the picture stands out from a dark background (see --mask)"
            raise HarmonicFaceError("mask: expected a thing that stands out from a dark background, got none")
        return found, "its brightness before a dark background (see --mask)"
    file = Path(str(mask)) if own is None else own
    inside = read_mask(file)
    side = photographs.reduce
    if side > 1:
        inside = 2 * square_sums(inside, side) >= side**2
    if inside.shape != photographs.shape:
        expected, got = (f"{shape[1]} x {shape[0]}" for shape in (photographs.shape, inside.shape))
        raise HarmonicFaceError(f"{file}: expected a mask of {expected} pixels as the photographs have, got {got}")
    if not inside.any():
        raise HarmonicFaceError(f"{file}: expected a mask with white in it, got an empty one")
    return inside, f"the mask {file}"


def _registered(photographs: Photographs, tell: Tell) -> Registration:
    tell("registering", 0, 1)
    found = register(photographs.images)
    tell("registering", 1, 1)
    return found


def _farthest(moved: Registration | None) -> float | None:
    """Return by how many pixels the photograph that moved most was moved."""
    if moved is None:
        return None
    shape = moved.photographs.shape
    return max(float(displacement(motion, shape)) for motion in moved.motions)


def _coloured(
    result: StereoResult, photographs: Photographs, moved: Registration | None, colours: Floats | None, tell: Tell
) -> StereoResult:
    """Return the result with coloured albedo; the photographs are read again."""
    count = len(photographs.files)
    everywhere = np.ones(photographs.shape, bool)
    mask = result.surface.mask

    def read() -> object:
        for index in range(count):
            tell("colours", index, count)
            if moved is None:
                yield photographs.colours(index, mask)
            else:
                picture = photographs.colours(index, everywhere).reshape(*photographs.shape, 3)
                motion = moved.motions[index]
                channels = [resample(np.ascontiguousarray(picture[..., c]), motion)[0][mask] for c in range(3)]
                yield np.stack(channels, axis=1)
        tell("colours", count, count)

    return with_colours(result, read(), colours)  # type: ignore[arg-type]


def _units(camera: tuple[float, ...] | None, distance: float | None, pixel_size: float | None) -> str:
    """Return what lengths are in."""
    if camera is not None:
        return "times the distance to the camera" if distance is None else "units of --distance"
    return "pixels" if pixel_size is None else "units of --pixel-size"
