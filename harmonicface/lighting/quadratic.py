"""Irradiance under nine coefficients as a quadratic polynomial in the normal, for shaders and for the reader."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

# The paper prints 0.429043, 0.511664, 0.743125, 0.886227, 0.247708; exact are 0.5116634 and 0.7431239.
C1 = math.sqrt(15 / math.pi) * math.pi / 16
C2 = math.sqrt(math.pi / 3) / 2
C3 = 3 * math.sqrt(5 / math.pi) * math.pi / 16
C4 = math.sqrt(math.pi) / 2
C5 = math.sqrt(5 / math.pi) * math.pi / 16


def irradiance_matrix(coefficients: ArrayLike) -> NDArray[np.float64]:
    """Return the symmetric M with E(n) = (n, 1)^T M (n, 1).

    Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, equations 11 and 12.
    Up to order 2 nothing is approximated: the harmonics are quadratic polynomials on the sphere.

    Parameters
    ----------
    coefficients
        (9,) or (9, 3) coefficients L_lm of the light.

    Returns
    -------
    array
        (4, 4), or (3, 4, 4) with a matrix a colour.

    Raises
    ------
    HarmonicFaceError
        Another shape, anything not finite.

    Examples
    --------
    >>> ambient = [1.0, 0, 0, 0, 0, 0, 0, 0, 0]
    >>> irradiance_matrix(ambient)[3].round(6)
    array([0.      , 0.      , 0.      , 0.886227])
    """
    values = _nine(coefficients)
    l00, l1m1, l10, l11, l2m2, l2m1, l20, l21, l22 = values
    rows = [
        [C1 * l22, C1 * l2m2, C1 * l21, C2 * l11],
        [C1 * l2m2, -C1 * l22, C1 * l2m1, C2 * l1m1],
        [C1 * l21, C1 * l2m1, C3 * l20, C2 * l10],
        [C2 * l11, C2 * l1m1, C2 * l10, C4 * l00 - C5 * l20],
    ]
    return np.ascontiguousarray(np.moveaxis(np.array(rows), (0, 1), (-2, -1)))


def quadratic_irradiance(coefficients: ArrayLike, normals: ArrayLike) -> Floats:
    """Return E(n) = (n, 1)^T M (n, 1), a matrix-vector product and a dot product a normal.

    Parameters
    ----------
    coefficients
        (9,) or (9, 3) coefficients L_lm of the light.
    normals
        (..., 3) unit vectors.

    Returns
    -------
    array
        (...) irradiance, or (..., 3) under coloured light.

    Raises
    ------
    HarmonicFaceError
        Another shape of the coefficients, normals that are not finite unit vectors.

    Examples
    --------
    >>> quadratic_irradiance([1.0, 0, 0, 0, 0, 0, 0, 0, 0], [[0.0, 0.0, 1.0]]).round(6)
    array([0.886227])
    """
    matrix = irradiance_matrix(coefficients)
    unit = _validate.unit_normals(normals, "normals")
    lifted = np.concatenate([unit, np.ones_like(unit[..., :1])], axis=-1)
    result = np.einsum(
        "...i,cij,...j->...c", lifted, matrix.reshape(-1, 4, 4).astype(unit.dtype), lifted, optimize=True
    )
    return np.asarray(result if matrix.ndim == 3 else result[..., 0])


def expanded_irradiance(coefficients: ArrayLike, normals: ArrayLike) -> Floats:
    r"""Return the same written out, for machines without matrices (equation 13 of the paper).

    .. math:: E = c_1 L_{22} (x^2 - y^2) + c_3 L_{20} z^2 + c_4 L_{00} - c_5 L_{20}
              + 2 c_1 (L_{2-2} xy + L_{21} xz + L_{2-1} yz) + 2 c_2 (L_{11} x + L_{1-1} y + L_{10} z)

    Parameters
    ----------
    coefficients
        (9,) or (9, 3) coefficients L_lm of the light.
    normals
        (..., 3) unit vectors.

    Returns
    -------
    array
        (...) irradiance, or (..., 3) under coloured light.

    Raises
    ------
    HarmonicFaceError
        Another shape of the coefficients, normals that are not finite unit vectors.

    Examples
    --------
    >>> expanded_irradiance([1.0, 0, 0, 0, 0, 0, 0, 0, 0], [[0.0, 0.0, 1.0]]).round(6)
    array([0.886227])
    """
    unit = _validate.unit_normals(normals, "normals")
    values = _nine(coefficients).astype(unit.dtype)
    l00, l1m1, l10, l11, l2m2, l2m1, l20, l21, l22 = values
    x, y, z = np.moveaxis(unit, -1, 0)[..., None] if values.ndim == 2 else np.moveaxis(unit, -1, 0)
    return np.asarray(
        C1 * l22 * (x * x - y * y)
        + C3 * l20 * z * z
        + (C4 * l00 - C5 * l20)
        + 2 * C1 * (l2m2 * x * y + l21 * x * z + l2m1 * y * z)
        + 2 * C2 * (l11 * x + l1m1 * y + l10 * z)
    )


def _nine(coefficients: ArrayLike) -> Floats:
    values = _validate.finite(coefficients, "coefficients")
    if values.shape not in ((9,), (9, 3)):
        raise HarmonicFaceError(f"coefficients: expected shape (9,) or (9, 3), got {values.shape}")
    return values
