"""How fast is the rasterizer, and does it see what rays see? Beside trimesh's rays through embree, one per pixel.

python benchmarks/rasterizer.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, in_turn, record
from harmonicface.io.meshes import Mesh, read_mesh
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.raster import Raster, rasterize
from harmonicface.surfaces.view import View

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
FACE = (-1.524, -0.479, 1.364, 2.409)
SIZE = 256
PARTS = 4  # divisions of a pixel along each side in surface_from_mesh


def head() -> Mesh:
    """Return the scanned head with its colours."""
    folder = DATA / "heads" / "LeePerrySmith"
    return read_mesh(folder / "LeePerrySmith.glb", texture=folder / "Map-COL.jpg", flip_texture=True)


class Rays:
    """One ray through each pixel's centre, in pixel coordinates, where the camera looks along -z."""

    def __init__(self, points: np.ndarray, faces: np.ndarray, shape: tuple[int, int]) -> None:
        self.points, self.faces, self.shape = points, faces, shape
        rows, columns = np.indices(shape).reshape(2, -1) + 0.5
        above = np.full(len(rows), points[:, 2].max() + 1)
        self.origins = np.stack([columns, rows, above], axis=1)
        self.directions = np.tile([0.0, 0.0, -1.0], (len(rows), 1))
        self.built = self.build()

    def build(self) -> RayMeshIntersector:
        """Return a caster that is ready: it builds its tree when the first ray is cast."""
        caster = RayMeshIntersector(trimesh.Trimesh(self.points, self.faces, process=False))
        caster.intersects_first(self.origins[:1], self.directions[:1])
        return caster

    def cast(self) -> np.ndarray:
        """Return the triangle that each pixel sees, -1 where there is none."""
        return self.built.intersects_first(self.origins, self.directions).reshape(self.shape)

    def build_and_cast(self) -> np.ndarray:
        """Return the same from the bare triangles."""
        return self.build().intersects_first(self.origins, self.directions)

    def depth(self) -> np.ndarray:
        """Return the height of what each pixel sees, NaN where there is nothing."""
        places, ray, _ = self.built.intersects_location(self.origins, self.directions, multiple_hits=False)
        result = np.full(self.shape, np.nan)
        result.reshape(-1)[ray] = places[:, 2]
        return result


def agreement(raster: Raster, rays: Rays, extent: float) -> tuple[float, str]:
    """Return the RMS difference of depth in parts of the mesh's extent, and in words what differs otherwise."""
    depth = rays.depth()
    both = raster.mask & np.isfinite(depth)
    difference = (raster.depth - depth)[both] / extent
    same = np.abs(difference) < 1e-5
    alone = int((raster.mask != np.isfinite(depth)).sum())
    note = (
        f"error: at the {100 * same.mean():.3f} % of pixels "
        f"where it is below 1e-5; {int((~same).sum())} pixels see another layer, {alone} only one of both sees the mesh"
    )
    return float(np.sqrt((difference[same] ** 2).mean())), note


def rasterizing(mesh: Mesh, frame: tuple[float, ...] | None, name: str, quick: bool) -> list[Record]:
    """Time one raster and one ray per pixel, the tree excluded and included."""
    view = View.fit(mesh.vertices, SIZE, frame=frame)
    points = view.project(mesh.vertices)
    rays = Rays(points, mesh.faces, view.shape)
    raster = rasterize(points, mesh.faces, view.shape)
    error, note = agreement(raster, rays, float(np.ptp(points[:, 2])))
    records = []
    cast = rays.built.intersects_first
    for call in (
        Call(rays.cast, cast, about="by embreex, the tree built before"),
        Call(rays.build_and_cast, cast, about="by embreex, building included"),
    ):
        ours = partial(rasterize, points, mesh.faces, view.shape)
        records.append(
            record(
                "one triangle per pixel",
                f"{name}, {len(mesh.faces)} faces, {SIZE} x {SIZE}",
                *in_turn(ours, call, 3 if quick else 6, 5),
                error=error,
                unit="RMS of depth, in parts of the mesh's",
                bytes=raster.triangle.nbytes + raster.weights.nbytes + raster.depth.nbytes,
                note=f"ours has weights and depth too, the peer the triangle alone; {note}",
            )
        )
    return records


def whole_surface(mesh: Mesh, frame: tuple[float, ...], name: str, quick: bool) -> Record:
    """Time the way from a mesh to a Surface, beside the rays alone that it would need."""
    fine = View.fit(mesh.vertices, SIZE, frame=frame).finer(PARTS)
    rays = Rays(fine.project(mesh.vertices), mesh.faces, fine.shape)
    surface = surface_from_mesh(mesh, SIZE, frame=frame, supersample=PARTS)
    depth = rays.depth()
    counts = np.isfinite(depth).reshape(SIZE, PARTS, SIZE, PARTS).sum(axis=(1, 3))
    whole = surface.mask & (counts == PARTS**2)
    means = depth.reshape(SIZE, PARTS, SIZE, PARTS).mean(axis=(1, 3))
    assert surface.depth is not None
    difference = (surface.depth - means)[whole] / np.ptp(depth[np.isfinite(depth)])
    ours = partial(surface_from_mesh, mesh, SIZE, frame=frame, supersample=PARTS)
    about = f"by embreex, {PARTS}² rays per pixel, the tree built before"
    peer = Call(rays.cast, rays.built.intersects_first, about=about)
    return record(
        "a Surface from a mesh",
        f"{name}, {SIZE} x {SIZE} of {PARTS} x {PARTS} samples",
        *in_turn(ours, peer, 1 if quick else 3, 2),
        error=float(np.median(np.abs(difference))),
        unit="of what the picture spans, the median",
        bytes=surface.normals.nbytes + surface.albedo.nbytes + surface.mask.nbytes + surface.depth.nbytes,
        note="ours with smooth normals, filtered texture and means over the pixel, the peer the triangles alone; "
        "error: of depth",
    )


def records(quick: bool) -> Iterator[Record]:
    """Yield times of rasters, then of a whole Surface."""
    mesh = head()
    yield from rasterizing(mesh, FACE, "scanned face", quick)
    yield from rasterizing(mesh, None, "scanned bust", quick)
    yield whole_surface(mesh, FACE, "scanned face", quick)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "fewer repetitions", needs=DATA / "heads")
