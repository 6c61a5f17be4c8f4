"""One small run of the benchmark, and a made-up Yale B."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import harmonicface as hf
from harmonicface.bench.benchmark import BenchmarkResult, run_benchmark

# azimuth and elevation in degrees, by subset
YALE_LIGHTS = {
    1: [(0, 0), (5, 10), (-5, 10), (-5, -10), (5, -10), (10, 0), (-10, 0)],
    2: [(15, 20), (-20, 10)],
    3: [(35, 15), (-35, 40)],
    4: [(60, 0), (-70, 20)],
    5: [(85, 20)],
}


@pytest.fixture(scope="session")
def small_run() -> BenchmarkResult:
    return run_benchmark(4, 24, 0, 1)


@pytest.fixture(scope="session")
def yale_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three synthetic people in the files of Yale B; +A lights the left of the picture."""
    root = tmp_path_factory.mktemp("yale")
    for number, surface in enumerate(hf.synthetic_people(3, (192, 168), seed=3), start=1):
        folder = root / f"yaleB{number:02d}"
        folder.mkdir()
        for azimuth, elevation in (angles for lights in YALE_LIGHTS.values() for angles in lights):
            a, e = np.radians([azimuth, elevation])
            towards = np.array([-np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
            picture = surface.albedo * np.maximum(surface.normals @ towards, 0)
            levels = np.rint(255 * np.clip(picture / 0.8, 0, 1)).astype(np.uint8)
            name = f"yaleB{number:02d}_P00A{azimuth:+04d}E{elevation:+03d}.pgm"
            Image.fromarray(levels).save(folder / name)
    return root
