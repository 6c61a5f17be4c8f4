"""How far is each solver off on its hard cases, and is that what it says? Right, refused with a reason, or wrong.

python benchmarks/stability.py [--quick] [--json FILE]
"""

from __future__ import annotations

import sys

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.stability.row import Outcome
from harmonicface.bench.stability.runner import stability_records


def main() -> None:
    """Print the table; end with an error if a row is wrong, or refused though it is well-posed."""
    rows: list[Outcome] = []
    run_benchmark(
        __doc__,
        lambda quick: stability_records(rows, quick=quick),
        "without photographs under unknown lights: two minutes instead of fifteen",
    )
    failed = [row for row in rows if row.verdict == "wrong" or (row.verdict, row.planned.posed) == ("refused", "well")]
    if failed:
        sys.exit("; ".join(f"{row.planned.solver}: {row.planned.case}: {row.verdict}" for row in failed))


if __name__ == "__main__":
    main()
