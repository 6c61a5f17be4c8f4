"""The command that shows a face, or a photograph of it, under another light."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from harmonicface._validate import Floats, positive
from harmonicface.appearance.relight import relight as relit
from harmonicface.appearance.render import render
from harmonicface.bench.console import waiting
from harmonicface.commands.light_options import LIGHT_HELP, read_lights
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
    Rotation,
    Source,
    Texture,
    Transfer,
    view,
)
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.sources import MeshView
from harmonicface.io.colour import luminance
from harmonicface.io.images import WRITTEN, read_image, write_image
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.layouts import LAYOUTS
from harmonicface.lighting.light import Light, SumOfLights
from harmonicface.reflectance.materials import Material, Microfacet, Phong
from harmonicface.surfaces.surface import Surface

MAP_ORDER, SHADOWED_ORDER = 8, 4  # of maps, unless told otherwise; shadows of a higher order take long
BRIGHT = 0.99  # the share of pixels that stay below white, unless told otherwise


def relight(
    source: Source,
    light: Annotated[list[str], typer.Option(help=LIGHT_HELP, show_default=False)],
    out: Annotated[Path, typer.Option(help="The picture to write, PNG or JPEG.", show_default=False)],
    photo: Annotated[
        Path | None, typer.Option(help="A photograph of the face, in place on it, to be shown under the light instead.")
    ] = None,
    photo_light: Annotated[
        list[str] | None, typer.Option(help="The photograph's light, named as --light.", show_default="estimated")
    ] = None,
    layout: Annotated[str, typer.Option(help=f"Of environment files: {', '.join(LAYOUTS)}.")] = "latlong",
    rotate_light: Annotated[
        str | None, typer.Option(help="Yaw, pitch, roll of the light in degrees.", show_default="0,0,0")
    ] = None,
    order: Annotated[
        int | None,
        typer.Option(
            help="Highest degree of the light's harmonics.",
            show_default=f"maps {MAP_ORDER}, with shadows {SHADOWED_ORDER}; lamps and shadowed photographs exact",
        ),
    ] = None,
    exact: Annotated[bool, typer.Option("--exact", help="Sum over the light's directions, maps too: slow.")] = False,
    shadows: Annotated[bool, typer.Option("--shadows", help="With cast shadows.")] = False,
    bounces: Annotated[
        int, typer.Option(help="How often light is thrown back within the face; more than 0 implies --shadows.")
    ] = 0,
    shininess: Annotated[
        float | None, typer.Option(help="A Phong coat of this exponent: 10 dull, 100 wet.", show_default="matte")
    ] = None,
    roughness: Annotated[
        float | None,
        typer.Option(help="A microfacet coat instead: 0.3 radians skin, 0.1 varnish.", show_default="matte"),
    ] = None,
    gloss: Annotated[
        float | None,
        typer.Option(
            help="Strength of the coat, 0 to 1: a share of the light, or of Fresnel's.",
            show_default="0.04 Phong, 1 microfacet",
        ),
    ] = None,
    exposure: Annotated[
        float | None,
        typer.Option(
            help="Factor for the picture's light.", show_default="99 % below white, or as bright as the photograph"
        ),
    ] = None,
    size: Annotated[
        int | None,
        typer.Option(
            help="Height and width in pixels at which a mesh is seen.", show_default="256 or the photograph's"
        ),
    ] = None,
    texture: Texture = None,
    flip_texture: FlipTexture = False,
    rotation: Rotation = None,
    frame: FrameOption = None,
    intrinsics: Intrinsics = None,
    distance: Distance = None,
    transfer: Transfer = None,
    depth_map: DepthMap = None,
    depth_scale: DepthScale = None,
    normal_map: NormalMap = False,
    green: Green = None,
    albedo: Albedo = None,
    pixel_size: PixelSize = None,
) -> None:
    """Show a face, or a photograph of it, under another light."""
    if out.suffix.lower() not in WRITTEN:  # before the work rather than after it
        raise HarmonicFaceError(f"out: expected a name that ends in {', '.join(WRITTEN)}, got {out}")
    if exposure is not None:
        positive(exposure, "exposure")
    if exact and order is not None:
        raise HarmonicFaceError("expected --order or --exact, got both")
    coat = _coat(shininess, roughness, gloss)
    picture = _photo(photo, photo_light, transfer)
    with waiting("reading"):
        new = read_lights(light, layout, rotate_light)
        old = read_lights(photo_light, layout, None) if photo_light else None
        seen = view(size, texture, flip_texture, rotation, frame, intrinsics, distance)
        maps = MapOptions(depth_map, depth_scale, normal_map, green, albedo, pixel_size)
        surface = _surface(source, seen, maps, picture)
    highest = order
    if order is None and not exact and (_has_map(new) or _has_map(old)):
        highest = MAP_ORDER
        if shadows or bounces:  # the quotient of two shadowed series is far off where the old light is weak
            highest = SHADOWED_ORDER if picture is None else None
    with waiting("shading"):
        if picture is None:
            shown = render(surface, new, highest, coat, shadows, bounces)
            factor = _exposure(shown[surface.mask]) if exposure is None else exposure
        else:
            shown = relit(picture, surface, new, old, highest, shadows=shadows, bounces=bounces, material=coat)
            factor = _like(shown[surface.mask], picture[surface.mask]) if exposure is None else exposure
    shown[surface.mask] *= factor
    write_image(out, np.maximum(shown, 0))
    typer.echo(f"{out}: exposure {factor:.4g}")


def _coat(shininess: float | None, roughness: float | None, strength: float | None) -> Material | None:
    """Return the material that the options speak of."""
    if shininess is not None and roughness is not None:
        raise HarmonicFaceError("expected --shininess or --roughness, got both")
    if shininess is not None:
        return Phong(shininess, 0.04 if strength is None else strength)
    if roughness is not None:
        return Microfacet(roughness, strength=1.0 if strength is None else strength)
    if strength is not None:
        raise HarmonicFaceError("gloss: expected --shininess or --roughness with it, got neither")
    return None


def _photo(path: Path | None, light: list[str] | None, transfer: str | None) -> Floats | None:
    """Read the photograph if there is one."""
    if path is not None:
        return read_image(path, transfer)
    for name, given in (("photo-light", light), ("transfer", transfer)):
        if given:
            raise HarmonicFaceError(f"{name}: expected --photo with it, got none")
    return None


def _surface(source: Path, seen: MeshView, maps: MapOptions, picture: Floats | None) -> Surface:
    """Read the face, at the photograph's size unless told otherwise."""
    if picture is not None and seen.size is None and not maps.given and source.suffix.lower() != ".npz":
        height, width = picture.shape[:2]
        seen = replace(seen, size=(height, width))
    return read_shape(source, seen, maps, usual_size=256)


def _has_map(light: Light | None) -> bool:
    """Tell whether an exact sum over the light would take long."""
    if isinstance(light, SumOfLights):
        return any(_has_map(part) for part in light.parts)
    return isinstance(light, EnvironmentMap)


def _exposure(pixels: Floats) -> float:
    """Return the factor that leaves most of the pixels below white."""
    bright = float(np.quantile(pixels.reshape(len(pixels), -1).max(axis=1), BRIGHT))
    return 1 / bright if bright > 0 else 1.0


def _like(pixels: Floats, others: Floats) -> float:
    """Return the factor that makes pixels as bright as others on the whole."""
    mine, theirs = (
        float(np.mean(luminance(each) if each.ndim == 2 else each, dtype=np.float64)) for each in (pixels, others)
    )
    return theirs / mine if mine > 0 else 1.0
