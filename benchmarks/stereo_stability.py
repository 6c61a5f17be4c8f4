"""What does photometric stereo do with hard photographs, and is it as sure as it should be? A table of cases.

python benchmarks/stereo_stability.py [--quick] [--json FILE]
"""

from __future__ import annotations

import argparse

from harmonicface.bench.measure import print_records, write_records
from harmonicface.bench.stereo_stability import stability_records


def main() -> None:
    """Print the table, and write it where asked to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--quick", action="store_true", help="without light of which nothing is said: a minute instead of five"
    )
    parser.add_argument("--json", metavar="FILE", help="write the records here")
    options = parser.parse_args()
    records = stability_records(quick=options.quick)
    print_records(records)
    if options.json:
        write_records(options.json, records)


if __name__ == "__main__":
    main()
