"""How far is each solver off on its hard cases, and is that what it says? Right, refused with a reason, or wrong.

python benchmarks/stability.py [--quick] [--json FILE]
"""

from __future__ import annotations

import sys

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.stability.row import Outcome
from harmonicface.bench.stability.runner import stability_records

MOST_REFUSED = 0.2


def main() -> None:
    """Print the table; end with an error if a row is wrong, or refused though it is well-posed, or too many are."""
    rows: list[Outcome] = []
    run_benchmark(
        __doc__,
        lambda quick: stability_records(rows, quick=quick),
        "without photographs under unknown lights: a minute and a half instead of ten",
    )
    failed = [row for row in rows if row.verdict == "wrong" or (row.verdict, row.planned.posed) == ("refused", "well")]
    if failed:
        sys.exit("; ".join(f"{row.planned.solver}: {row.planned.case}: {row.verdict}" for row in failed))
    refused = sum(row.verdict == "refused" for row in rows)
    if refused > MOST_REFUSED * len(rows):
        sys.exit(f"{refused} of {len(rows)} rows are refused, more than {MOST_REFUSED:.0%}")


if __name__ == "__main__":
    main()
