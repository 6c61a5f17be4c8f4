"""Mesh bytes: what a parser would take without a word, seen before it is parsed."""

from __future__ import annotations

import re
from pathlib import Path

from harmonicface.errors import HarmonicFaceError


def check_bytes(file: Path) -> None:
    """Refuse what the parser would take without a word: files cut short, an OBJ that counts from 0."""
    try:
        data = file.read_bytes()
    except OSError as error:
        raise HarmonicFaceError(f"{file}: expected a mesh, got {error.strerror or error}") from None
    complaint = {".glb": _glb_complaint, ".obj": _obj_complaint, ".ply": _ply_complaint, ".stl": _stl_complaint}
    problem = complaint[file.suffix.lower()](data)
    if problem:
        raise HarmonicFaceError(f"{file}: {problem}")


def _glb_complaint(data: bytes) -> str:
    length = int.from_bytes(data[8:12], "little")
    if data[:4] != b"glTF":
        return "expected a GLB file, got one that does not start with 'glTF'"
    return f"expected a GLB file of {length} bytes, got one cut short at {len(data)}" if len(data) < length else ""


def _obj_complaint(data: bytes) -> str:
    if re.search(rb"^f[^\n]*\s0(?=[/\s])", data + b"\n", re.MULTILINE):
        return "expected vertex indices from 1, got a face with index 0"
    relative = re.search(rb"^f[^\n]*\s-\d", data, re.MULTILINE)
    if relative and data.find(b"\nv ", relative.start()) >= 0:
        return "expected all vertices before the first relative (negative) index, got some behind it"
    return ""


def _ply_complaint(data: bytes) -> str:
    header, _, body = data.partition(b"end_header")
    if not re.search(rb"^format ascii", header, re.MULTILINE):
        return ""
    expected = sum(int(count) for count in re.findall(rb"^element \S+ (\d+)", header, re.MULTILINE))
    lines = sum(bool(line.strip()) for line in body.splitlines())
    return f"expected a PLY file with {expected} elements, got one cut short at {lines}" if lines < expected else ""


def _stl_complaint(data: bytes) -> str:
    binary = len(data) >= 84 and len(data) >= 84 + 50 * int.from_bytes(data[80:84], "little")
    text = data.lstrip().startswith(b"solid") and b"endsolid" in data[-1000:]
    return "" if binary or text else "expected an STL file, got another one or one cut short"
