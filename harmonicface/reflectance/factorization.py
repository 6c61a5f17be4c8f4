"""Light and material together from the light field that they made, up to one global scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._checked import numbers
from harmonicface.harmonics.complex import to_real
from harmonicface.harmonics.indexing import degrees, order_of
from harmonicface.reflectance._brdf_quadrature import Reals
from harmonicface.reflectance.spectra import degree_norms

ROUNDING = 1e-7
VANISHING = 0.01  # a light is known to vanish at a degree if this fraction of its constant part would be seen there


@dataclass(frozen=True)
class Factorization:
    """What a light field says of the light and of the material that made it.

    Parameters
    ----------
    light
        ((order + 1)^2,) real coefficients, scaled so that the constant one is 1 / sqrt(4 pi).
    brdf
        (order + 1, outgoing_order + 1, q) isotropic coefficients of the reciprocal form, for q >= 0.
    light_known, brdf_known
        Which of them the light field determines, of the same shapes; the others are 0.
    ill_posed
        The degrees l at which light, or material, or both are not determined, each with the reason.
    residual
        How far the light field is from that of this light and this material: relative L2.
    """

    light: Reals
    brdf: Reals
    light_known: NDArray[np.bool_]
    brdf_known: NDArray[np.bool_]
    ill_posed: dict[int, str]
    residual: float


def factor_light_field(
    coefficients: ArrayLike, tolerance: float = 1e-9, allow_ill_posed: bool = False
) -> Factorization:
    r"""Find the light and the reciprocal isotropic BRDF whose light field this is.

    .. math:: B_{lmpq} = \Lambda_l L_{lm} \rho_{lpq}, \qquad \rho_{lpq} = \rho_{plq}

    At every degree l the light field is a product of a vector over m and one over (p, q), found as the best one by
    singular values; that leaves one scale a degree. Reciprocity ties them: the scales of l and p follow from each other
    wherever rho_lpq does not vanish for some q, and the logarithms of all scales are found together by weighted least
    squares. With p = q = 0 alone this is the closed form of the paper (Ramamoorthi & Hanrahan 2004, section 5.1.3),
    L_lm = B_lm00 / (Lambda_l B_00l0), rho_lpq = B_lmpq B_00l0 / B_lm00, which needs every rho_l00. What stays
    undetermined is one factor, which is taken from the light, and what the result names as ill-posed.

    Parameters
    ----------
    coefficients
        ((order + 1)^2, outgoing_order + 1, min + 1) of B cos(theta_o), for q >= 0, from `light_field` or
        `project_light_field`.
    tolerance
        The noise of a coefficient, as a fraction of the largest one: what is smaller counts as vanishing, and a
        residual of more than three times this noise is no noise.
    allow_ill_posed
        Return what is determined, and name the rest, instead of an error.

    Returns
    -------
    Factorization
        Light and BRDF; multiply the one and divide the other by any factor, and it is as good.

    Raises
    ------
    HarmonicFaceError
        "ill-posed at l = ...": a degree that vanishes, or that reciprocity does not tie to l = 0. Also a light field
        that is not one of a real light, without a constant part, no product, or not of a reciprocal BRDF.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Phong
    >>> from harmonicface.reflectance.brdf_coefficients import isotropic_coefficients
    >>> from harmonicface.reflectance.lightfield import light_field
    >>> light = np.array([1.0, 0.1, 0.2, -0.3, 0.0, 0.1, 0.2, 0.3, 0.1])
    >>> found = factor_light_field(light_field(light, isotropic_coefficients(Phong(20), order=2)))
    >>> bool(np.allclose(found.light / found.light[0], light, atol=1e-12))
    True
    """
    fields = _fields(coefficients)
    unit = 2.0 ** np.floor(np.log2(np.abs(fields).max()))  # so that squares stay numbers; no digit changes
    fields = fields / unit
    order = order_of(len(fields))
    noise = _validate.fraction(tolerance, "tolerance") * np.abs(fields).max()
    if np.abs(fields[0]).max() <= noise:
        raise HarmonicFaceError("light field: ill-posed at l = 0: expected a light with a constant part, got none")
    rows = _products(fields)
    strengths = np.array([np.abs(fields[degree**2 : (degree + 1) ** 2]).max() for degree in range(order + 1)])
    ratios, weights = _links(rows, strengths, noise)
    tied = _reached(weights)
    brdf = rows * _scales(ratios, weights, tied)[:, None, None]
    brdf, brdf_known = _reciprocal(brdf, _light_of(fields, brdf), tied)
    light = _light_of(fields, brdf, tied)
    light_known = tied[degrees(order)]
    ill_posed = {}
    for degree in np.flatnonzero(~tied):
        faint = VANISHING * np.abs(light[0]) * degree_norms(order)[degree] * np.abs(brdf[degree]).max()
        answers = faint > noise  # a light so faint would still be seen
        ill_posed[int(degree)] = _reason(bool(strengths[degree] > noise), bool(answers))
        light_known[degree**2 : (degree + 1) ** 2] = strengths[degree] <= noise and answers
    scale = light[0] * np.sqrt(4 * np.pi)
    light, brdf = light / scale, brdf * scale
    residual, allowed = _residual(fields, light, brdf, tied), 3 * noise * _in_norms(np.ones_like(fields), fields)
    if residual > max(allowed, ROUNDING):
        raise HarmonicFaceError(
            "light field: expected that of one light and one reciprocal isotropic BRDF, B cos(theta_o), "
            f"got one that is off by {residual:.2g} in relative L2, more than {allowed:.2g} for this tolerance"
        )
    if ill_posed and not allow_ill_posed:
        raise HarmonicFaceError(f"light field: {_told(ill_posed)}")
    return Factorization(light, unit * brdf, light_known, brdf_known, ill_posed, residual)


def _fields(coefficients: ArrayLike) -> Reals:
    """Return B in real harmonics of the light, (k, p, q), checked."""
    given = numbers(coefficients, "light field")
    if given.ndim != 3 or given.dtype.kind not in "iufc" or given.size == 0 or not np.isfinite(given).all():
        raise HarmonicFaceError(
            f"light field: expected finite coefficients (lm, p, q), got {_validate.describe(given)}"
        )
    order, outgoing_order = order_of(len(given)), given.shape[1] - 1
    if given.shape[2] != min(order, outgoing_order) + 1:
        raise HarmonicFaceError(
            f"light field: expected {min(order, outgoing_order) + 1} modes q, got shape {given.shape}"
        )
    if not given.any():
        raise HarmonicFaceError("light field: expected one that is not dark, got zeros")
    return np.where(_pattern(order, outgoing_order)[degrees(order)], to_real(given), 0.0)


def _pattern(order: int, outgoing_order: int) -> NDArray[np.bool_]:
    """Return where q <= min(l, p), (l, p, q)."""
    modes = np.arange(min(order, outgoing_order) + 1)
    lowest = np.minimum(np.arange(order + 1)[:, None], np.arange(outgoing_order + 1))
    return np.asarray(modes <= lowest[..., None])


def _doubled(modes: int) -> Reals:
    """Return how often each q >= 0 stands in the light field: twice, as q and -q, but for 0."""
    return np.where(np.arange(modes) > 0, 2.0, 1.0)


def _products(fields: Reals) -> Reals:
    """Return the unit (p, q) vector of the product nearest to the light field at each degree, (l, p, q)."""
    weights = np.sqrt(_doubled(fields.shape[2]))
    result = np.zeros((order_of(len(fields)) + 1, *fields.shape[1:]))
    for degree in range(len(result)):
        rows = fields[degree**2 : (degree + 1) ** 2] * weights
        _, _, right = np.linalg.svd(rows.reshape(len(rows), -1), full_matrices=False)
        result[degree] = right[0].reshape(fields.shape[1:]) / weights
    return result


def _links(rows: Reals, strengths: Reals, noise: float) -> tuple[Reals, Reals]:
    """Return, for degrees l and p that reciprocity ties, scale of p over scale of l and the weight of its logarithm."""
    size = min(rows.shape[:2])
    across = rows[:size, :size]
    back = across.transpose(1, 0, 2)
    heights = strengths[:size, None] * np.abs(across).max(axis=2)
    usable = (heights > noise) & (heights > noise).T & ~np.eye(size, dtype=bool)
    ratios, weights = np.zeros((2, len(rows), len(rows)))
    doubled = _doubled(rows.shape[2])
    norms = np.sqrt((across**2 * doubled).sum(axis=2))
    signs = np.where((across * back * doubled).sum(axis=2) < 0, -1.0, 1.0)
    ratios[:size, :size] = signs * np.divide(norms, norms.T, out=np.zeros_like(norms), where=usable)
    precision = 1 / np.where(usable, heights, 1) ** 2
    weights[:size, :size] = np.where(usable, 1 / (precision + precision.T), 0)
    return ratios, weights


def _reached(weights: Reals) -> NDArray[np.bool_]:
    """Return which degrees are tied to l = 0."""
    _, parts = connected_components(weights > 0, directed=False)
    return np.asarray(parts == parts[0])


def _scales(ratios: Reals, weights: Reals, tied: NDArray[np.bool_]) -> Reals:
    """Return the factor of each degree that is tied to l = 0, and 0 of the others: signs first, then logarithms."""
    signs = np.zeros(len(ratios))
    signs[0] = 1.0
    while (signs[tied] == 0).any():  # along the strongest ties
        reach = np.where((signs[:, None] != 0) & (signs == 0), weights, 0)
        known, new = np.unravel_index(reach.argmax(), reach.shape)
        signs[new] = signs[known] * np.sign(ratios[known, new])
    inner = np.flatnonzero(tied)
    held = weights[np.ix_(inner, inner)]
    held = np.where(held > 0, np.maximum(held, 1e-10 * held.max()), 0)
    steps = np.log(np.abs(np.where(held > 0, ratios[np.ix_(inner, inner)], 1.0)))
    laplacian = np.diag(held.sum(axis=1)) - held
    pull = (held * steps).sum(axis=0)
    logarithms = np.zeros(len(ratios))
    if len(inner) > 1:
        balance = 1 / np.sqrt(np.diag(laplacian)[1:])
        system = laplacian[1:, 1:] * balance * balance[:, None]
        logarithms[inner[1:]] = balance * np.linalg.solve(system, balance * pull[1:])
    return np.asarray(signs * np.exp(logarithms))


def _light_of(fields: Reals, brdf: Reals, tied: NDArray[np.bool_] | None = None) -> Reals:
    """Return the light that fits the light field best if the BRDF is this, 0 where that has no answer."""
    order = len(brdf) - 1
    doubled = _doubled(brdf.shape[2])
    energies = (brdf**2 * doubled).sum(axis=(1, 2)) * degree_norms(order)
    inverse = np.divide(1, energies, out=np.zeros_like(energies), where=energies > 0)
    if tied is not None:
        inverse = inverse * tied
    degree = degrees(order)
    return np.asarray((fields * brdf[degree] * doubled).sum(axis=(1, 2)) * inverse[degree])


def _reciprocal(brdf: Reals, light: Reals, tied: NDArray[np.bool_]) -> tuple[Reals, NDArray[np.bool_]]:
    """Return the BRDF and where it is known: rho_lpq and rho_plq are one number, as sure as their lights are bright."""
    size = min(brdf.shape[:2])
    sure = np.add.reduceat(light**2, np.arange(len(brdf)) ** 2) * degree_norms(len(brdf) - 1) ** 2 * tied
    known = np.broadcast_to(tied[:, None], brdf.shape[:2]).copy()
    known[:size, :size] |= tied[:size]
    own, other = np.broadcast_arrays(sure[:size, None], sure[:size])
    total = own + other
    share = np.divide(own, total, out=np.zeros_like(total), where=total > 0)[..., None]
    result = brdf.copy()
    square = brdf[:size, :size]
    result[:size, :size] = share * square + (1 - share) * square.transpose(1, 0, 2)
    pattern = _pattern(brdf.shape[0] - 1, brdf.shape[1] - 1)
    result *= known[..., None] & pattern
    return result, known[..., None] & pattern


def _residual(fields: Reals, light: Reals, brdf: Reals, tied: NDArray[np.bool_]) -> float:
    """Return the relative L2 distance between the light field and what light and BRDF make, where both are known."""
    degree = degrees(len(brdf) - 1)
    made = (degree_norms(len(brdf) - 1)[degree] * light)[:, None, None] * brdf[degree]
    return _in_norms((fields - made) * tied[degree][:, None, None], fields)


def _in_norms(difference: Reals, fields: Reals) -> float:
    """Return the L2 norm of coefficients that may stand in a light field, in norms of it."""
    order, outgoing_order = order_of(len(fields)), fields.shape[1] - 1
    doubled = _doubled(fields.shape[2]) * _pattern(order, outgoing_order)[degrees(order)]
    return float(np.sqrt((difference**2 * doubled).sum() / (fields**2 * doubled).sum()))


def _told(ill_posed: dict[int, str]) -> str:
    """Return all ill-posed degrees in one line, those with the same reason together."""
    parts = []
    for reason in dict.fromkeys(ill_posed.values()):
        where = ", ".join(str(degree) for degree in ill_posed if ill_posed[degree] == reason)
        parts.append(f"ill-posed at l = {where}: {reason}")
    return "; ".join(parts)


def _reason(seen: bool, answers: bool) -> str:
    """Tell why a degree cannot be told apart into light and material."""
    if seen:
        return "no coefficient rho_lpq ties its scale to that of l = 0"
    if answers:
        return "the light has no part of this degree, so the material's answer to it is not seen"
    return "the light field has no part of this degree, so its light is not seen"
