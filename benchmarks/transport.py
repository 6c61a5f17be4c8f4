"""How fast are shadows from depth, and harmonic images? Beside rays through embree at equal error, and beside a copy.

python benchmarks/transport.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
import tracemalloc
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import sphericart
import trimesh
from scipy.spatial.transform import Rotation
from trimesh.ray.ray_pyembree import RayMeshIntersector

from harmonicface.appearance.basis import harmonic_images
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, Stopwatch, Timing, best, in_turn, record
from harmonicface.harmonics.basis import real_harmonics, scaled_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.people.synthetic import synthetic_person
from harmonicface.reflectance.filters import lambertian_filter, lambertian_weights
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.horizon_transport import AZIMUTHS, horizon_transport
from harmonicface.surfaces.load import load_surface
from harmonicface.surfaces.surface import Surface

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
FACE = (-1.524, -0.479, 1.364, 2.409)
ORDER = 4
REFERENCE = 40_000  # directions
CHUNK = 1 << 20  # rays at once
ABOVE = 1e-3  # pixels: where rays start, so that they do not hit the triangles they start from


class Rays:
    """One ray a pixel and direction, from the corners of the triangles between the pixels of a depth map."""

    def __init__(self, surface: Surface, pixels: np.ndarray) -> None:
        mesh = mesh_from_depth(surface, steepest=90)
        self.caster = RayMeshIntersector(solid(mesh.vertices, mesh.faces))
        self.origins = mesh.vertices[pixels] + [0, 0, ABOVE * surface.pixel_size]
        self.normals = surface.pixel_normals[pixels].astype(np.float64)
        self.caster.intersects_any(self.origins[:1], [[0.0, 0.0, 1.0]])  # builds the tree

    def transport(self, directions: np.ndarray) -> tuple[np.ndarray, Timing, int]:
        """Return the transport, the time spent in casting alone, and the number of rays.

        Rays go only where the pixel's normal points; what they find hidden is taken from the exact transport without
        shadows, as ours is.
        """
        harmonics = 4 * np.pi / len(directions) * real_harmonics(directions, ORDER)
        result = lambertian_weights(ORDER)[:, None] * real_harmonics(self.normals, ORDER)
        watch = Stopwatch(self.caster.intersects_any, about=f"by embreex, {len(directions)} directions")
        rays, step = 0, max(1, CHUNK // len(directions))
        for first in range(0, len(self.normals), step):
            some = slice(first, first + step)
            cosine = np.maximum(self.normals[some] @ directions.T, 0)
            pixel, direction = np.nonzero(cosine)
            origins, towards = self.origins[some][pixel], directions[direction]
            hit = watch.run(partial(self.caster.intersects_any, origins, towards))
            cosine[pixel, direction] *= hit
            result[:, some] -= harmonics @ cosine.T
            rays += len(pixel)
        return result, watch.timing(sum), rays


def solid(vertices: np.ndarray, faces: np.ndarray) -> trimesh.Trimesh:
    """Return triangles with walls from their rim far down: a head is not hollow, and horizons take it for solid."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    found, uses = np.unique(edges, axis=0, return_counts=True)
    a, b = found[uses == 1].T
    down = len(vertices)
    walls = np.concatenate([np.stack([a, b, b + down], axis=1), np.stack([a, b + down, a + down], axis=1)])
    below = vertices - [0, 0, 10 * np.ptp(vertices, axis=0).max()]
    return trimesh.Trimesh(np.concatenate([vertices, below]), np.concatenate([faces, walls]), process=False)


def even_directions(number: int) -> np.ndarray:
    """Return directions spread evenly over the sphere, along a spiral."""
    z = 1 - (2 * np.arange(number) + 1) / number
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(number)
    return np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)


def relative(found: np.ndarray, exact: np.ndarray) -> float:
    """Return the RMS difference over the RMS."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


def transports(name: str, surface: Surface, quick: bool) -> Iterator[Record]:
    """Time the transport of a depth map beside as many rays as are as exact."""
    rng = np.random.default_rng(0)
    count = int(surface.mask.sum())
    some = np.sort(rng.choice(count, 400 if quick else 1500, replace=False))
    rays = Rays(surface, some)
    turned = Rotation.random(rng=rng).apply(even_directions(REFERENCE // 5 if quick else REFERENCE))
    exact, _, _ = rays.transport(turned)
    ours = horizon_transport(surface, ORDER)
    error = relative(ours[:, some], exact)
    number = 512
    while (theirs := relative(rays.transport(even_directions(number))[0], exact)) > error and number < len(turned) / 2:
        number = int(1.2 * number)
    timed = np.sort(rng.choice(count, count // 10, replace=False)) if quick else np.arange(count)
    _, peer, cast = min(
        (Rays(surface, timed).transport(even_directions(number)) for _ in range(2)), key=lambda found: found[1].seconds
    )
    scale = count / len(timed)
    size = f"{surface.shape[0]} x {surface.shape[1]}, {count} pixels, order {ORDER}"
    yield record(
        f"transport past a depth map, {name}",
        size,
        best(partial(horizon_transport, surface, ORDER), 5),
        peer.times(scale),
        error=error,
        peer_error=theirs,
        unit="RMS, relative",
        bytes=ours.nbytes,
        seed=0,
        question=f"transport past a depth map, {name}",
        note=f"error: from {len(turned)} other directions at {len(some)} pixels, past the same triangles; the peer: "
        f"casting alone, {cast * scale / 1e6:.1f} million rays" + (f", timed at {len(timed)} pixels" if quick else ""),
    )
    peak = peak_bytes(lambda: horizon_transport(surface, ORDER))
    converged = horizon_transport(surface, ORDER, 8 * AZIMUTHS)
    for azimuths in (AZIMUTHS // 2, AZIMUTHS, 2 * AZIMUTHS):
        found = horizon_transport(surface, ORDER, azimuths)
        yield record(
            f"transport past a depth map, {name}, {azimuths} azimuths",
            size,
            best(partial(horizon_transport, surface, ORDER, azimuths), 3),
            error=relative(found, converged),
            unit="RMS, relative to many azimuths",
            bytes=peak,
            question=f"transport past a depth map, {name}",
            note=f"error: from {8 * AZIMUTHS} azimuths, so without that of the surface between the pixels; "
            f"bytes: largest at any moment with {AZIMUTHS} azimuths, {peak / ours.nbytes:.2f} times the result",
        )


def nine_images(pixels: int, repeats: int) -> Iterator[Record]:
    """Time the nine harmonic images beside writing as many bytes."""
    rng = np.random.default_rng(0)
    side = round(pixels**0.5)
    normals = rng.normal(size=(side, side, 3))
    normals = (normals / np.linalg.norm(normals, axis=2, keepdims=True)).astype(np.float32)
    albedo = rng.uniform(0.1, 1, (side, side)).astype(np.float32)
    surface = Surface(normals, albedo)
    flat, factors, weights = normals.reshape(-1, 3), albedo.ravel(), lambertian_filter(2)
    source, target, result = (np.ones((9, side * side), np.float32) for _ in range(3))
    exact = sphericart.SphericalHarmonics(2).compute(flat.astype(np.float64)).T
    exact *= weights[degrees(2)][:, None] * factors
    holes = Surface(normals, albedo, rng.random((side, side)) < 0.9)
    some = holes.mask.ravel()
    part = source[:, some]
    cases: list[tuple[str, Callable[[], np.ndarray], Call[object], np.ndarray]] = [
        (
            "from normals into given memory",
            partial(scaled_harmonics, flat, 2, weights, factors, out=result),
            Call(partial(np.copyto, target, source), about="of the result's bytes"),
            exact,
        ),
        ("of a Surface", partial(harmonic_images, surface), copying(source), exact),
        ("of a Surface with holes", partial(harmonic_images, holes), copying(part), exact[:, some]),
    ]
    for name, ours, peer, expected in cases:
        timings = in_turn(ours, peer, repeats, 3)
        found = ours()
        peak = peak_bytes(ours)
        yield record(
            f"nine harmonic images, {name}",
            f"{found.shape[1]:.0e} pixels float32",
            *timings,
            error=float(np.abs(found - expected).max()),
            unit="from sphericart in float64, the largest",
            bytes=peak,
            seed=0,
            question="nine harmonic images",
            note=f"bytes: largest at any moment beside what was given, {peak / found.nbytes:.2f} times the result",
        )


def copying(array: np.ndarray) -> Call[object]:
    """Return a copy of an array into new memory, as a call."""
    return Call(array.copy, about="of the result's bytes into new memory")


def peak_bytes(function: Callable[[], object]) -> int:
    """Return the most memory that a call holds at any moment, its result included."""
    tracemalloc.start()
    function()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def scan(size: int) -> Surface | None:
    """Return the scanned head's face by its depth alone, None without the data."""
    folder = DATA / "heads" / "LeePerrySmith"
    if not folder.is_dir():
        print(f"skipped: the scanned face, no real data in {folder} (set HARMONICFACE_DATA)")
        return None
    seen = load_surface(
        folder / "LeePerrySmith.glb", size, texture=folder / "Map-COL.jpg", flip_texture=True, frame=FACE
    )
    return Surface(seen.normals, seen.albedo, seen.mask, seen.depth, seen.pixel_size)


def records(quick: bool) -> Iterator[Record]:
    """Yield harmonic images, then transports of a synthetic and of a scanned face."""
    size = 64 if quick else 128
    yield from nine_images(*(10**5, 5) if quick else (10**6, 30))
    yield from transports("a synthetic person", synthetic_person(0, size), quick)
    if (face := scan(size)) is not None:
        yield from transports("a scanned face", face, quick)


if __name__ == "__main__":
    about = "faces at 64 x 64, fewer rays in the reference, the peer at a tenth of them"
    run_benchmark(__doc__, records, about, seed=0)
