"""How exact are normals from photographs under unknown general light? Heads rendered by mitsuba, beside the bounds.

python benchmarks/general_light.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.mitsuba_oracle import mitsuba_picture
from harmonicface.bench.timing import Call, once, record
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.io.colour import luminance
from harmonicface.io.meshes import Mesh, read_mesh
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.people.crop import FRAME
from harmonicface.people.ict import ict_person
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.general.general_unknown_light import general_light_stereo
from harmonicface.stereo.general.linear_shape import unit
from harmonicface.stereo.general.sky_cells import cell_directions, cell_flow, cell_visibility
from harmonicface.stereo.lamps.unknown_lamps import unknown_lamps
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.surface import Surface

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
SCAN = (-1.524, -0.479, 1.364, 2.409)  # what the picture shows of the scanned head, in its units
PROBES = (
    ("latlong/ennis.hdr", "latlong"),
    ("latlong/pedestrian_overpass_1k.hdr", "latlong"),
    ("latlong/uffizi.hdr", "latlong"),
    ("angular/beach_probe.hdr", "angular"),
    ("cube/grace", "cube"),
    ("cube/pisa", "cube"),
)
NOISE = 0.01  # of a photograph's white, the 99th percentile
SEED = 77  # of the ICT heads, on which nothing was chosen
LIGHT_ORDER = 12  # of the true lights that the bound of single pixels knows


@dataclass(frozen=True, eq=False)
class Subject:
    """A head as it is seen, and photographs of it under turned environments."""

    name: str
    surface: Surface
    photographs: np.ndarray
    lights: np.ndarray


def probes() -> list[EnvironmentMap]:
    """Return the measured environments, all equally bright."""
    found = []
    for file, layout in PROBES:
        drawn = EnvironmentMap.load(DATA / "probes" / file, layout).converted("latlong", 64).radiance
        found.append(EnvironmentMap(drawn / luminance(drawn).mean()))
    return found


def photographed(name: str, mesh: Mesh, frame: tuple[float, ...], size: int, count: int, paths: int) -> Subject:
    """Render a mesh with cast shadows under environments, each turned at random, exposed alike, and add noise."""
    surface = surface_from_mesh(mesh, size, frame=frame)
    rng = np.random.default_rng(sum(map(ord, name)))
    skies, pictures, lights = probes(), [], []
    for number in range(count):
        sky = EnvironmentMap(skies[number % len(skies)].radiance, "latlong", Rotation.random(rng=rng))
        picture = mitsuba_picture(surface.scene.mesh, surface.scene.view, sky, paths, seed=number)
        grey = luminance(picture)[surface.mask].astype(np.float64)
        white = np.percentile(grey, 99)
        pictures.append(grey / white + NOISE * rng.normal(size=grey.size))
        lights.append(luminance(sky.coefficients(LIGHT_ORDER)) / white)
    return Subject(name, surface, np.stack(pictures), np.stack(lights))


def plain(mesh: Mesh) -> Mesh:
    """Return a mesh of one albedo."""
    grey = np.full(mesh.vertices.shape, 0.5)
    return Mesh(mesh.vertices, mesh.faces, mesh.normals, None, (), np.full(len(mesh.faces), -1), grey)


def subjects(quick: bool) -> Iterator[Subject]:
    """Yield the scanned head, on which settings were chosen, then heads of the ICT model."""
    folder = DATA / "heads" / "LeePerrySmith"
    scan = read_mesh(folder / "LeePerrySmith.glb", texture=folder / "Map-COL.jpg", flip_texture=True)
    size, count, paths = (40, 12, 36) if quick else (72, 30, 100)
    yield photographed("LeePerrySmith, textured", scan, SCAN, size, count, paths)
    if quick:
        return
    yield photographed("LeePerrySmith, uniform", plain(scan), SCAN, size, count, paths)
    for index in range(3):
        mesh = ict_person(DATA / "heads" / "ICT-FaceKit" / "FaceXModel", index, size, seed=SEED).scene.mesh
        yield photographed(f"ICT {index}, textured", mesh, FRAME, size, count, paths)
        yield photographed(f"ICT {index}, uniform", plain(mesh), FRAME, size, count, paths)


def degrees(found: np.ndarray, normals: np.ndarray) -> float:
    """Return the mean angle between vectors and unit normals."""
    return float(np.degrees(np.arccos(np.clip((unit(found) * normals).sum(axis=1), -1, 1))).mean())


def linear_bound(photographs: np.ndarray, subject: Subject, rank: int) -> float:
    """Return the error of the best linear map of the leading factors to albedo times the true normals."""
    factors = leading_factors(photographs, rank).right
    wanted = subject.surface.pixel_normals * subject.surface.grey_albedo[:, None]
    best = np.linalg.lstsq(factors.T, wanted, rcond=None)[0]
    return degrees(factors.T @ best, subject.surface.pixel_normals)


def pixel_bound(photographs: np.ndarray, subject: Subject) -> float:
    """Return the error of each pixel for itself, under the true lights past the true depth."""
    surface, normals = subject.surface, subject.surface.pixel_normals.astype(np.float64)
    sky = subject.lights[: len(photographs)] @ real_harmonics(cell_directions(), LIGHT_ORDER)
    visible = cell_visibility(surface.depth / surface.pixel_size, surface.mask)
    found = normals
    for _ in range(3):
        flow = cell_flow(unit(found), sky, visible)
        normal = np.einsum("pni,pnj->pij", flow, flow) + 1e-9 * np.eye(3)
        found = np.linalg.solve(normal, np.einsum("pni,np->pi", flow, photographs)[..., None])[..., 0]
    return degrees(found, normals)


def attempt(function) -> float:  # type: ignore[no-untyped-def]
    """Return the error of what may refuse, NaN if it does."""
    try:
        return float(function())
    except HarmonicFaceError:
        return float("nan")


def measured(subject: Subject, count: int) -> Record:
    """Measure one head with so many photographs."""
    photographs, normals = subject.photographs[:count], subject.surface.pixel_normals
    mask = subject.surface.mask
    timing, found = once(Call(partial(general_light_stereo, photographs, mask, model="harmonic9", face=True)))
    free = general_light_stereo(photographs, mask, model="harmonic9")
    four = attempt(
        lambda: degrees(general_light_stereo(photographs, mask, model="ambient4", shadows=False).scaled, normals)
    )
    lamps = attempt(lambda: degrees(unknown_lamps(photographs, mask).pixels.scaled, normals))
    bounds = [linear_bound(photographs, subject, rank) for rank in (4, 9)]
    single = pixel_bound(photographs, subject)
    height, width = subject.surface.shape
    return record(
        f"unknown general light, {subject.name}",
        f"{count} photographs {height} x {width}",
        timing,
        error=degrees(found.scaled, normals),
        unit="degrees between normals, the mean",
        seed=SEED if subject.name.startswith("ICT") else None,
        question="unknown general light",
        note=f"with the mean face as prior; without {degrees(free.scaled, normals):.2f};"
        f" first order alone {four:.2f}, as distant lamps {lamps:.2f}; bounds: best linear map of 4 factors"
        f" {bounds[0]:.2f}, of 9 {bounds[1]:.2f}, each pixel under the true lights {single:.2f}",
    )


def records(quick: bool) -> Iterator[Record]:
    """Yield one record a head and number of photographs."""
    for subject in subjects(quick):
        for count in (12,) if quick else (30, 12):
            yield measured(subject, count)


if __name__ == "__main__":
    about = "the scanned head alone, small, from 12 photographs"
    run_benchmark(__doc__, records, about, needs=DATA / "heads", seed="the head's name")
