"""How many harmonic images with shadows does a picture need? Their error and their time, order by order.

python benchmarks/shadow_orders.py [--quick] [--json FILE]

The error is the RMS of the difference over the RMS of the reference, over the mask eroded by one pixel: against our
own exact shadows, and against mitsuba's with the part that is its own noise taken away; the median over several
lights, and the note has every one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from rendering import DATA, MOST_QUICK, coloured, heads, inner, lights, oracle

import harmonicface as hf
from harmonicface.bench.agreement import agreement
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Stopwatch, Timing, record
from harmonicface.surfaces.transfer import transport

ORDERS = (2, 4, 6, 8)


class Scenery:
    """A head under lights of a kind, with the exact pictures and mitsuba's."""

    def __init__(self, surface: hf.Surface, lit: dict[str, hf.Light], most: int) -> None:
        self.surface, self.labels, self.lights, self.mask = surface, list(lit), list(lit.values()), inner(surface)
        self.exact = [hf.render(surface, light, shadows=True) for light in self.lights]
        self.theirs = [oracle(surface, light, None, most)[0] for light in self.lights]

    def errors(self, surface: hf.Surface, **options: object) -> tuple[Timing, np.ndarray, np.ndarray]:
        """Return the time of a picture, and how far they are from the exact ones and from mitsuba's, one a light."""
        watch = Stopwatch(hf.render)
        pictures = [
            coloured(watch.run(lambda light=light: hf.render(surface, light, **options)))  # type: ignore[misc]
            for light in self.lights
        ]
        ours = [
            agreement(picture, [coloured(exact)] * 2, self.mask).error
            for picture, exact in zip(pictures, self.exact, strict=True)
        ]
        theirs = [
            agreement(picture, others, self.mask).error for picture, others in zip(pictures, self.theirs, strict=True)
        ]
        return watch.timing(), np.array(ours), np.array(theirs)


def rows(name: str, scenery: Scenery, kind: str, quick: bool) -> Iterator[Record]:
    """Return the table of one head under one kind of light."""
    surface = scenery.surface
    size = f"{name} {surface.shape[0]} x {surface.shape[1]}, {kind}"
    yield row("no shadows, order 2", size, 9, scenery, *scenery.errors(surface, order=2))
    yield row("no shadows, exact", size, 0, scenery, *scenery.errors(surface))
    ways = [("a mesh", surface), ("its depth map alone", replace(surface, scene=None, transports=()))]
    for way, seen in ways:
        for order in ORDERS:
            timing = transport_timing(seen, order, 1 if quick else 3)
            _, *errors = scenery.errors(seen, order=order, shadows=True)
            yield row(f"shadows of {way}, order {order}", size, (order + 1) ** 2, scenery, timing, *errors)
        yield row(f"shadows of {way}, exact", size, 0, scenery, *scenery.errors(seen, shadows=True))


def row(
    label: str, size: str, images: int, scenery: Scenery, timing: Timing, ours: np.ndarray, theirs: np.ndarray
) -> Record:
    """Return one row; the time is that of one picture, or of the transport where that is more."""
    ours, theirs = 100 * ours, 100 * theirs
    what = f"{images} images; time: {timing.name.rpartition('.')[2]}" if images else "no images; time: one picture"
    each = ", ".join(f"{name} {error:.2f}" for name, error in zip(scenery.labels, ours, strict=True))
    return record(
        label,
        size,
        timing,
        error=float(np.median(ours)),
        unit="% RMS of exact shadows', the median",
        bytes=images * int(scenery.surface.mask.sum()) * 4,
        question=size,
        note=f"{what}; {each}; against mitsuba: {np.median(theirs):.2f} % ({theirs.min():.2f} to {theirs.max():.2f})",
    )


def transport_timing(surface: hf.Surface, order: int, repeats: int) -> Timing:
    """Return the shortest time of a transport that is computed afresh."""
    watch = Stopwatch(transport)
    for _ in range(repeats):
        fresh = replace(surface, transports=())
        watch.run(lambda fresh=fresh: transport(fresh, order))  # type: ignore[misc]
    return watch.timing(min)


def records(quick: bool) -> Iterator[Record]:
    """Yield the tables of heads under natural light and under lamps."""
    everywhere = lights()
    lamps = {label: light for label, light in everywhere.items() if label.startswith("lamp")}
    natural = {label: light for label, light in everywhere.items() if label not in lamps}
    for name in ["LeePerrySmith"] if quick else ["LeePerrySmith", "ICT 0"]:
        surface = heads()[name](32 if quick else 128)
        for kind, lit in (("natural light", natural), ("one lamp", lamps)):
            some = dict(list(lit.items())[-2:]) if quick else lit
            yield from rows(name, Scenery(surface, some, MOST_QUICK), kind, quick)


if __name__ == "__main__":
    about = "one head at 32 x 32 under two lights of each kind"
    run_benchmark(__doc__, records, about, needs=DATA / "heads", seed="0, 1, ...")
