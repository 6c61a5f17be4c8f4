"""Run every benchmark, and write what was found: a JSON file each, results.md, index.html with all plots and tables.

python scripts/run_benchmarks.py [NAME...] [--out DIR] [--quick | --full] [--limit SECONDS]
"""

from __future__ import annotations

import argparse
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

from harmonicface.bench.suite import benchmarks_in, run_suite
from harmonicface.bench.suite_page import Run, write_suite
from harmonicface.errors import HarmonicFaceError

FOLDER = Path(__file__).resolve().parents[1] / "benchmarks"
IN_FULL = (  # within about a minute and a half each on two cores; the others take minutes to half an hour
    "brdf",
    "environment",
    "harmonics",
    "inverse_light",
    "match",
    "materials",
    "principal",
    "stereo",
)


def main() -> int:
    """Run, and return 1 if a benchmark failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("names", nargs="*", help="some of the benchmarks (default: all)")
    parser.add_argument("--out", type=Path, default=FOLDER / "results", help="folder to write (default: %(default)s)")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="all of them quickly: about ten minutes")
    size.add_argument("--full", action="store_true", help="all of them in full: hours")
    parser.add_argument(
        "--limit", type=float, help="seconds that a benchmark may take (default: 300, with --full none)"
    )
    options = parser.parse_args()
    started, start = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"), time.perf_counter()
    try:
        files = benchmarks_in(FOLDER, options.names)
        options.out.mkdir(parents=True, exist_ok=True)
        ran = run_suite(
            files,
            options.out,
            lambda name: not options.full and (options.quick or name not in IN_FULL),
            options.limit or (86400.0 if options.full else 300.0),
            lambda line: print(line, file=sys.stderr, flush=True),
        )
        run = Run(ran, started, time.perf_counter() - start)
        print(f"{run.summary}\n{write_suite(run, options.out).resolve()}")
    except HarmonicFaceError as error:
        parser.exit(1, f"{error}\n")
    return int(any(one.state == "failed" for one in ran))


if __name__ == "__main__":
    sys.exit(main())
