"""What the tests of harmonics share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="session")
def random_directions() -> Callable[..., np.ndarray]:
    """Uniform unit vectors, (number, 3)."""

    def make(number: int, seed: int = 0) -> np.ndarray:
        vectors = np.random.default_rng(seed).normal(size=(number, 3))
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

    return make


@pytest.fixture(scope="session")
def awkward_rotations() -> dict[str, Rotation]:
    """Rotations where angles degenerate: poles, half turns, next to them, and some that are generic."""
    degrees = {"degrees": True}
    return {
        "none": Rotation.identity(),
        "half about x": Rotation.from_matrix(np.diag([1.0, -1.0, -1.0])),
        "half about y": Rotation.from_matrix(np.diag([-1.0, 1.0, -1.0])),
        "half about z": Rotation.from_matrix(np.diag([-1.0, -1.0, 1.0])),
        "half about a slanted axis": Rotation.from_rotvec(np.pi * np.array([0.6, 0.0, 0.8])),
        "half within the equator": Rotation.from_rotvec(np.pi * np.array([0.6, 0.8, 0.0])),
        "about z only": Rotation.from_euler("z", 37.3, **degrees),
        "almost about z": Rotation.from_rotvec([1e-9, -2e-9, 0.7]),
        "almost a half turn": Rotation.from_rotvec((np.pi - 1e-8) * np.array([1.0, 0.0, 0.0])),
        "a hair": Rotation.from_rotvec([1e-15, 2e-15, -1e-15]),
        "quarter about y": Rotation.from_euler("y", 90, **degrees),
        "axes in a circle": Rotation.from_matrix(np.eye(3)[[1, 2, 0]]),
        "generic": Rotation.from_euler("zyz", [111.0, 52.0, -23.0], **degrees),
        "another": Rotation.from_euler("xyz", [-71.0, 12.0, 163.0], **degrees),
    }
