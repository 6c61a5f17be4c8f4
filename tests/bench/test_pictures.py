"""The report's pictures are pictures, and show what they are asked for."""

from __future__ import annotations

import io

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from harmonicface.bench import pictures
from harmonicface.bench.benchmark import BenchmarkResult
from harmonicface.bench.measure import Record
from harmonicface.bench.table import method_records


def decoded(png: bytes) -> np.ndarray:
    assert png.startswith(b"\x89PNG")
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def colours(picture: np.ndarray) -> int:
    return len(np.unique(picture.reshape(-1, 3), axis=0))


def test_every_picture_is_drawn(small_run: BenchmarkResult) -> None:
    assert colours(decoded(pictures.lights_picture(small_run))) > 100
    assert colours(decoded(pictures.harmonics_picture(small_run.people[0].surface))) > 100
    assert colours(decoded(pictures.explanations_picture(small_run))) > 100
    assert colours(decoded(pictures.tradeoff_picture(method_records(small_run)))) > 10


def test_chosen_tiers_alone_are_explained(small_run: BenchmarkResult) -> None:
    everything = decoded(pictures.explanations_picture(small_run))
    one = decoded(pictures.explanations_picture(small_run, ["side"]))
    assert one.shape[1] == everything.shape[1]
    assert one.shape[0] < everything.shape[0] / 3


def test_a_method_is_a_point() -> None:
    accent = np.array([0xC8, 0x55, 0x3D])
    shown = [decoded(pictures.tradeoff_picture([Record(name, "", 1.0, 3.0)])) for name in ("harmonic9", "lbph")]
    painted = [(picture == accent).all(axis=2).sum() for picture in shown]
    assert painted[0] > 50
    assert painted[1] == 0


def test_the_ball_is_round_and_faces_the_camera() -> None:
    ball = pictures.white_ball(40)
    assert_allclose(ball.mask.mean(), np.pi / 4, atol=0.01)
    assert_allclose(np.linalg.norm(ball.pixel_normals, axis=1), 1, rtol=1e-12)
    assert ball.normals[3, 20, 1] > 0.7  # row 0 is up
    assert ball.normals[20, 36, 0] > 0.7
    assert (ball.pixel_normals[:, 2] > 0).all()


@pytest.mark.parametrize(("count", "expected"), [(1, [0]), (3, [0, 5, 10]), (99, list(range(11)))])
def test_a_few_are_spread_over_all(count: int, expected: list[int]) -> None:
    assert pictures._spread(list(range(11)), count) == expected  # type: ignore[arg-type]
