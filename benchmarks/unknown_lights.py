"""Unknown lamps: how far normals and light directions are from the measured ones, nothing of the light being told.

DiLiGenT: mean angular error of the normals, with directions unknown (intensities divided out) and with nothing known,
beside the robust solver under the measured lamps and the best classical figures published for nothing known. Yale B:
mean error of the light directions from subsets 1 to 3, registered first, told that it is a face, beside the error of
always answering straight ahead. Settings were chosen on renderings of other things; the pooling with the mean face on
Yale B people 1 to 5.

python benchmarks/unknown_lights.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, once, record
from harmonicface.datasets.diligent import load_diligent
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.stereo.known.robust import robust_normals
from harmonicface.stereo.lamps.lamps import Lamps
from harmonicface.stereo.lamps.unknown_directions import unknown_directions
from harmonicface.stereo.lamps.unknown_lamps import unknown_lamps
from harmonicface.stereo.registration import register

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
PUBLISHED = {"ballPNG": 4.77, "bearPNG": 9.07, "catPNG": 9.54, "readingPNG": 24.18}  # the best classical, nothing known
NORMALS = "degrees between normals, the mean"
BORDER = 4  # pixels that registration may have moved in


def degrees_between(found: ArrayLike, truth: ArrayLike) -> float:
    """Return the mean angle between vectors in degrees."""
    one, other = (np.asarray(vectors, np.float64) for vectors in (found, truth))
    one, other = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (one, other))
    return float(np.degrees(np.arccos(np.clip((one * other).sum(axis=1), -1, 1))).mean())


def diligent_rows(folder: Path) -> Iterator[Record]:
    """Solve one object three times: lamps known, directions unknown, nothing known."""
    thing = load_diligent(folder)
    seen, even, measured = thing.grey(divided=False), thing.grey(), thing.normals.any(axis=1)
    truth = thing.normals[measured]
    size = f"{len(seen)} x {seen.shape[1]}"
    name = folder.name.removesuffix("PNG")
    timing, known = once(Call(partial(robust_normals, even, thing.directions)))
    error = degrees_between(known.scaled[measured], truth)
    yield record(f"{name}, lamps known", size, timing, error=error, unit=NORMALS, question=name)
    timing, found = once(Call(partial(unknown_directions, even, thing.mask)))
    note = f"light directions {degrees_between(found.lights, thing.directions):.2f}"
    error = degrees_between(found.pixels.scaled[measured], truth)
    yield record(f"{name}, directions unknown", size, timing, error=error, unit=NORMALS, question=name, note=note)
    timing, found = once(Call(partial(unknown_lamps, seen, thing.mask)))
    note = f"light directions {degrees_between(found.lights, thing.directions):.2f}"
    note += f"; best classical {PUBLISHED.get(folder.name, float('nan'))}; {found.ambiguity.name}"
    error = degrees_between(found.pixels.scaled[measured], truth)
    yield record(f"{name}, nothing known", size, timing, error=error, unit=NORMALS, question=name, note=note)


def yale_row(number: int) -> Record:
    """Find the light directions of one person's photographs of subsets 1 to 3."""
    person = load_yale_b(DATA / "yaleb", [number])[0]
    chosen = person.subsets <= 3
    mask = np.zeros(person.photographs.shape[1:], bool)
    mask[BORDER:-BORDER, BORDER:-BORDER] = True

    def solve() -> Lamps:
        photographs = register(person.photographs[chosen]).photographs
        return unknown_lamps(photographs[:, mask], mask, face=True, saturation=0.999, method="least_squares")

    timing, found = once(Call(solve, register, unknown_lamps))
    truth = person.lights[chosen]
    ahead = degrees_between(np.tile([0.0, 0.0, 1.0], (len(truth), 1)), truth)
    note = f"always straight ahead: {ahead:.1f}; {found.ambiguity.reason}"
    size = f"{len(truth)} x {mask.sum()}"
    error = degrees_between(found.lights, truth)
    return record(f"Yale B {number}", size, timing, error=error, unit="degrees between lights, the mean", note=note)


def records(quick: bool) -> Iterator[Record]:
    """Yield all rows; the quick ones are the ball and two people."""
    folders = sorted((DATA / "diligent").glob("*PNG"))
    for folder in folders[:1] if quick else folders:
        yield from diligent_rows(folder)
    for number in (6, 7) if quick else range(1, 12):
        yield yale_row(number)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "the ball, and two people", needs=DATA)
