"""What is done with surfaces that are hard on numbers, and how exact is the result? A table of cases.

python benchmarks/surface_stability.py [--quick] [--json FILE]
"""

from __future__ import annotations

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.surface_stability import stability_records

if __name__ == "__main__":
    run_benchmark(__doc__, lambda _: stability_records(), "the same: all of it takes seconds")
