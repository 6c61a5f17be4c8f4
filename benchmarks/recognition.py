"""How wrong is recognition as photographs get worse, and how long does it take? Beside OpenCV's `cv2.face`, Tan-Triggs.

Settings of "default" were chosen on people 1 to 5; notes tell the error on the others alone. `occlusion.py` has more
about hidden faces.

python benchmarks/recognition.py [--quick] [--queries N] [--json FILE] [--out DIR]; DIR gets a page with the curves
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from harmonicface.bench.command_line import benchmark_parser, finish, there
from harmonicface.bench.console import progress
from harmonicface.bench.curves import CurvePoint, error_curves, lost_points
from harmonicface.bench.curves_page import write_curves_page
from harmonicface.bench.measure import Record
from harmonicface.bench.ordeals import SIZE
from harmonicface.bench.table import WRONG
from harmonicface.bench.timing import record
from harmonicface.bench.yale_contenders import YALE_METHODS
from harmonicface.bench.yale_timing import Timing, query_times
from harmonicface.datasets.yale_b import load_yale_b

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
OURS, PEER = "default", "lbph"
QUICK_PEOPLE = (1, 2, 6, 7, 8)
QUICK_METHODS = ("default", "harmonic9", "correlation", "lbph")


def curve_records(points: Sequence[CurvePoint], people: int) -> list[Record]:
    """Return one record a level: ours, beside cv2.face, and the others in the note."""
    found = []
    for ordeal, level in dict.fromkeys((point.ordeal, point.level) for point in points):
        here = {point.method: point for point in points if (point.ordeal, point.level) == (ordeal, level)}
        ours, peer = here[OURS], here[PEER]
        others = "; ".join(f"{name} {100 * point.error.value:.2f}" for name, point in here.items() if name != OURS)
        unseen = "" if ours.error_unseen is None else f"; on people 6 and up {ours.error_unseen}"
        found.append(
            record(
                f"{ordeal} {level:g}: {OURS}",
                f"{people} people {SIZE[1]}x{SIZE[0]}, {ours.asked} photographs",
                ours.timing,
                peer.timing,
                error=100 * ours.error.value,
                peer_error=100 * peer.error.value,
                unit=WRONG,
                question=ordeal,
                note=f"{ours.error}{unseen}; {others}",
            )
        )
    return found


def timing_records(timings: Sequence[Timing]) -> list[Record]:
    """Return one record a method: a query in a full gallery."""
    peer = next(timing for timing in timings if timing.method == PEER)
    return [
        record(
            f"a query: {timing.method}",
            f"{timing.people} people 168x192",
            timing.query,
            peer.query,
            bytes=round(timing.bytes_per_person),
            note="the gallery is filled up with mirrored and synthetic people, for the time alone; bytes a person",
        )
        for timing in timings
    ]


def main() -> None:
    """Run, and draw the curves if asked."""
    parser = benchmark_parser(__doc__, "five people, six photographs of each, few levels")
    parser.add_argument("--queries", type=int, default=8, help="photographs of each person (default %(default)s)")
    parser.add_argument("--out", help="write a page with the curves into this folder")
    options = parser.parse_args()
    if not there(DATA):
        return
    faces = load_yale_b(DATA, QUICK_PEOPLE if options.quick else None)
    with progress() as tell:
        asked, every = (6, 3) if options.quick else (options.queries, 1)
        points = error_curves(faces, queries=asked, every=every, progress=tell)
        methods, queries = (QUICK_METHODS, 4) if options.quick else (YALE_METHODS, 12)
        timings = query_times(faces, methods, queries=queries, progress=tell)
    finish(curve_records(points, len(faces)) + timing_records(timings), options.json, seed=0)
    for ours, best in lost_points(points, OURS):
        print(f"{ours.ordeal} {ours.level:g}: {best.method} {best.error}, {OURS} {ours.error}")
    if options.out:
        folder = Path(options.out)
        folder.mkdir(parents=True, exist_ok=True)
        print(write_curves_page(points, timings, [face.number for face in faces], folder / "curves.html").resolve())


if __name__ == "__main__":
    main()
