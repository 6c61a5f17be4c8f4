"""Mesh bytes: what a parser would take without a word, or die of, seen before it is parsed."""

from __future__ import annotations

import re
from pathlib import Path

from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.io._glb import glb_complaint, glb_counts

# What reading and rendering took at most for meshes of 0.5 to 5 million faces: bytes for each, on top of the file's.
BYTES_A_FACE, BYTES_A_VERTEX = 450, 140
OBJ_BYTES_A_FACE, STL_TEXT_BYTES_A_FACE = 35, 200  # of a file that says no counts: about the shortest
PLY_SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}
PLY_SIZES |= {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "int64": 8, "uint64": 8}
PLY_SIZES |= {"float16": 2, "float32": 4, "float64": 8}


def check_bytes(file: Path) -> bytes:
    """Return a mesh file's bytes, or refuse what the parser would take without a word: cut short, beyond memory."""
    ending = file.suffix.lower()
    try:
        size = file.stat().st_size
        require(size, f"{file}: a file of {size} bytes")
        data = file.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character
        raise HarmonicFaceError(f"{file!s:.300}: expected a mesh, got {getattr(error, 'strerror', error)}") from None
    complaint = {".glb": glb_complaint, ".obj": _obj_complaint, ".ply": ply_complaint, ".stl": _stl_complaint}
    try:
        problem = complaint[ending](data)
    except HarmonicFaceError as error:
        problem = str(error)
    if problem:
        raise HarmonicFaceError(f"{file}: {problem}")
    counts = {".glb": glb_counts, ".obj": _obj_counts, ".ply": ply_counts, ".stl": _stl_counts}
    faces, vertices = counts[ending](data)
    require(size + BYTES_A_FACE * faces + BYTES_A_VERTEX * vertices, f"{file}: a mesh of about {faces} faces")
    return data


def ply_counts(data: bytes) -> tuple[int, int]:
    """Return how many faces and vertices the header of a PLY file announces."""
    found = dict(re.findall(rb"^element (\S+) (\d+)", data.partition(b"end_header")[0], re.MULTILINE))
    return int(found.get(b"face", 0)), int(found.get(b"vertex", 0))


def ply_complaint(data: bytes) -> str:
    """Tell what is wrong with the header of a PLY file, or that less follows than it announces."""
    header, end, body = data.partition(b"end_header")
    if data[:3] != b"ply" or not end:
        return "expected a PLY file, got one without the header from 'ply' to 'end_header'"
    lines = [line.split() for line in header.decode("latin-1").splitlines()]
    elements: list[tuple[int, int]] = []  # how many, and bytes that each takes at least
    for line in lines:
        if line[:1] == ["element"]:
            if len(line) != 3 or not line[2].isdecimal():
                return f"expected a PLY element with a name and a count, got {' '.join(line)[:80]!r}"
            elements.append((int(line[2]), 0))
        elif line[:1] == ["property"]:
            kind = line[2] if line[1:2] == ["list"] and len(line) == 5 else line[1] if len(line) == 3 else ""
            if kind not in PLY_SIZES or not elements:
                return f"expected a PLY property of a known type in an element, got {' '.join(line)[:80]!r}"
            elements[-1] = (elements[-1][0], elements[-1][1] + PLY_SIZES[kind])
    if ["format", "ascii", "1.0"] in lines:
        expected = sum(count for count, _ in elements)
        # a count beyond the bytes there are needs no count of the lines
        present = len(body) if expected > len(body) else sum(bool(line.strip()) for line in body.splitlines())
        return f"expected a PLY file with {expected} elements, got one cut short at {present}" * (present < expected)
    least = sum(count * size for count, size in elements)
    return f"expected a PLY file of at least {least} bytes, got one cut short at {len(body)}" * (len(body) < least)


def _obj_counts(data: bytes) -> tuple[int, int]:
    faces = len(data) // OBJ_BYTES_A_FACE
    return faces, faces


def _obj_complaint(data: bytes) -> str:
    if re.search(rb"^f[^\n]*\s0(?=[/\s])", data + b"\n", re.MULTILINE):
        return "expected vertex indices from 1, got a face with index 0"
    relative = re.search(rb"^f[^\n]*\s-\d", data, re.MULTILINE)
    if relative and data.find(b"\nv ", relative.start()) >= 0:
        return "expected all vertices before the first relative (negative) index, got some behind it"
    return ""


def _is_binary_stl(data: bytes) -> bool:
    return len(data) >= 84 and len(data) >= 84 + 50 * int.from_bytes(data[80:84], "little")


def _stl_counts(data: bytes) -> tuple[int, int]:
    text = not _is_binary_stl(data)
    faces = len(data) // STL_TEXT_BYTES_A_FACE if text else int.from_bytes(data[80:84], "little")
    return faces, 3 * faces


def _stl_complaint(data: bytes) -> str:
    text = data.lstrip().startswith(b"solid") and b"endsolid" in data[-1000:]
    return "" if _is_binary_stl(data) or text else "expected an STL file, got another one or one cut short"
