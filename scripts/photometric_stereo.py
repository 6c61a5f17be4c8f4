"""Find a surface in photographs under different lights: python scripts/photometric_stereo.py IMAGES... --out DIR."""

from __future__ import annotations

import sys

from harmonicface.cli import main

if __name__ == "__main__":
    sys.argv.insert(1, "stereo")
    main()
