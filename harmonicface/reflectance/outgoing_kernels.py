"""What a BRDF makes of the light for each outgoing direction: its coefficients summed over that direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, degrees, modes, order_of
from harmonicface.reflectance._brdf_quadrature import Complexes, Reals, to_real_rows

EXTENSIONS = ("zero", "even", "odd")


def outgoing_kernels(brdf: ArrayLike, outgoing: ArrayLike, extension: str = "zero") -> Reals:
    r"""Return, for each outgoing direction, the coefficients of the transfer function over the incoming ones.

    .. math:: \rho_{lq}(\omega_o) = \sum_p \rho_{lpq} Y_{pq}(\omega_o) \quad\text{or}\quad
              \sum_{pq} \rho_{ln,pq} Y_{pq}(\omega_o)

    in real harmonics: the reflected light is their product with `local_light`.

    Parameters
    ----------
    brdf
        Isotropic coefficients (order + 1, outgoing_order + 1, q), or anisotropic ones
        ((order + 1)^2, (outgoing_order + 1)^2), complex.
    outgoing
        (..., 3) local unit vectors.
    extension
        How the series in the outgoing direction goes on below the horizon, where nobody looks. "zero": as the
        transfer function does; where it jumps at the horizon the series rings. "even", "odd": its mirror image, or the
        negative of that; then twice the terms with p + q even (odd) are the series and the others vanish. "even" mends
        a jump, "odd" keeps the slope of what falls to zero at the horizon.

    Returns
    -------
    array
        ((order + 1)^2, ...).

    Raises
    ------
    HarmonicFaceError
        Coefficients of another shape, directions that are no unit vectors, an unknown extension.

    Examples
    --------
    >>> outgoing_kernels(np.ones((1, 1, 1)), [0.0, 0.0, 1.0]).round(6)
    array([0.282095])
    """
    if extension not in EXTENSIONS:
        expected = ", ".join(EXTENSIONS)
        raise HarmonicFaceError(f"extension: expected one of {expected}, got {_validate.describe(extension)}")
    coefficients = brdf_array(brdf)
    outgoing_order = coefficients.shape[1] - 1 if coefficients.ndim == 3 else order_of(coefficients.shape[1])
    harmonics = np.asarray(real_harmonics(outgoing, outgoing_order), np.float64)
    flat = harmonics.reshape(len(harmonics), -1)
    if extension != "zero":
        flat = flat * parity(outgoing_order, extension)[:, None]
    if np.iscomplexobj(coefficients):
        result = real_brdf(coefficients) @ flat
    else:
        result = _isotropic_kernels(coefficients.real, flat)
    return result.reshape((-1, *harmonics.shape[1:]))


def brdf_array(brdf: ArrayLike) -> Complexes | Reals:
    """Return isotropic coefficients [l, p, q] or anisotropic ones [ln, pq], checked."""
    table = np.asarray(brdf)
    if table.ndim == 3 and table.dtype.kind in "iuf" and table.shape[2] >= min(table.shape[:2]) > 0:
        return _validate.finite(table, "brdf").astype(np.float64)
    if table.ndim == 2 and table.dtype.kind in "iufc" and np.isfinite(table).all() and table.size:
        order_of(table.shape[0])
        order_of(table.shape[1])
        return table.astype(np.complex128)
    expected = "isotropic coefficients (l, p, q) or finite anisotropic ones ((l + 1)^2, (p + 1)^2)"
    raise HarmonicFaceError(f"brdf: expected {expected}, got {_validate.describe(table)}")


def real_brdf(coefficients: Complexes | Reals) -> Reals:
    """Return anisotropic coefficients in products of two real harmonics."""
    rows = to_real_rows(coefficients.astype(np.complex128))
    real = to_real_rows(rows.conj().T).conj().T
    largest = np.abs(real).max()
    if np.abs(real.imag).max() > 1e-6 * largest:
        raise HarmonicFaceError(
            "brdf: expected coefficients of a real function, rho_l(-n),p(-q) = (-1)^(n+q) conj(rho_ln,pq), "
            f"got ones that differ by {np.abs(real.imag).max() / largest:.2g} of the largest"
        )
    return np.ascontiguousarray(real.real)


def _isotropic_kernels(coefficients: Reals, harmonics: Reals) -> Reals:
    """Return the sums over p for every (l, q), one product a mode."""
    order, outgoing_order = coefficients.shape[0] - 1, coefficients.shape[1] - 1
    result = np.zeros((count(order), harmonics.shape[1]))
    for mode in range(-min(order, outgoing_order), min(order, outgoing_order) + 1):
        low = abs(mode)
        rows = [degree * (degree + 1) + mode for degree in range(low, order + 1)]
        columns = [degree * (degree + 1) + mode for degree in range(low, outgoing_order + 1)]
        result[rows] = coefficients[low:, low:, low] @ harmonics[columns]
    return result


def parity(order: int, extension: str) -> Reals:
    """Return 2 for harmonics that have the symmetry about the horizon, 0 for the others."""
    odd = (degrees(order) + modes(order)) % 2
    return np.where(odd == (extension == "odd"), 2.0, 0.0)
