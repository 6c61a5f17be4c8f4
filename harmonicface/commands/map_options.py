"""Options for a shape that is a picture: a depth map or a normal map, with a picture of its albedo."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated

import typer

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.sources import MeshView, read_surface
from harmonicface.io.depth_maps import read_depth_map
from harmonicface.io.images import read_image
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.load import surface_from_normals
from harmonicface.surfaces.surface import Surface

DepthMap = Annotated[
    str | None,
    typer.Option(help="The source is a depth map (PNG, TIFF, EXR, PFM, NPY) of this: distance or height."),
]
DepthScale = Annotated[float | None, typer.Option(help="World units a step of the depth map.", show_default="1")]
NormalMap = Annotated[bool, typer.Option("--normal-map", help="The source is a normal map.")]
Green = Annotated[str | None, typer.Option(help="Where green points in the normal map: up or down.", show_default="up")]
Albedo = Annotated[
    Path | None, typer.Option(help="Picture with the albedo of a depth map or normal map.", show_default="0.5")
]
PixelSize = Annotated[
    float | None, typer.Option(help="World units a pixel of a depth map or normal map.", show_default="1")
]


@dataclass(frozen=True)
class MapOptions:
    """What was said of a depth map or a normal map; None where nothing was."""

    depth_map: str | None = None
    depth_scale: float | None = None
    normal_map: bool = False
    green: str | None = None
    albedo: Path | None = None
    pixel_size: float | None = None

    @property
    def given(self) -> bool:
        """Whether the source is a map."""
        return self.depth_map is not None or self.normal_map

    def checked(self, view: MeshView) -> None:
        """Refuse options that do not belong together.

        Raises
        ------
        HarmonicFaceError
            Two kinds of map, options of one that is not there, a view of a map.
        """
        if self.depth_map is not None and self.normal_map:
            raise HarmonicFaceError("expected --depth-map or --normal-map, got both")
        owners = {"depth_scale": "--depth-map", "green": "--normal-map"}
        owners |= dict.fromkeys(("albedo", "pixel_size"), "--depth-map or --normal-map")
        for name, owner in owners.items():
            there = {"--depth-map": self.depth_map is not None, "--normal-map": self.normal_map}.get(owner, self.given)
            if getattr(self, name) is not None and not there:
                raise HarmonicFaceError(f"{name.replace('_', '-')}: expected {owner} with it, got none")
        seen = replace(view, intrinsics=None) if self.depth_map is not None else view
        if self.given and seen != MeshView():
            names = [each.name for each in fields(MeshView) if getattr(seen, each.name) != each.default]
            raise HarmonicFaceError(f"expected no view of a map, whose pixels are fixed, got {', '.join(names)}")


def read_shape(source: Path, view: MeshView, maps: MapOptions, usual_size: int) -> Surface:
    """Read a Surface from whatever the source is: a mesh, points, a saved one, a depth map or a normal map.

    Raises
    ------
    HarmonicFaceError
        Options that do not belong together, files that cannot be read or do not fit each other.
    """
    maps.checked(view)
    if not maps.given:
        return read_surface(source, view, usual_size)
    albedo = 0.5 if maps.albedo is None else read_image(maps.albedo)
    if maps.depth_map is None:
        size = 1.0 if maps.pixel_size is None else maps.pixel_size
        return surface_from_normals(source, albedo, pixel_size=size, green=maps.green or "up")
    scale = 1.0 if maps.depth_scale is None else maps.depth_scale
    depth = read_depth_map(source, maps.depth_map, scale=scale)
    return surface_from_depth(depth, albedo, maps.pixel_size, intrinsics=view.intrinsics)
