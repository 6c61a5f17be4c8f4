"""The command line that the files in benchmarks/ share: `[--quick] [--json FILE]`, one table, seeds said."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from harmonicface.bench.measure import Record, write_records
from harmonicface.bench.record_table import print_records
from harmonicface.bench.spelling import spelled_seconds


def benchmark_parser(about: str | None, quick: str) -> argparse.ArgumentParser:
    """Return a parser of `--quick` and `--json`, to which a benchmark may add what it alone has.

    Parameters
    ----------
    about
        What is asked; its first line is shown by --help.
    quick
        What the quick way leaves out.
    """
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--json", metavar="FILE", help="write the records here")
    return parser


def run_benchmark(
    about: str | None,
    records: Callable[[bool], Iterable[Record]],
    quick: str,
    needs: Path | None = None,
    seed: int | str | None = None,
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
    seed
        What randomness begins with, for records that do not say it themselves.
    """
    options = benchmark_parser(about, quick).parse_args()
    if there(needs):
        finish(records(options.quick), options.json, seed)


def there(needs: Path | None) -> bool:
    """Say whether a folder of real data is there; if not, tell the reader that the benchmark is skipped."""
    if needs is None or needs.is_dir():
        return True
    print(f"skipped: no real data in {needs} (set HARMONICFACE_DATA)")
    return False


def finish(records: Iterable[Record], json: str | None, seed: int | str | None = None) -> Sequence[Record]:
    """Tell of each record as it comes, print the table of all, and write them if asked.

    Parameters
    ----------
    records
        As they are measured.
    json
        The file to write.
    seed
        For records that do not say theirs.
    """
    found = []
    for record in records:
        found.append(record if record.seed is not None else replace(record, seed=seed))
        print(f"{record.name}, {record.size}: {spelled_seconds(record.seconds)}", file=sys.stderr, flush=True)
    if found:
        print_records(found)
    if json:
        write_records(json, found)
    return found
