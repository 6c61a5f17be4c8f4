"""Files with bytes changed or cut off: they load, or they are refused in one line; nothing else, and no warning."""

from __future__ import annotations

import copy
import json
import random
import struct

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual.material import PBRMaterial

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.load import load_surface

BALL = trimesh.creation.icosphere(1)
ROWS = np.hstack([BALL.vertices, BALL.vertices])
ODD = [None, 0, -1, 3, 10**9, 10**18, 1e308, 0.5, "x", [], {}, True, 5126, "VEC3", [1e300] * 16, [0] * 16]


def textured():
    picture = Image.fromarray(np.random.default_rng(0).integers(0, 256, (4, 6, 3), dtype=np.uint8))
    uv = np.random.default_rng(1).random((len(BALL.vertices), 2))
    visual = trimesh.visual.TextureVisuals(uv=uv, material=PBRMaterial(baseColorTexture=picture))
    return trimesh.Trimesh(BALL.vertices, BALL.faces, visual=visual, process=False)


def coloured():
    ball = BALL.copy()
    ball.visual.vertex_colors = np.random.default_rng(0).integers(0, 255, (len(BALL.vertices), 4), dtype=np.uint8)
    return ball


def cloud():
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(ROWS)}\n"
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    return f"{header}end_header\n".encode() + ROWS.astype("<f4").tobytes()


FILES = {
    "textured.glb": lambda: textured().export(file_type="glb"),
    "coloured.glb": lambda: coloured().export(file_type="glb"),
    "coloured.ply": lambda: coloured().export(file_type="ply"),
    "text.ply": lambda: BALL.export(file_type="ply", encoding="ascii"),
    "binary.stl": lambda: BALL.export(file_type="stl"),
    "text.stl": lambda: BALL.export(file_type="stl_ascii").encode(),
    "a.obj": lambda: BALL.export(file_type="obj").encode(),
    "cloud.ply": cloud,
    "cloud.xyz": lambda: "\n".join(" ".join(map(str, row)) for row in ROWS.tolist()).encode(),
}


def loads_or_is_refused(path, data):
    path.write_bytes(data)
    try:
        surface = load_surface(path, 8)
    except HarmonicFaceError as error:
        assert "\n" not in str(error) and len(str(error)) < 500 and path.name in str(error)
        return False
    assert np.isfinite(surface.pixel_normals).all() and np.isfinite(surface.depth[surface.mask]).all()
    return True


@pytest.mark.parametrize("name", FILES)
def test_changed_bytes(tmp_path, name):
    whole = FILES[name]()
    assert loads_or_is_refused(tmp_path / name, whole)
    rng = np.random.default_rng(len(name))
    for number in range(60):
        data = bytearray(whole)
        reach = 400 if number % 2 else len(data)  # most of what matters is at the beginning
        for place in rng.integers(0, min(reach, len(data)), rng.integers(1, 6)):
            data[place] = rng.integers(256)
        if number % 3 == 0:
            data = data[: rng.integers(len(data))]
        loads_or_is_refused(tmp_path / name, bytes(data))


def places_in(value, place=()):
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in pairs:
        yield (*place, key)
        yield from places_in(inner, (*place, key))


def test_changed_json(tmp_path):
    whole = trimesh.Scene([textured(), coloured()]).export(file_type="glb")
    length = struct.unpack("<I", whole[12:16])[0]
    document, rest = json.loads(whole[20 : 20 + length]), whole[20 + length :]
    choose = random.Random(0)
    outcomes = set()
    for _ in range(150):
        changed = copy.deepcopy(document)
        *way, last = choose.choice(list(places_in(changed)))
        inner = changed
        for key in way:
            inner = inner[key]
        inner[last] = choose.choice(ODD)
        words = json.dumps(changed).encode()
        words += b" " * (-len(words) % 4)
        head = b"glTF" + struct.pack("<III", 2, 20 + len(words) + len(rest), len(words)) + b"JSON"
        outcomes.add(loads_or_is_refused(tmp_path / "a.glb", head + words + rest))
    assert outcomes == {True, False}
