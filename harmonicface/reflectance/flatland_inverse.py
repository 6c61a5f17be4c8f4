"""Flatland backwards: light, material, or both from a reflected light field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.flatland_series import FULL, series

Masked = np.ma.MaskedArray[Any, np.dtype[Any]]
NOTHING = 1e-12  # of the largest coefficient: what rounding leaves of an exact zero


def flat_light(reflected: ArrayLike, transfer: ArrayLike) -> Masked:
    r"""Return the light from a light field of a known material, (2 order + 1,), masked where the material hides it.

    .. math:: L_l = \frac{1}{\sqrt{2\pi}} \frac{\sum_p \hat\rho_{lp}^* B_{lp}}{\sum_p |\hat\rho_{lp}|^2}

    Ramamoorthi & Hanrahan 2004, equation 21 solved for L_l (the twin of equation 59), over all p by least squares. A
    matte surface hides the odd degrees above 1.

    Parameters
    ----------
    reflected
        (2 order + 1, ...) coefficients B_lp.
    transfer
        (2 order + 1, ...) coefficients rho_lp, of the same shape.

    Raises
    ------
    HarmonicFaceError
        A light field and a material of different shapes, NaN or infinity.

    Examples
    --------
    >>> print(flat_light([2.0, 0.0, 4.0], np.array([1.0, 0.0, 1.0]) / np.sqrt(2 * np.pi)).round(6))
    [2.0 -- 4.0]
    """
    field, material = series(reflected, "reflected"), series(transfer, "transfer")
    if field.shape != material.shape:
        raise HarmonicFaceError(
            f"reflected: expected the transfer's shape {material.shape}, got {_validate.describe(field)}"
        )
    field, material = field.reshape(len(field), -1), material.reshape(len(material), -1)
    power = (np.abs(material) ** 2).sum(axis=1)
    told = power > NOTHING**2 * power.max()
    values = np.zeros(len(field), np.result_type(field, material))
    np.divide((material.conj() * field).sum(axis=1), FULL * power, out=values, where=told)
    return np.ma.MaskedArray(values, ~told)


def flat_transfer(reflected: ArrayLike, light: ArrayLike) -> Masked:
    r"""Return the material from a light field under known light, masked where the light holds nothing.

    rho_lp = B_lp / (sqrt(2 pi) L_l): Ramamoorthi & Hanrahan 2004, equation 21 solved for rho_lp (the twin of equation
    58). One direction of light tells all of it, uniform light only l = 0.

    Parameters
    ----------
    reflected
        (2 order + 1, ...) coefficients B_lp.
    light
        (2 order + 1,) coefficients L_l.

    Raises
    ------
    HarmonicFaceError
        Light of another order, NaN or infinity.

    Examples
    --------
    >>> print(flat_transfer(np.sqrt(2 * np.pi) * np.array([2.0, 0.0, 4.0]), [1.0, 0.0, 2.0]))
    [2.0 -- 2.0]
    """
    field, known = series(reflected, "reflected"), series(light, "light")
    if known.ndim != 1 or len(known) != len(field):
        raise HarmonicFaceError(f"light: expected {len(field)} degrees, got {_validate.describe(known)}")
    told = np.abs(known) > NOTHING * np.abs(known).max()
    rows = known.reshape(-1, *[1] * (field.ndim - 1))
    seen = np.broadcast_to(told.reshape(rows.shape), field.shape)
    values = np.zeros(field.shape, np.result_type(field, known))
    np.divide(field, FULL * rows, out=values, where=seen)
    return np.ma.MaskedArray(values, ~seen)


@dataclass(frozen=True, eq=False)
class FlatFactors:
    """Light and material of a light field, up to one common scale.

    Attributes
    ----------
    light
        (2 order + 1,) L_l with L_0 = 1 / sqrt(2 pi); masked where the light field does not tell it.
    transfer
        (2 order + 1, 2 order + 1) reciprocal rho_lp; masked likewise.
    lost
        The degrees |l| whose light is not told: there the factorization is ill-posed.
    """

    light: Masked
    transfer: Masked
    lost: tuple[int, ...]


def factorize_flat(reflected: ArrayLike, tolerance: float = NOTHING) -> FlatFactors:
    r"""Return light and material from a light field alone, by reciprocity.

    The field is that of the reciprocal form, B cos(theta_o) with rho cos(theta_i) cos(theta_o), so that
    rho_lp = rho_(-p)(-l) and

    .. math:: B_{lp} L_{-p} = B_{-p,-l} L_l

    for all l and p (Ramamoorthi & Hanrahan 2004, section 5.1.3, does this on the sphere with one coefficient for each
    degree; all of them are used here, as one homogeneous linear system whose null vector is the light).

    Parameters
    ----------
    reflected
        (2 order + 1, 2 order + 1) coefficients B_lp of the reciprocal light field.
    tolerance
        What counts as 0, as a fraction of the largest coefficient: the relative noise.

    Returns
    -------
    FlatFactors

    Raises
    ------
    HarmonicFaceError
        No square matrix of 2 order + 1 degrees, NaN or infinity, a light field whose degree 0 is nothing.
    """
    field = series(reflected, "reflected")
    if field.ndim != 2 or field.shape[0] != field.shape[1]:
        raise HarmonicFaceError(f"reflected: expected as many degrees l as p, got {_validate.describe(field)}")
    order = len(field) // 2
    pairs = field[:, ::-1].astype(np.complex128)  # (a, b) = (l, -p): L_a times a symmetric matrix
    seen = np.abs(pairs) > _validate.fraction(tolerance, "tolerance") * np.abs(pairs).max()
    if not seen[order].any():
        raise HarmonicFaceError("reflected: expected a degree l = 0 that is not nothing, got 0")
    components = connected_components(seen & seen.T, directed=False)[1]
    joined = components == components[order]
    dark = ~joined & seen[joined].any(axis=0)  # the material answers there, the light sends nothing
    light = np.zeros(len(field), np.complex128)
    light[joined] = _null_vector(pairs[np.ix_(joined, joined)])
    light /= light[order] * FULL
    rows = np.zeros_like(pairs)
    np.divide(pairs, FULL * light[:, None], out=rows, where=joined[:, None])
    both = joined[:, None] & joined
    known = joined[:, None] | joined
    symmetric = np.where(both, (rows + rows.T) / 2, rows + rows.T)
    told = joined | dark
    lost = tuple(sorted({abs(int(place) - order) for place in np.flatnonzero(~told)}))
    return FlatFactors(np.ma.MaskedArray(light, ~told), np.ma.MaskedArray(symmetric[:, ::-1], ~known[:, ::-1]), lost)


def _null_vector(pairs: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the light with pairs_ab light_b = pairs_ba light_a, by the smallest singular vector."""
    first, second = np.triu_indices(len(pairs), 1)
    rows = np.arange(len(first))
    system = np.zeros((max(len(first), 1), len(pairs)), np.complex128)
    system[rows, second] = pairs[first, second]
    system[rows, first] = -pairs[second, first]
    return np.asarray(np.linalg.svd(np.linalg.qr(system, mode="r"))[2][-1].conj())
