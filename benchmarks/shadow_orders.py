"""How many harmonic images with shadows does a picture need? Their error and their time, order by order.

python benchmarks/shadow_orders.py [--quick] [--json FILE]

The error is the RMS of the difference over the RMS of the reference, over the mask eroded by one pixel: against our
own exact shadows, and against mitsuba's with the part that is its own noise taken away; the median over several
lights, and the note has every one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from rendering import DATA, MOST_QUICK, coloured, heads, inner, lights, oracle

import harmonicface as hf
from harmonicface.bench.agreement import agreement
from harmonicface.bench.measure import Record, print_records, write_records
from harmonicface.surfaces.transfer import transport

ORDERS = (2, 4, 6, 8)


class Scenery:
    """A head under lights of a kind, with the exact pictures and mitsuba's."""

    def __init__(self, surface: hf.Surface, lit: dict[str, hf.Light], most: int) -> None:
        self.surface, self.labels, self.lights, self.mask = surface, list(lit), list(lit.values()), inner(surface)
        self.exact = [hf.render(surface, light, shadows=True) for light in self.lights]
        self.theirs = [oracle(surface, light, None, most)[0] for light in self.lights]

    def errors(self, surface: hf.Surface, **options: object) -> tuple[np.ndarray, np.ndarray]:
        """Return how far pictures are from the exact ones and from mitsuba's, one number a light."""
        pictures = [coloured(hf.render(surface, light, **options)) for light in self.lights]
        ours = [
            agreement(picture, [coloured(exact)] * 2, self.mask).error
            for picture, exact in zip(pictures, self.exact, strict=True)
        ]
        theirs = [
            agreement(picture, others, self.mask).error for picture, others in zip(pictures, self.theirs, strict=True)
        ]
        return np.array(ours), np.array(theirs)


def rows(name: str, scenery: Scenery, kind: str, quick: bool) -> Iterator[Record]:
    """Return the table of one head under one kind of light."""
    surface = scenery.surface
    size = f"{name} {surface.shape[0]} x {surface.shape[1]}, {kind}"
    yield record("no shadows, order 2", size, 9, scenery, 0.0, scenery.errors(surface, order=2))
    yield record("no shadows, exact", size, 0, scenery, 0.0, scenery.errors(surface))
    ways = [("a mesh", surface), ("its depth map alone", replace(surface, scene=None, transports=()))]
    for way, seen in ways:
        for order in ORDERS:
            seconds = transport_seconds(seen, order, 1 if quick else 3)
            found = scenery.errors(seen, order=order, shadows=True)
            label = f"shadows of {way}, order {order}"
            yield record(label, size, (order + 1) ** 2, scenery, seconds, found)
        label = f"shadows of {way}, exact"
        start = time.perf_counter()
        found = scenery.errors(seen, shadows=True)
        seconds = (time.perf_counter() - start) / len(scenery.lights)
        yield record(label, size, 0, scenery, seconds, found)


def record(
    label: str, size: str, images: int, scenery: Scenery, seconds: float, errors: tuple[np.ndarray, np.ndarray]
) -> Record:
    """Return one row; without images the seconds are those of one picture."""
    ours, theirs = (100 * each for each in errors)
    what = f"{images} images; seconds: the transport" if images else "no images; seconds: one picture"
    each = ", ".join(f"{name} {error:.2f}" for name, error in zip(scenery.labels, ours, strict=True))
    return Record(
        name=label,
        size=size,
        seconds=seconds,
        error=float(np.median(errors[0])),
        bytes=images * int(scenery.surface.mask.sum()) * 4,
        note=f"{what}; error against exact shadows: {np.median(ours):.2f} % ({each}); "
        f"against mitsuba: {np.median(theirs):.2f} % ({theirs.min():.2f} to {theirs.max():.2f})",
    )


def transport_seconds(surface: hf.Surface, order: int, repeats: int) -> float:
    """Return the shortest time of a transport that is computed afresh."""
    times = []
    for _ in range(repeats):
        fresh = replace(surface, transports=())
        start = time.perf_counter()
        transport(fresh, order)
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one head at 32 x 32 under two lights of each kind")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    if not DATA.is_dir():
        parser.exit(1, f"no real data: {DATA} is not there (set HARMONICFACE_DATA)\n")
    everywhere = lights()
    lamps = {label: light for label, light in everywhere.items() if label.startswith("lamp")}
    natural = {label: light for label, light in everywhere.items() if label not in lamps}
    found: list[Record] = []
    for name in ["LeePerrySmith"] if options.quick else ["LeePerrySmith", "ICT 0"]:
        surface = heads()[name](32 if options.quick else 128)
        for kind, lit in (("natural light", natural), ("one lamp", lamps)):
            some = dict(list(lit.items())[-2:]) if options.quick else lit
            scenery = Scenery(surface, some, MOST_QUICK)
            for row in rows(name, scenery, kind, options.quick):
                print_records([row])
                sys.stdout.flush()
                found.append(row)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
