"""Mesh colours: what trimesh found of textures, vertex colours and materials, as linear albedo."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from harmonicface.errors import HarmonicFaceError
from harmonicface.io._glb import KEPT_COLOURS, check_glb_textures
from harmonicface.io.images import linear_pixels
from harmonicface.io.pixels import pillow_pixels

UNKNOWN_ALBEDO = 0.5

Doubles = NDArray[np.float64]


def check_textures(file: Path, data: bytes) -> None:
    """Refuse a mesh that names a texture which is not there: the parser would leave it out without a word."""
    if file.suffix.lower() == ".glb":
        check_glb_textures(data, file.parent)
        return
    if file.suffix.lower() == ".ply":
        header = data.partition(b"end_header")[0]
        names = re.findall(rb"^comment TextureFile[ \t]+([^\r\n]+)", header, re.MULTILINE)
    else:
        used = set(re.findall(rb"^usemtl[ \t]+([^\r\n]+)", data, re.MULTILINE))
        names = [
            texture
            for library in re.findall(rb"^mtllib[ \t]+([^\r\n]+)", data, re.MULTILINE)
            for material, texture in _material_textures(file.parent / library.decode("utf-8", "replace").strip())
            if material in {name.strip() for name in used}
        ]
    for name in dict.fromkeys(names):
        beside = file.parent / name.decode("utf-8", "replace").strip().replace("\\", "/")
        try:
            with Image.open(beside):
                pass
        except Exception as error:  # Pillow raises whatever it likes
            reason = getattr(error, "strerror", None) or "one that cannot be opened"
            raise HarmonicFaceError(f"expected a picture as the texture {beside.name:.100}, got {reason}") from None


def _material_textures(library: Path) -> list[tuple[bytes, bytes]]:
    """Return the materials of an OBJ's material file with the texture of each that has one; none without the file."""
    try:
        text = library.read_bytes()
    except OSError:
        return []
    found, material = [], b""
    for key, value in re.findall(rb"^[ \t]*(newmtl|map_kd)[ \t]+([^\r\n]+)", text, re.MULTILINE | re.IGNORECASE):
        if key.lower() == b"newmtl":
            material = value.strip()
        else:
            found.append((material, value))
    return found


def read_colours(geometry: Any, count: int) -> tuple[Doubles | None, NDArray[np.float32] | None, Doubles]:
    """Return texture coordinates, texture and linear albedo of `count` vertices."""
    visual = geometry.visual
    uv, material = getattr(visual, "uv", None), getattr(visual, "material", None)
    uv = None if uv is None or len(uv) != count else np.array(uv, dtype=np.float64)
    if uv is not None and uv.shape != (count, 2):
        raise HarmonicFaceError(f"expected two texture coordinates a vertex, got an array of shape {uv.shape}")
    if uv is not None and not np.isfinite(uv).all():
        raise HarmonicFaceError("expected finite texture coordinates, got NaN or infinite ones")
    texture = _texture(material, uv)
    linear = _linear_vertex_colours(geometry, count)
    if linear is not None:  # glTF: the product of factor, texture and vertex colour
        return uv, texture, linear * _main_colour(material, 1.0)
    if texture is not None:
        factor = getattr(material, "baseColorFactor", None)
        return uv, texture, np.tile(np.ones(3) if factor is None else _reflectance(factor), (count, 1))
    colours = _vertex_colours(visual)
    if colours is not None and len(colours) == count:
        return uv, None, linear_pixels(colours[:, None, :3], "srgb")[:, 0].astype(np.float64)
    return uv, None, np.tile(_main_colour(material, UNKNOWN_ALBEDO), (count, 1))


def _texture(material: Any, uv: Doubles | None) -> NDArray[np.float32] | None:
    """Return the linear values of the picture that a material wears."""
    picture = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if not isinstance(picture, Image.Image):
        return None
    if uv is None:
        raise HarmonicFaceError("expected texture coordinates for the texture inside the file, got none")
    values = pillow_pixels(picture)
    texture = linear_pixels(values, "srgb")
    if not np.isfinite(texture).all():
        raise HarmonicFaceError("expected finite values in the texture, got NaN or infinite ones")
    return np.ascontiguousarray(texture)


def _main_colour(material: Any, unknown: float) -> Doubles:
    """Return the linear colour that a material names, or one for those that name none."""
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:
        return _reflectance(factor)
    diffuse = getattr(material, "kwargs", {}).get("kd")
    if diffuse is None:
        return np.full(3, unknown)
    colour = np.resize(np.asarray(diffuse, dtype=np.float64), 3)
    if not (np.isfinite(colour).all() and (colour >= 0).all()):
        raise HarmonicFaceError(f"expected a material's colour of at least 0, got {colour.tolist()}")
    return colour


def _reflectance(factor: Any) -> Doubles:
    """Return the linear red, green and blue of a base colour factor, which trimesh keeps as bytes."""
    array = np.asarray(factor)
    return np.asarray(array[:3].astype(np.float64) / (255 if array.dtype.kind in "ui" else 1))


def _linear_vertex_colours(geometry: Any, count: int) -> Doubles | None:
    """Return glTF's vertex colours, which are linear whatever their type; None where a file has none."""
    stored = getattr(geometry, "vertex_attributes", {}).get(KEPT_COLOURS)
    if stored is None:
        return None
    array = np.asarray(stored)
    if array.ndim != 2 or array.shape[0] != count or array.shape[1] not in (3, 4):
        raise HarmonicFaceError(f"expected {count} vertex colours, got an array of shape {array.shape}")
    colours = array[:, :3] / (np.iinfo(array.dtype).max if array.dtype.kind == "u" else 1.0)
    if not np.isfinite(colours).all() or colours.min(initial=0.0) < 0:
        raise HarmonicFaceError("expected vertex colours of at least 0, got negative ones or NaN")
    return np.asarray(colours, dtype=np.float64)


def _vertex_colours(visual: Any) -> NDArray[np.uint8] | None:
    """Return the 8-bit colours of the vertices (those of faces are averaged), None where a file has none."""
    if getattr(visual, "kind", None) in ("vertex", "face"):
        return np.asarray(visual.vertex_colors, dtype=np.uint8)
    colours = getattr(visual, "vertex_attributes", {}).get("color")
    if colours is None:
        return None
    array = np.asarray(colours)
    return np.rint(array * 255).clip(0, 255).astype(np.uint8) if array.dtype.kind == "f" else array.astype(np.uint8)
