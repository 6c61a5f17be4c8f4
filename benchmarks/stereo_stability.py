"""What does photometric stereo do with hard photographs, and is it as sure as it should be? A table of cases.

python benchmarks/stereo_stability.py [--quick] [--json FILE]
"""

from __future__ import annotations

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.stereo_stability import stability_records

if __name__ == "__main__":
    run_benchmark(
        __doc__,
        lambda quick: stability_records(quick=quick),
        "without light of which nothing is said: a minute instead of five",
    )
