"""Unknown lamps: how far normals and light directions are from the measured ones, nothing of the light being told.

DiLiGenT: mean angular error of the normals, with directions unknown (intensities divided out) and with nothing known,
beside the robust solver under the measured lamps and the best classical figures published for nothing known. Yale B:
mean error of the light directions from subsets 1 to 3, registered first, told that it is a face, beside the error of
always answering straight ahead. Settings were chosen on renderings of other things; the pooling with the mean face on
Yale B people 1 to 5.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from harmonicface.bench.measure import Record, print_records, write_records
from harmonicface.datasets.diligent import load_diligent
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.stereo.registration import register
from harmonicface.stereo.robust import robust_normals
from harmonicface.stereo.unknown_directions import unknown_directions
from harmonicface.stereo.unknown_lamps import unknown_lamps

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
PUBLISHED = {"ballPNG": 4.77, "bearPNG": 9.07, "catPNG": 9.54, "readingPNG": 24.18}  # the best classical, nothing known
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
    start = time.perf_counter()
    known = degrees_between(robust_normals(even, thing.directions).scaled[measured], truth)
    name = folder.name.removesuffix("PNG")
    yield Record(f"{name}, lamps known", size, time.perf_counter() - start, error=known, note="degrees, normals")
    start = time.perf_counter()
    found = unknown_directions(even, thing.mask)
    note = f"degrees, normals; light directions {degrees_between(found.lights, thing.directions):.2f}"
    error = degrees_between(found.pixels.scaled[measured], truth)
    yield Record(f"{name}, directions unknown", size, time.perf_counter() - start, error=error, note=note)
    start = time.perf_counter()
    found = unknown_lamps(seen, thing.mask)
    seconds = time.perf_counter() - start
    note = f"degrees, normals; light directions {degrees_between(found.lights, thing.directions):.2f}"
    note += f"; best classical {PUBLISHED.get(folder.name, float('nan'))}; {found.ambiguity.name}"
    error = degrees_between(found.pixels.scaled[measured], truth)
    yield Record(f"{name}, nothing known", size, seconds, error=error, note=note)


def yale_row(number: int) -> Record:
    """Find the light directions of one person's photographs of subsets 1 to 3."""
    person = load_yale_b(DATA / "yaleb", [number])[0]
    chosen = person.subsets <= 3
    start = time.perf_counter()
    photographs = register(person.photographs[chosen]).photographs
    mask = np.zeros(photographs.shape[1:], bool)
    mask[BORDER:-BORDER, BORDER:-BORDER] = True
    found = unknown_lamps(photographs[:, mask], mask, face=True, saturation=0.999, method="least_squares")
    seconds = time.perf_counter() - start
    truth = person.lights[chosen]
    ahead = degrees_between(np.tile([0.0, 0.0, 1.0], (len(truth), 1)), truth)
    note = f"degrees, light directions; always straight ahead: {ahead:.1f}; {found.ambiguity.reason}"
    size = f"{len(truth)} x {mask.sum()}"
    return Record(f"Yale B {number}", size, seconds, error=degrees_between(found.lights, truth), note=note)


def records(quick: bool) -> Iterator[Record]:
    """Yield all rows; the quick ones are the ball and two people."""
    folders = sorted((DATA / "diligent").glob("*PNG"))
    for folder in folders[:1] if quick else folders:
        yield from diligent_rows(folder)
    for number in (6, 7) if quick else range(1, 12):
        yield yale_row(number)


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the ball, and two people")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    if not DATA.is_dir():
        print(f"skipped: no data in {DATA} (set HARMONICFACE_DATA)")
        return
    found = []
    for record in records(options.quick):
        print_records([record])
        found.append(record)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
