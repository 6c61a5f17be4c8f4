"""Harmonic coefficients of a BRDF: isotropic rho_lpq, anisotropic rho_ln,pq, and at one outgoing angle."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count, index
from harmonicface.reflectance import _brdf_quadrature as quadrature
from harmonicface.reflectance._brdf_quadrature import Complexes, Reals
from harmonicface.reflectance.brdf import Brdf, check_form, values

ISOTROPIC_TOLERANCE = 1e-6


def isotropic_coefficients(
    brdf: Brdf,
    order: int,
    outgoing_order: int | None = None,
    form: str = "reciprocal",
    tolerance: float = 1e-7,
) -> Reals:
    r"""Expand an isotropic BRDF: rho_lpq for every l, p and q >= 0.

    .. math:: \tilde\rho = \sum_{l, p} \sum_{|q| \le \min(l, p)} \rho_{lp|q|}\,
              Y^*_{lq}(\omega_i)\, Y_{pq}(\omega_o)

    (Ramamoorthi & Hanrahan, A Signal-Processing Framework for Reflection, 2004, equations 41 and 47; the reciprocal
    form, equation 52, is symmetric: rho_lpq = rho_plq.) The grid of angles is refined until the coefficients settle.

    Parameters
    ----------
    brdf
        See `brdf.values`. A function of theta_i, theta_o and |phi_o - phi_i|.
    order
        The highest degree l of the incoming direction, at least 0.
    outgoing_order
        The highest degree p of the outgoing direction; `order` if not given.
    form
        "reciprocal", "transfer" or "kernel", see `brdf.values`.
    tolerance
        By how much the last refinement may change a coefficient, as a fraction of the largest one. Smooth lobes are
        right to 1e-12 then, since a refinement gains many digits; a BRDF with kinks gains few and takes longer.

    Returns
    -------
    array
        (order + 1, outgoing_order + 1, min of the two + 1), 0 where q > min(l, p). 8 bytes each.

    Raises
    ------
    HarmonicFaceError
        A negative order, one that needs more memory than there is, a BRDF that `values` refuses, that is anisotropic
        or that does not settle.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Lambertian
    >>> isotropic_coefficients(Lambertian(), order=2)[:, :, 0].round(4)
    array([[0.25  , 0.2887, 0.1398],
           [0.2887, 0.3333, 0.1614],
           [0.1398, 0.1614, 0.0781]])
    """
    order, outgoing_order = _orders(order, outgoing_order)
    start = max(order, outgoing_order) + 16
    _require_isotropic(quadrature.refined(start), order, outgoing_order)
    _expect_isotropic(brdf, check_form(form))

    def expand(nodes: int) -> Reals:
        return _isotropic_on(nodes, brdf, form, order, outgoing_order)

    return quadrature.settled(expand, start, quadrature.MOST_ISOTROPIC, tolerance)


def anisotropic_coefficients(
    brdf: Brdf,
    order: int,
    outgoing_order: int | None = None,
    form: str = "reciprocal",
    tolerance: float = 1e-5,
) -> Complexes:
    r"""Expand any BRDF: rho_ln,pq for every (l, n) of the incoming and (p, q) of the outgoing direction.

    .. math:: \tilde\rho = \sum_{ln,pq} \rho_{ln,pq}\, Y^*_{ln}(\omega_i)\, Y_{pq}(\omega_o)

    (the paper's equation 34). The reciprocal form of a reciprocal BRDF is Hermitian, rho_ln,pq = conj(rho_pq,ln); the
    paper's section 4.3.2 leaves out the conjugate.

    Parameters
    ----------
    brdf, order, outgoing_order, form
        As for `isotropic_coefficients`, without the isotropy.
    tolerance
        By how much the last refinement may change a coefficient, as a fraction of the largest one. The grid has four
        dimensions, so a tenth of the error costs several times the time.

    Returns
    -------
    array
        ((order + 1)^2, (outgoing_order + 1)^2) complex, (l, n) at l * (l + 1) + n. 16 bytes each.

    Raises
    ------
    HarmonicFaceError
        As for `isotropic_coefficients`.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Lambertian
    >>> coefficients = anisotropic_coefficients(Lambertian(), order=1)
    >>> coefficients[2, 2].real.round(4), coefficients.shape
    (np.float64(0.3333), (4, 4))
    """
    order, outgoing_order = _orders(order, outgoing_order)
    start = max(order, outgoing_order) + 8
    _require_anisotropic(quadrature.refined(start), order, outgoing_order)
    check_form(form)

    def expand(nodes: int) -> Complexes:
        return _anisotropic_on(nodes, brdf, form, order, outgoing_order)

    return quadrature.settled(expand, start, quadrature.MOST_ANISOTROPIC, tolerance)


def coefficients_at_angle(
    brdf: Brdf, order: int, outgoing_angle: float, form: str = "reciprocal", tolerance: float = 1e-7
) -> Reals:
    r"""Expand an isotropic BRDF at one outgoing angle, exactly in that angle: rho_lq(theta_o) for q >= 0.

    .. math:: \tilde\rho = \sum_{l} \sum_{q=-l}^{l} \rho_{lq}(\theta_o)\,
              \frac{1}{\sqrt{2\pi}} Y^*_{lq}(\omega_i)\, e^{i q \phi_o}, \qquad
              \rho_{l(-q)} = (-1)^q \rho_{lq}

    (the paper's equation 50). Only one harmonic carries the Condon-Shortley phase here, hence the sign. No
    series in the outgoing direction is cut off, so a BRDF with a jump at the horizon is met at every angle.

    Parameters
    ----------
    brdf, order, form, tolerance
        As for `isotropic_coefficients`.
    outgoing_angle
        theta_o in radians, 0 to pi / 2 (to pi for a "kernel").

    Returns
    -------
    array
        (order + 1, order + 1): [l, q], 0 where q > l.

    Raises
    ------
    HarmonicFaceError
        As for `isotropic_coefficients`; an angle that is none of those.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Lambertian
    >>> coefficients_at_angle(Lambertian(), order=2, outgoing_angle=0.0)[:, 0].round(4)
    array([0.7071, 0.8165, 0.3953])
    """
    order = _validate.at_least(order, 0, "order")
    start = order + 32
    _require_at_angle(quadrature.refined(start), order)
    limit = math.pi if check_form(form) == "kernel" else math.pi / 2
    given = _validate.finite(outgoing_angle, "outgoing_angle")
    if given.ndim:
        raise HarmonicFaceError(f"outgoing_angle: expected one number, got {_validate.describe(given)}")
    angle = float(given)
    if not 0 <= angle <= limit:
        raise HarmonicFaceError(f"outgoing_angle: expected radians from 0 to {limit:.6g}, got {angle:.6g}")
    _expect_isotropic(brdf, form)
    outgoing = np.array([math.sin(angle), 0.0, math.cos(angle)])

    def expand(nodes: int) -> Reals:
        _require_at_angle(nodes, order)
        cosines, weights = quadrature.polar_nodes(nodes, form)
        azimuths, turns = quadrature.half_turns(nodes, order)
        found = values(brdf, quadrature.directions(cosines[:, None], azimuths), outgoing, form) @ turns
        polar = quadrature.legendre(cosines, order)
        signs = math.sqrt(2 * math.pi) * (-1.0) ** np.arange(order + 1)
        return np.asarray(signs * np.einsum("lqi,iq,i->lq", polar, found, weights))

    return quadrature.settled(expand, start, quadrature.MOST_AT_ANGLE, tolerance)


def _orders(order: int, outgoing_order: int | None) -> tuple[int, int]:
    """Return both orders, checked."""
    order = _validate.at_least(order, 0, "order")
    return order, order if outgoing_order is None else _validate.at_least(outgoing_order, 0, "outgoing_order")


def _require_isotropic(nodes: int, order: int, outgoing_order: int) -> None:
    """Refuse a grid whose waves, harmonics and results, the last grid's and their difference too, do not fit."""
    orders = min(order, outgoing_order) + 1
    grid = nodes**2 * (orders + 9)  # waves, and outgoing directions with what they are made of
    harmonics = 2 * (max(order, outgoing_order) + 1) ** 2 * nodes
    results = 3 * (order + 1) * (outgoing_order + 1) * orders
    require(8 * (grid + harmonics + results), f"BRDF of order {order} by {outgoing_order} on {nodes} angles")


def _require_anisotropic(nodes: int, order: int, outgoing_order: int) -> None:
    """Refuse a grid whose middle, turns, harmonics and results do not fit."""
    waves = (2 * order + 1) * (outgoing_order + 1)
    turns = (nodes + order + outgoing_order) * waves
    middle = nodes * waves * (outgoing_order + 3)  # with two slices of one theta_i
    harmonics = 2 * (max(order, outgoing_order) + 1) ** 2 * nodes
    results = 3 * count(order) * count(outgoing_order)  # this grid's, the last one's and their difference
    needed = 16 * (turns + middle + results) + 8 * harmonics
    require(needed, f"BRDF of order {order} by {outgoing_order} on {nodes} angles")


def _require_at_angle(nodes: int, order: int) -> None:
    """Refuse a grid whose directions, harmonics and results do not fit."""
    needed = 8 * (9 * nodes**2 + 2 * (order + 1) ** 2 * nodes + 3 * (order + 1) ** 2)
    require(needed, f"BRDF of order {order} on {nodes} angles")


def _isotropic_on(nodes: int, brdf: Brdf, form: str, order: int, outgoing_order: int) -> Reals:
    """Return rho_lpq by a grid of theta_i, theta_o and phi_o - phi_i, a few theta_i at a time."""
    _require_isotropic(nodes, order, outgoing_order)
    cosines, weights = quadrature.polar_nodes(nodes, form)
    azimuths, turns = quadrature.half_turns(nodes, min(order, outgoing_order))
    outgoing = quadrature.directions(cosines[:, None], azimuths)
    incoming = quadrature.directions(cosines, np.zeros(1))
    waves = np.empty((turns.shape[1], len(cosines), len(cosines)))
    for rows in quadrature.blocks(len(cosines), outgoing.size):
        found = values(brdf, incoming[rows, None, None], outgoing, form)
        waves[:, rows] = np.moveaxis(found @ turns, -1, 0)
    waves *= weights[:, None] * weights
    polar = quadrature.legendre(cosines, max(order, outgoing_order))
    result = np.empty((order + 1, outgoing_order + 1, len(waves)))
    for mode, wave in enumerate(waves):
        result[:, :, mode] = 2 * math.pi * polar[: order + 1, mode] @ wave @ polar[: outgoing_order + 1, mode].T
    return result


def _anisotropic_on(nodes: int, brdf: Brdf, form: str, order: int, outgoing_order: int) -> Complexes:
    """Return rho_ln,pq by a grid of both directions, azimuths phi_i and phi_o - phi_i first, one theta_i at a time."""
    _require_anisotropic(nodes, order, outgoing_order)
    cosines, weights = quadrature.polar_nodes(nodes, form)
    turns = np.linspace(0, 2 * math.pi, nodes + order + outgoing_order, endpoint=False)
    differences, waves = quadrature.full_turns(nodes, outgoing_order)
    modes = np.arange(-order, order + 1)
    shifts = np.exp(1j * turns[:, None, None] * (modes[:, None] - np.arange(outgoing_order + 1)))  # phi_i, n, q
    shifts *= 2 * math.pi / len(turns)
    polar_out = quadrature.legendre(cosines, outgoing_order) * weights  # p, q, theta_o
    middle = np.empty((nodes, len(modes), *polar_out.shape[:2]), np.complex128)
    for row, cosine in enumerate(cosines):
        found = np.zeros((outgoing_order + 1, len(modes), nodes), np.complex128)  # q, n, theta_o
        for part in quadrature.blocks(len(turns), 3 * nodes * len(differences)):
            incoming = quadrature.directions(np.full(1, cosine), turns[part])[:, None, None]
            outgoing = quadrature.directions(cosines[:, None], differences + turns[part, None, None])
            sampled = values(brdf, incoming, outgoing, form) @ waves  # phi_i, theta_o, q
            found += shifts[part].transpose(2, 1, 0) @ sampled.transpose(2, 0, 1)
        middle[row] = (found @ polar_out.transpose(1, 2, 0)).transpose(1, 2, 0)
    return _by_incoming(middle, quadrature.legendre(cosines, order) * weights)


def _by_incoming(middle: Complexes, polar: Reals) -> Complexes:
    """Integrate (theta_i, n, p, q >= 0) over theta_i, and fill q < 0 from the conjugates."""
    order, outgoing_order = len(polar) - 1, middle.shape[2] - 1
    result = np.zeros((count(order), count(outgoing_order)), np.complex128)
    for mode in range(-order, order + 1):
        found = np.tensordot(polar[abs(mode) :, abs(mode)], middle[:, order + mode], (1, 0))  # l, p, q
        rows = [index(degree, mode) for degree in range(abs(mode), order + 1)]
        opposite = [index(degree, -mode) for degree in range(abs(mode), order + 1)]
        for out_mode in range(outgoing_order + 1):
            block = found[:, out_mode:, out_mode] * (-1.0) ** (max(mode, 0) + out_mode)
            columns = [index(degree, out_mode) for degree in range(out_mode, outgoing_order + 1)]
            result[np.ix_(rows, columns)] = block
            columns = [index(degree, -out_mode) for degree in range(out_mode, outgoing_order + 1)]
            result[np.ix_(opposite, columns)] = block.conj() * (-1.0) ** (mode + out_mode)
    return result


def _expect_isotropic(brdf: Brdf, form: str) -> None:
    """Refuse a BRDF that changes when both directions turn about the normal or are mirrored, lobes included."""
    rng = np.random.default_rng(0)
    incoming = rng.normal(size=(64, 3))
    outgoing = incoming * [-1, -1, 1] + rng.normal(size=(64, 3)) * np.geomspace(1e-3, 2, 64)[:, None]
    incoming, outgoing = (_upper(each) for each in (incoming, outgoing))
    expected = values(brdf, incoming, outgoing, form)
    cosine, sine = math.cos(1.1), math.sin(1.1)
    changes: dict[str, Callable[[Reals], Reals]] = {
        "turned about the normal": lambda d: d @ np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1.0]]),
        "mirrored": lambda d: d * [1.0, -1.0, 1.0],
    }
    for change, apply in changes.items():
        worst = np.abs(values(brdf, apply(incoming), apply(outgoing), form) - expected).max()
        if worst > ISOTROPIC_TOLERANCE * max(expected.max(), 1e-300):
            raise HarmonicFaceError(
                f"brdf: expected an isotropic one, got values that change by {worst / expected.max():.2g} of the "
                f"largest when both directions are {change}; use anisotropic_coefficients"
            )


def _upper(directions: Reals) -> Reals:
    """Return unit directions above the horizon."""
    directions = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    return directions * np.where(directions[:, 2:] < 0, [1.0, 1.0, -1.0], 1.0)
