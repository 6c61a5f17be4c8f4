"""Transport: its shapes, and that a saved Surface keeps it."""

from pathlib import Path

import numpy as np
import pytest

from harmonicface import HarmonicFaceError, Surface
from harmonicface.surfaces.transport import Transport


def wall(**known: object) -> Surface:
    return Surface(np.tile([0.0, 0.0, 1.0], (2, 3, 1)), np.ones((2, 3)), **known)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        (np.zeros(9), r"expected shape \(k, p\)"),
        (np.zeros((9, 6, 2)), r"expected shape \(k, p\)"),
        (np.zeros((8, 6)), r"expected .*\(order \+ 1\)"),
        (np.full((9, 6), np.nan), "finite"),
    ],
)
def test_another_shape_is_refused(values: np.ndarray, reason: str) -> None:
    with pytest.raises(HarmonicFaceError, match=reason):
        Transport(values)


def test_less_than_no_bounce_is_refused() -> None:
    with pytest.raises(HarmonicFaceError, match="bounces: expected"):
        Transport(np.zeros((9, 6)), bounces=-1)


def test_transport_of_other_pixels_is_refused() -> None:
    with pytest.raises(HarmonicFaceError, match="expected 6 pixels as in the mask, got 5"):
        wall(transports=[Transport(np.zeros((9, 5)))])


def test_a_saved_surface_keeps_its_transports_bit_for_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    direct = Transport(rng.standard_normal((25, 6)).astype(np.float32))
    coloured = Transport(rng.standard_normal((9, 6, 3)), bounces=2)
    wall(transports=[direct, coloured]).save(tmp_path / "wall.npz")
    read = Surface.load(tmp_path / "wall.npz").transports
    assert sorted(read) == [0, 2]
    for before, after in ((direct, read[0]), (coloured, read[2])):
        assert before.values.dtype == after.values.dtype
        np.testing.assert_array_equal(before.values, after.values)


def test_a_saved_transport_of_other_pixels_is_refused(tmp_path: Path) -> None:
    surface = wall()
    surface.transports[0] = Transport(np.zeros((9, 5)))
    surface.save(tmp_path / "wall.npz")
    with pytest.raises(HarmonicFaceError, match=r"wall\.npz: transport: expected 6 pixels"):
        Surface.load(tmp_path / "wall.npz")
