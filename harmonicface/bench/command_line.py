"""The command line that the files in benchmarks/ share: records are printed as they come, and written if asked."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from harmonicface.bench.measure import Record, print_records, write_records


def run_benchmark(
    about: str | None, records: Callable[[bool], Iterable[Record]], quick: str, needs: Path | None = None
) -> None:
    """Run a benchmark by `[--quick] [--json FILE]`.

    Parameters
    ----------
    about
        What is asked; its first line is shown by --help.
    records
        Makes the records; true for the quick way.
    quick
        What the quick way leaves out.
    needs
        A folder of real data; without it nothing is run, and it is said.
    """
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    if needs is not None and not needs.is_dir():
        print(f"skipped: no real data in {needs} (set HARMONICFACE_DATA)")
        return
    found = []
    for record in records(options.quick):
        print_records([record])
        sys.stdout.flush()
        found.append(record)
    if options.json:
        write_records(options.json, found)
