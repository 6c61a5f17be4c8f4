"""GLB: what its JSON announces, before anything is made of it."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from PIL import Image

from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.io._reasons import reason_of

JSON_CHUNK = b"JSON"
COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
KEPT_COLOURS = "_COLOR_0"  # attributes of a user's own, which begin so, are kept as they are stored
HARMLESS = ("KHR_materials_", "KHR_lights_", "KHR_xmp", "EXT_texture_webp")  # extensions that move no vertex


def glb_document(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the JSON of a GLB file and its first binary chunk."""
    length = struct.unpack("<I", data[12:16])[0]
    document = json.loads(data[20 : 20 + length])
    if not isinstance(document, dict):
        raise ValueError("the JSON is no object")
    start = 20 + length
    size = struct.unpack("<I", data[start : start + 4])[0] if len(data) >= start + 8 else 0
    return document, data[start + 8 : start + 8 + size]


def glb_complaint(data: bytes) -> str:
    """Tell what is wrong with the outside of a GLB file, what it asks of its reader, or what it announces in vain."""
    if data[:4] != b"glTF" or data[16:20] != JSON_CHUNK:
        return "expected a GLB file, got one that does not start with 'glTF' and JSON"
    length = int.from_bytes(data[8:12], "little")
    if len(data) < length:
        return f"expected a GLB file of {length} bytes, got one cut short at {len(data)}"
    try:
        document, _ = glb_document(data)
        needed = [name for name in document.get("extensionsRequired", []) if not name.startswith(HARMLESS)]
        if needed:
            return f"expected a GLB file without extensions that change its geometry, got {', '.join(needed)[:100]}"
        glb_counts(data)
        return next(filter(None, (_accessor_complaint(document, one) for one in document.get("accessors", []))), "")
    except HarmonicFaceError:
        raise
    except Exception as error:  # whatever corrupt JSON makes of itself
        return f"expected a whole GLB file, got one cut short or corrupt{reason_of(error)}"


def _accessor_complaint(document: dict[str, Any], accessor: dict[str, Any]) -> str:
    """Tell whether an accessor announces more than there is."""
    size = COMPONENT_BYTES[accessor["componentType"]] * COMPONENTS[accessor["type"]]
    count = accessor["count"]
    if not isinstance(count, int) or count < 0:
        return f"expected a count of at least 0 in a GLB accessor, got {count!r}"
    if "bufferView" not in accessor:
        require(count * size, f"a GLB accessor of {count} elements")
        return ""
    view = document["bufferViews"][accessor["bufferView"]]
    stride = view.get("byteStride", size)
    needed = accessor.get("byteOffset", 0) + (count - 1) * stride + size if count else 0
    if needed > view["byteLength"]:
        return f"expected {count} elements in a GLB accessor, got {view['byteLength']} bytes for {needed}"
    return ""


def glb_counts(data: bytes) -> tuple[int, int]:
    """Return how many faces and vertices the primitives of a GLB file announce."""
    document, _ = glb_document(data)
    accessors = document.get("accessors", [])
    faces = vertices = 0
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            corners = accessors[primitive["attributes"]["POSITION"]]["count"]
            vertices += corners
            faces += (accessors[primitive["indices"]]["count"] if "indices" in primitive else corners) // 3
    return faces, vertices


def prepared_glb(data: bytes) -> bytes:
    """Return the GLB as the parser understands it.

    Vertex colours are renamed so that they are not rounded to 8 bits, and %20 in a file's name is a space.
    """
    document, _ = glb_document(data)
    for picture in document.get("images", []):
        if not picture.get("uri", "data:").startswith("data:"):
            picture["uri"] = unquote(picture["uri"])
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            if "COLOR_0" in attributes:
                attributes[KEPT_COLOURS] = attributes.pop("COLOR_0")
    words = json.dumps(document).encode()
    words += b" " * (-len(words) % 4)
    rest = data[20 + struct.unpack("<I", data[12:16])[0] :]
    head = b"glTF" + struct.pack("<III", 2, 20 + len(words) + len(rest), len(words)) + JSON_CHUNK
    return head + words + rest


def check_glb_textures(data: bytes, folder: Path) -> None:
    """Refuse a GLB whose base colour textures cannot be opened: the parser would leave them out without a word."""
    document, binary = glb_document(data)
    for material in document.get("materials", []):
        named = material.get("pbrMetallicRoughness", {}).get("baseColorTexture")
        if named is None:
            continue
        texture = document["textures"][named["index"]]
        webp = texture.get("extensions", {}).get("EXT_texture_webp", {})
        picture = document["images"][webp.get("source", texture.get("source"))]
        try:
            if "bufferView" in picture:
                view = document["bufferViews"][picture["bufferView"]]
                start = view.get("byteOffset", 0)
                stored = binary[start : start + view["byteLength"]]
            elif picture["uri"].startswith("data:"):
                continue  # the parser decodes it, or raises
            else:
                stored = (folder / unquote(picture["uri"])).read_bytes()
            with Image.open(io.BytesIO(stored)):
                pass
        except Exception as error:  # Pillow raises whatever it likes
            name = picture.get("uri", picture.get("name", "inside the file"))
            reason = getattr(error, "strerror", None) or "one that cannot be opened"
            raise HarmonicFaceError(f"expected a picture as the texture {name!s:.100}, got {reason}") from None
