"""Mesh colours: what trimesh found of textures, vertex colours and materials, as linear albedo."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import linear_pixels
from harmonicface.io.pixels import pillow_pixels

UNKNOWN_ALBEDO = 0.5

Doubles = NDArray[np.float64]


def read_colours(visual: Any, count: int) -> tuple[Doubles | None, NDArray[np.float32] | None, Doubles]:
    """Return texture coordinates, texture and linear albedo of `count` vertices."""
    uv, material = getattr(visual, "uv", None), getattr(visual, "material", None)
    uv = None if uv is None or len(uv) != count else np.array(uv, dtype=np.float64)
    if uv is not None and not np.isfinite(uv).all():
        raise HarmonicFaceError("expected finite texture coordinates, got NaN or infinite ones")
    picture = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    texture = None
    if isinstance(picture, Image.Image):
        if uv is None:
            raise HarmonicFaceError("expected texture coordinates for the texture inside the file, got none")
        texture = np.ascontiguousarray(linear_pixels(pillow_pixels(picture), "srgb"))
    factor = getattr(material, "baseColorFactor", None)
    if texture is not None:
        main = np.ones(3) if factor is None else _reflectance(factor)
        return uv, texture, np.tile(main, (count, 1))
    colours = _vertex_colours(visual)
    if colours is not None and len(colours) == count:
        return uv, None, linear_pixels(colours[:, None, :3], "srgb")[:, 0].astype(np.float64)
    if factor is None:
        factor = getattr(material, "kwargs", {}).get("kd")
        main = np.full(3, UNKNOWN_ALBEDO) if factor is None else np.resize(np.asarray(factor, dtype=np.float64), 3)
    else:
        main = _reflectance(factor)
    return uv, None, np.tile(main, (count, 1))


def _reflectance(factor: Any) -> Doubles:
    """Return the linear red, green and blue of a base colour factor, which trimesh keeps as bytes."""
    array = np.asarray(factor)
    return array[:3].astype(np.float64) / (255 if array.dtype.kind in "ui" else 1)


def _vertex_colours(visual: Any) -> NDArray[np.uint8] | None:
    """Return the 8-bit colours of the vertices (those of faces are averaged), None where a file has none."""
    if getattr(visual, "kind", None) in ("vertex", "face"):
        return np.asarray(visual.vertex_colors, dtype=np.uint8)
    colours = getattr(visual, "vertex_attributes", {}).get("color")
    if colours is None:
        return None
    array = np.asarray(colours)
    return np.rint(array * 255).clip(0, 255).astype(np.uint8) if array.dtype.kind == "f" else array.astype(np.uint8)
