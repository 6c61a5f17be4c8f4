"""Draw the README's first picture: python scripts/readme_pictures.py docs."""

from __future__ import annotations

import argparse
from pathlib import Path

from harmonicface.bench.benchmark import run_benchmark
from harmonicface.bench.pictures import explanations_picture
from harmonicface.io.files import replacing

TIERS = ("side", "natural", "noise", "extreme")


def main() -> None:
    """Recognize 100 people at 128 x 128 and show how photographs under four kinds of light are explained."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="where recognized.png goes")
    options = parser.parse_args()
    result = run_benchmark(faces=100, size=128, seed=1, queries=1, methods=["harmonic9"])
    with replacing(options.folder / "recognized.png") as temporary:
        temporary.write_bytes(explanations_picture(result, TIERS))


if __name__ == "__main__":
    main()
