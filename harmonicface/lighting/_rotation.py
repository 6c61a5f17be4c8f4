"""What counts as a rotation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

TOLERANCE = 1e-5  # single precision passes


def rotation_matrix(rotation: Any) -> NDArray[np.float64]:
    """Return a scipy Rotation or a 3 x 3 matrix as a matrix; it must be orthogonal with determinant 1 to 1e-5."""
    given = rotation.as_matrix() if isinstance(rotation, Rotation) else rotation
    matrix = _validate.finite(given, "rotation").astype(np.float64)
    if matrix.shape != (3, 3):
        raise HarmonicFaceError(f"rotation: expected one rotation or a 3 x 3 matrix, got shape {matrix.shape}")
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > TOLERANCE or np.linalg.det(matrix) < 0:
        raise HarmonicFaceError("rotation: expected an orthogonal matrix of determinant 1, got another")
    return matrix
