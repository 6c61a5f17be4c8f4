"""A folder with what photometric stereo found: pictures, arrays, mesh, lights, and a page that shows them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.stereo_page import map_pictures, stereo_page
from harmonicface.bench.stereo_pictures import error_pictures, relit_strip, white_of
from harmonicface.bench.stereo_statement import Circumstances, determined, undetermined
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.io.images import write_image
from harmonicface.io.lights_file import write_lights_file
from harmonicface.io.mesh_export import WRITTEN, write_mesh
from harmonicface.io.normal_maps import write_normal_map
from harmonicface.stereo.in_blocks import Images
from harmonicface.stereo.result import StereoResult
from harmonicface.surfaces.textured_mesh import MOST_VERTICES, textured_mesh

PAGE = "report.html"
LARGEST_MAP = 4096  # pixels a side of a picture to look at


def write_stereo_folder(
    result: StereoResult,
    folder: str | os.PathLike[str],
    images: Images,
    names: Sequence[str],
    told: Circumstances,
    title: str,
    *,
    meshes: Sequence[str] = ("glb",),
    intrinsics: Sequence[float] | None = None,
    most_vertices: int = MOST_VERTICES,
    seconds: float | None = None,
    tell: Callable[[str, int, int], None] = lambda *_: None,
) -> list[str]:
    """Write what photometric stereo found into a folder, as pictures, arrays, a mesh and a page.

    The files are normals.npy, normals.png (16 bits), albedo.png, depth.png, residual.png, confidence.png, relit.png,
    mask.png, surface.npz, mesh.glb, lights.txt, results.json and report.html.

    Parameters
    ----------
    result, images, names, told, title, seconds
        See `stereo_page`.
    folder
        Where; it is made if it is not there.
    meshes
        Kinds of mesh files: glb, obj, ply. There is none without depth.
    intrinsics
        Of the pinhole camera that the depth belongs to.
    most_vertices
        Of the mesh.
    tell
        Is told what is being done.

    Returns
    -------
    list of str
        The names of the files.

    Raises
    ------
    HarmonicFaceError
        A folder that cannot be made or written to, another kind of mesh.
    """
    target = checked_folder(folder)
    kinds = checked_meshes(meshes)
    surface = result.surface
    pictures = {**map_pictures(surface), **error_pictures(result), "relit": relit_strip(surface)}
    pictures.pop("normals")
    pictures["mask"] = surface.mask.astype(np.float32)
    shapes = [f"mesh.{kind}" for kind in kinds] if surface.depth is not None else []
    arrays = ["normals.npy", "surface.npz", "lights.txt", "results.json"]
    files = [PAGE, "normals.png", *(f"{name}.png" for name in pictures), *arrays, *shapes]
    steps = len(pictures) + len(arrays) + len(shapes) + 2
    done = 0

    def told_next() -> None:
        nonlocal done
        done += 1
        tell("writing", done, steps)

    write_normal_map(target / "normals.png", surface.normals)
    told_next()
    for name, picture in pictures.items():
        write_image(target / f"{name}.png", picture, transfer="linear")
        told_next()
    _write_array(target / "normals.npy", surface.normals)
    told_next()
    surface.save(target / "surface.npz")
    told_next()
    comments = [f"{title}: {result.model}, {result.model_reason}"]
    write_lights_file(target / "lights.txt", names, result.lights, result.left_out, comments)
    told_next()
    _write_text(target / "results.json", json.dumps(as_json(result, names, told, seconds), indent=2) + "\n")
    told_next()
    if shapes:
        mesh = textured_mesh(surface, intrinsics=intrinsics, most_vertices=most_vertices, white=white_of(surface))
        for name in shapes:
            write_mesh(target / name, mesh)
            told_next()
    _write_text(target / PAGE, stereo_page(result, images, names, told, title, files, seconds, pictures["relit"]))
    told_next()
    return files


def as_json(
    result: StereoResult, names: Sequence[str], told: Circumstances, seconds: float | None = None
) -> dict[str, object]:
    """Return what results.json holds: everything but the pictures."""
    mask = result.surface.mask
    confidence = result.confidence[mask]
    finite = confidence[np.isfinite(confidence)]
    lights = [None if index in result.left_out else row.tolist() for index, row in enumerate(result.lights)]
    return {
        "photographs": list(names),
        "shape": list(result.surface.shape),
        "pixels": int(mask.sum()),
        "model": result.model,
        "model_reason": result.model_reason,
        "ambiguity": {
            "name": result.ambiguity.name,
            "reason": result.ambiguity.reason,
            "parameters": {name: _number(value) for name, value in result.ambiguity.parameters.items()},
        },
        "left_out": {names[index]: reason for index, reason in result.left_out.items()},
        "lights": lights,
        "residual_rms": float(np.sqrt(np.mean(result.residual[mask].astype(np.float64) ** 2))),
        "standard_error_deg": float(np.median(finite)) if finite.size else None,
        "undetermined_share": float((~np.isfinite(confidence)).mean()),
        "singular_values": result.singular_values.tolist(),
        "rank": result.rank,
        "gap": _number(result.gap),
        "condition": _number(result.condition),
        "determined": determined(result, told),
        "undetermined": undetermined(result, told, names),
        "seconds": seconds,
    }


def checked_meshes(meshes: Sequence[str]) -> list[str]:
    """Return kinds of mesh files without their dots.

    Raises
    ------
    HarmonicFaceError
        A kind that is none of glb, obj, ply.
    """
    kinds = [kind.strip().lower().lstrip(".") for kind in meshes]
    known = [ending[1:] for ending in WRITTEN]
    for kind in kinds:
        if kind not in known:
            raise HarmonicFaceError(f"mesh: expected {', '.join(known)}, got {kind!r}")
    return list(dict.fromkeys(kinds))


def checked_folder(folder: str | os.PathLike[str]) -> Path:
    """Make a folder if it is not there.

    Raises
    ------
    HarmonicFaceError
        It cannot be made.
    """
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot make the folder {target}: {error.strerror}") from None
    return target


def _number(value: float) -> float | None:
    """Return a number that JSON knows."""
    return float(value) if np.isfinite(value) else None


def _write_array(path: Path, array: NDArray[np.floating]) -> None:
    with replacing(path) as temporary:
        np.save(temporary, array, allow_pickle=False)


def _write_text(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
