"""Nine numbers of an environment map: how fast they are, and how wrong is the irradiance that they give.

python benchmarks/environment.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, best, once, record
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.quadrature import sphere_grid
from harmonicface.lighting.layouts import layout_named
from harmonicface.lighting.prefiltered import irradiance_map, reflected, reflected_exactly
from harmonicface.reflectance.microfacet import microfacet_filter, microfacet_lobe
from harmonicface.reflectance.phong import phong_filter, phong_lobe

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
PUBLISHED = "published: mean under 1 %, worst under 5 % of the total (Ramamoorthi & Hanrahan 2001)"
ORDERS = (2, 4, 8, 12, 16, 20)
LOBES = {
    "Phong 10": (lambda cosines: phong_lobe(cosines, 10), lambda order: phong_filter(10, order)),
    "Phong 50": (lambda cosines: phong_lobe(cosines, 50), lambda order: phong_filter(50, order)),
    "microfacet 0.3": (lambda cosines: microfacet_lobe(cosines, 0.3), lambda order: microfacet_filter(0.3, order)),
    "microfacet 0.1": (lambda cosines: microfacet_lobe(cosines, 0.1), lambda order: microfacet_filter(0.1, order)),
}


def speed_records(quick: bool) -> Iterator[Record]:
    """Time nine coefficients against a sum, and a map of 64 x 64 normals against the integral a normal."""
    rng = np.random.default_rng(0)
    radiance = rng.gamma(0.3, 3.0, (512, 1024, 3)).astype(np.float32)
    yield _nine_coefficients(radiance)
    yield _map_of_normals(radiance, repeats=1 if quick else 3)
    for height in (300, 64):
        yield _map_of_normals(radiance[:height, : 2 * height].copy(), repeats=1 if quick else 3)
    yield _map_of_normals(radiance[:64, :64].copy(), repeats=1 if quick else 3)  # T = 4,096 texels, as many as normals
    yield _clamped_cosines(radiance[:128, :256].copy())


def _nine_coefficients(radiance: NDArray[np.float32]) -> Record:
    ours = best(Call(lambda: hf.EnvironmentMap(radiance).coefficients(2), hf.EnvironmentMap.coefficients), 41)
    light = hf.EnvironmentMap(radiance)
    exact = np.einsum("khw,hwc->kc", real_harmonics(light.directions, 2), light.strengths)
    return record(
        "nine coefficients of a map, checks for NaN and negative radiance included",
        "1024x512x3 float32",
        ours,
        best(Call(radiance.sum, about="of the map, which checks nothing"), 41),
        error=float(np.abs(light.coefficients(2) - exact).max() / np.abs(exact).max()),
        unit="from the sum in float64, of the largest coefficient",
        bytes=radiance.nbytes,
        note="target: ratio at most 4",
    )


def _map_of_normals(radiance: NDArray[np.float32], repeats: int) -> Record:
    """Compare two ways to the irradiance of 4,096 normals, each from the same map in float32."""
    height, width = radiance.shape[:2]
    shape = layout_named("angular").shape(64)
    normals = layout_named("angular").directions(shape).astype(np.float32)
    light = hf.EnvironmentMap(radiance)
    towards = np.ascontiguousarray(light.directions.reshape(-1, 3).T.astype(np.float32))
    strengths = light.strengths.reshape(-1, 3).astype(np.float32)
    ours = best(Call(lambda: irradiance_map(hf.EnvironmentMap(radiance), 64, "angular", order=2), irradiance_map), 201)
    few = radiance[:2, :2].copy()
    calls = best(lambda: irradiance_map(hf.EnvironmentMap(few), 1, "angular", order=2), 201).seconds
    integral = partial(blocked_products, normals.reshape(-1, 3), towards, strengths)
    exact = integral()
    peer = best(Call(integral, about="the integral over the half sphere a normal"), repeats)
    seconds = ours.seconds
    found = irradiance_map(light, 64, "angular", order=2).reshape(-1, 3)
    error = np.abs(found - exact) / strengths.sum(axis=0)
    return record(
        "irradiance map of 64x64 normals",
        f"from a map of {width}x{height}x3 float32",
        ours,
        peer,
        error=100 * float(error.mean()),
        peer_error=0.0,
        unit="% of the total light, the mean",
        question="irradiance maps",
        note=f"the peer takes {peer.seconds / seconds:.0f} times as long{_verdict(radiance, peer.seconds / seconds)}; "
        f"4 texels and 1 normal, where calls are all there is, take {1e6 * calls:.0f} of the {1e6 * seconds:.0f} "
        f"microseconds; worst error {100 * error.max():.2f} %",
    )


def _verdict(radiance: NDArray[np.float32], ratio: float) -> str:
    """Say for a map of as many texels as there are normals whether the count of products, T / 9, shows in the time."""
    if radiance.shape[0] * radiance.shape[1] != 4096:
        return ""
    return f" (T/9 = 455 at this, equal, size of both maps; target 400 {'met' if ratio >= 400 else 'missed'})"


def _clamped_cosines(radiance: NDArray[np.float32]) -> Record:
    """Time the package's own exact irradiance beside the plain products."""
    light = hf.EnvironmentMap(radiance)
    normals = layout_named("angular").directions((64, 64)).reshape(-1, 3).astype(np.float32)
    towards = np.ascontiguousarray(light.directions.reshape(-1, 3).T.astype(np.float32))
    strengths = light.strengths.reshape(-1, 3).astype(np.float32)
    ours = best(partial(light.irradiance, normals), 5)
    plain = blocked_products(normals, towards, strengths)
    exact = light.irradiance(normals.astype(np.float64))
    pairs = len(normals) * len(strengths)
    return record(
        "exact irradiance",
        f"4096 normals x {len(strengths)} directions x 3 float32",
        ours,
        best(partial(blocked_products, normals, towards, strengths), 5),
        error=float(np.abs(light.irradiance(normals) - exact).max() / exact.max()),
        peer_error=float(np.abs(plain - exact).max() / exact.max()),
        unit="from float64, of the largest",
        question="exact irradiance",
        note=f"{1e9 * ours.seconds / pairs:.2f} ns a pair",
    )


def blocked_products(
    normals: NDArray[np.float32], towards: NDArray[np.float32], strengths: NDArray[np.float32]
) -> NDArray[np.float64]:
    """Sum clamped cosines in blocks of 256 normals by 256 directions: the textbook's integral, done well."""
    total = np.zeros((len(normals), 3))
    zeros = np.zeros((256, 256), np.float32)
    for first in range(0, len(normals), 256):
        for start in range(0, len(strengths), 256):
            cosines = normals[first : first + 256] @ towards[:, start : start + 256]
            np.maximum(cosines, zeros[:, : cosines.shape[1]], out=cosines)
            total[first : first + 256] += cosines @ strengths[start : start + 256]
    return total


def probe_records() -> Iterator[Record]:
    """Compare nine-coefficient irradiance with brute force on every measured environment there is."""
    grid = sphere_grid(70)
    normals, weights = grid.directions.astype(np.float32), grid.weights / (4 * np.pi)
    for name, light in _probes():
        ours = Call(
            lambda light=light: hf.HarmonicLight(light.coefficients(2)).irradiance(normals),
            hf.EnvironmentMap.coefficients,
            hf.HarmonicLight.irradiance,
        )
        timing, approximate = once(ours)
        peer, exact = once(Call(partial(light.irradiance, normals), about="brute force"))
        error = np.abs(approximate - exact) / light.strengths.reshape(-1, 3).sum(axis=0)
        yield record(
            f"nine-coefficient irradiance of {name}",
            f"{'x'.join(map(str, light.radiance.shape))}, {len(normals)} normals",
            timing,
            peer,
            error=100 * float(weights @ error.mean(axis=1)),
            unit="% of the total light, the mean",
            question="nine-coefficient irradiance",
            note=f"worst {100 * error.max():.2f} %; {PUBLISHED}",
        )


def grace_record() -> Iterator[Record]:
    """Compare the coefficients of Grace Cathedral with the published table after one common scale."""
    folder = DATA / "probes" / "cube" / "grace"
    if folder.is_dir():
        light = hf.EnvironmentMap.load(folder, layout="cube")
        table = hf.lights.published("grace").values
        timing, found = once(Call(light.coefficients))
        scale = (found * table).sum() / (found**2).sum()
        yield record(
            "published table of Grace Cathedral",
            "27 numbers from 6x256x256x3",
            timing,
            error=float(np.abs(scale * found - table).max()),
            unit="from the table, the largest",
            note=f"target 0.02; the table is rounded to 0.01; common scale {scale:.4f}",
        )


def reflection_records(quick: bool) -> Iterator[Record]:
    """Show how the error of a prefiltered map of shiny materials falls with the order."""
    name, light = next(_probes(), ("a random environment", hf.lights.natural(0)))
    light = light.converted("latlong", 64 if quick else 128)
    grid = sphere_grid(30)
    for material, (lobe, filter_of) in LOBES.items():
        peer, exact = once(Call(partial(reflected_exactly, light, lobe, grid.directions), about="brute force"))
        for order in ORDERS:
            timing, found = once(Call(partial(reflected, light, filter_of(order), grid.directions)))
            squared = ((found - exact) ** 2).reshape(len(grid.weights), -1).sum(axis=1)
            energy = (exact**2).reshape(len(grid.weights), -1).sum(axis=1)
            yield record(
                f"prefiltered map, {material}, order {order}",
                f"{name}, {'x'.join(map(str, light.radiance.shape))}, {len(grid.directions)} directions",
                timing,
                peer,
                error=100 * float(np.sqrt(grid.weights @ squared / (grid.weights @ energy))),
                peer_error=0.0,
                unit="% relative L2",
                question=f"prefiltered map, {material}",
            )


def _probes() -> Iterator[tuple[str, hf.EnvironmentMap]]:
    """Read the measured environments, cubes first."""
    for layout in ("cube", "latlong", "angular"):
        folder = DATA / "probes" / layout
        if folder.is_dir():
            for path in sorted(folder.iterdir()):
                yield f"{layout}/{path.stem}", hf.EnvironmentMap.load(path, layout=layout)


def records(quick: bool) -> Iterator[Record]:
    """Yield times, then errors where there are measured environments, then shiny materials."""
    yield from speed_records(quick)
    yield from grace_record()
    yield from probe_records()
    yield from reflection_records(quick)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "fewer repeats, a smaller map for shiny materials", seed=0)
