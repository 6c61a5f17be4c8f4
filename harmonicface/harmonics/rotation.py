"""Rotation of real harmonic coefficients by any rotation, through real Wigner matrices."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of
from harmonicface.harmonics.wigner import CACHED_DEGREE, LARGEST_DEGREE, quarter_turn

ORTHOGONALITY_TOLERANCE = 1e-5  # single precision passes, a matrix that scales or shears does not

Floats64 = NDArray[np.float64]


def rotate(coefficients: ArrayLike, rotation: Rotation | ArrayLike) -> Floats:
    r"""Rotate a function on the sphere that is given by its real harmonic coefficients.

    .. math:: f'(n) = f(R^T n), \qquad \mathrm{rotate}(c, R) \cdot Y(n) = c \cdot Y(R^T n)

    so light from direction w comes from R w afterwards. With R = Rz(beta) Ry(alpha) Rz(gamma) (the angles of
    Ramamoorthi & Hanrahan 2004, section 4.2) a turn about z mixes only the modes m and -m, and a turn about y is one
    about z between two quarter turns: Ry(alpha) = Rz(pi/2) Q Rz(alpha) Q^T Rz(-pi/2), Q = Ry(pi/2) (Pinchon & Hoggan,
    Rotation matrices for real spherical harmonics, 2007, with another swap of axes). The angles are read from the
    quaternion, so nothing is lost at the poles and at half turns. Time grows as the order cubed; memory is that
    of the largest quarter turn, 16 (order + 1)^2 bytes, and 17 MB at most for those kept.

    Parameters
    ----------
    coefficients
        ((order + 1)^2,) or ((order + 1)^2, channels), of order 1024 at most; float32 stays float32, computed in
        float64.
    rotation
        One scipy `Rotation`, or a 3 x 3 rotation matrix.

    Returns
    -------
    array
        The rotated coefficients, of the same shape.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity, a matrix that does not rotate (mirrors, scales), more
        than one rotation, an order above 1024.

    Examples
    --------
    >>> quarter = Rotation.from_euler("y", 90, degrees=True)  # from the camera, +z, to the right, +x
    >>> rotate([1.0, 0.0, 0.5, 0.0], quarter).round(6) + 0.0
    array([1. , 0. , 0. , 0.5])
    """
    given = _validate.finite(coefficients, "coefficients")
    if given.ndim not in (1, 2):
        raise HarmonicFaceError(f"coefficients: expected shape (k,) or (k, channels), got {given.shape}")
    order = _order(order_of(len(given)))
    angles = _angles(rotation)
    columns = given.reshape(len(given), -1).astype(np.float64)
    for degree in range(1, order + 1):
        inside = slice(degree**2, (degree + 1) ** 2)
        columns[inside] = _turn(columns[inside], angles)
    return columns.reshape(given.shape).astype(given.dtype, copy=False)


def rotation_blocks(rotation: Rotation | ArrayLike, order: int) -> list[Floats64]:
    r"""Return the real Wigner matrices M^l of a rotation, one orthogonal matrix a degree.

    .. math:: Y_l(R n) = M^l Y_l(n), \qquad c_l' = M^l c_l

    where c' are the coefficients of the rotated function, as `rotate` returns them; the whole rotation is
    block-diagonal. M of a product is the product of the Ms. Orthogonal to 1e-13 at order 64, for any rotation.
    Memory: 8 (order + 1) (2 order + 1) (2 order + 3) / 3 bytes, 2.9 MB at order 64, 87 MB at order 200.

    Parameters
    ----------
    rotation
        One scipy `Rotation`, or a 3 x 3 rotation matrix.
    order
        The highest degree, from 0 to 1024.

    Returns
    -------
    list
        order + 1 arrays of shapes (1, 1), (3, 3), (5, 5), ...; rows and columns m = -l ... l.

    Raises
    ------
    HarmonicFaceError
        A matrix that does not rotate, more than one rotation, another order, more than the memory holds.

    Examples
    --------
    >>> _, linear = rotation_blocks(Rotation.from_euler("z", 90, degrees=True), order=1)
    >>> linear.round(6) + 0.0  # of y, z, x: x goes to y, y to -x
    array([[ 0.,  0.,  1.],
           [ 0.,  1.,  0.],
           [-1.,  0.,  0.]])
    """
    entries = (_order(order) + 1) * (2 * order + 1) * (2 * order + 3) // 3
    _memory.require(8 * entries, f"rotation matrices up to order {order}")
    angles = _angles(rotation)
    return [_turn(np.eye(2 * degree + 1), angles) for degree in range(order + 1)]


def _turn(block: Floats64, angles: tuple[float, float, float]) -> Floats64:
    """Rotate the coefficients of one degree, (2l + 1, columns), by Rz(beta) Ry(alpha) Rz(gamma)."""
    alpha, beta, gamma = angles
    block = _about_z(block, gamma - math.pi / 2)
    block = _quarter_about_y(block, back=True)
    block = _about_z(block, alpha)
    block = _quarter_about_y(block, back=False)
    return _about_z(block, beta + math.pi / 2)


def _about_z(block: Floats64, angle: float) -> Floats64:
    """Turn about z: c'_m = cos(m angle) c_m - sin(m angle) c_-m, for m of either sign."""
    degree = len(block) // 2
    phases = (np.arange(-degree, degree + 1) * angle)[:, None]
    return np.asarray(np.cos(phases) * block - np.sin(phases) * block[::-1])


def _quarter_about_y(block: Floats64, back: bool) -> Floats64:
    """Turn by pi/2 about y, or back; cosines (m >= 0) and sines (m < 0) do not mix."""
    degree = len(block) // 2
    cosines, sines = _kept(degree) if degree <= CACHED_DEGREE else _real_quarter_turn(degree)
    result = np.empty_like(block)
    result[degree:] = (cosines.T if back else cosines) @ block[degree:]
    result[:degree] = (sines.T if back else sines) @ block[:degree]
    return result


def _real_quarter_turn(degree: int) -> tuple[Floats64, Floats64]:
    """Return Ry(pi/2) in real harmonics: among cosines m = 0 ... l, and among sines m = -l ... -1."""
    modes = np.arange(degree + 1)
    total = modes[:, None] + modes
    signed = (-1.0) ** total * quarter_turn(degree)
    parity = (-1.0) ** (degree + total)
    weights = np.where(modes, 1.0, math.sqrt(0.5))
    cosines = weights[:, None] * weights * signed * (1 + parity)
    cosines[0, 0] = signed[0, 0]  # zero for odd degrees, and not rounded at degree 0
    sines = np.ascontiguousarray((signed * (1 - parity))[:0:-1, :0:-1])
    return cosines, sines


_kept = lru_cache(maxsize=CACHED_DEGREE + 1)(_real_quarter_turn)


def _angles(rotation: Rotation | ArrayLike) -> tuple[float, float, float]:
    """Return alpha, beta, gamma of R = Rz(beta) Ry(alpha) Rz(gamma), each to full precision where it matters.

    At a pole beta - gamma (or their sum) is arbitrary, and the quaternion gives the other one exactly.
    """
    x, y, z, w = _one_rotation(rotation).as_quat()
    total, difference = 2 * math.atan2(z, w), 2 * math.atan2(-x, y)
    return 2 * math.atan2(math.hypot(x, y), math.hypot(z, w)), (total + difference) / 2, (total - difference) / 2


def _one_rotation(rotation: Rotation | ArrayLike) -> Rotation:
    """Return one scipy Rotation from whatever describes one."""
    if isinstance(rotation, Rotation):
        if not rotation.single:
            raise HarmonicFaceError(f"rotation: expected one rotation, got {len(rotation)} of them")
        return rotation
    matrix = _validate.finite(rotation, "rotation").astype(np.float64)
    if matrix.shape != (3, 3):
        raise HarmonicFaceError(f"rotation: expected a scipy Rotation or a 3 x 3 matrix, got shape {matrix.shape}")
    error = np.abs(matrix @ matrix.T - np.eye(3)).max()
    if error > ORTHOGONALITY_TOLERANCE or np.linalg.det(matrix) < 0:
        raise HarmonicFaceError(
            f"rotation: expected an orthogonal matrix of determinant 1, got determinant {np.linalg.det(matrix):.4g} "
            f"and R R^T off by {error:.2g}"
        )
    return Rotation.from_matrix(matrix)


def _order(order: int) -> int:
    """Return an order that the quarter turns reach."""
    if _validate.at_least(order, 0, "order") > LARGEST_DEGREE:
        raise HarmonicFaceError(f"order: expected at most {LARGEST_DEGREE} for rotations, got {order}")
    return int(order)
