"""Coefficients of a light field that is given by its values, whatever reflected it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.complex import to_complex
from harmonicface.harmonics.indexing import count
from harmonicface.reflectance._brdf_quadrature import Complexes, Reals, directions
from harmonicface.reflectance.local_light import degree_in_frames, turns_about_z
from harmonicface.reflectance.spectra import degree_norms

Field = Callable[[NDArray[Any], NDArray[Any]], Any]


def project_light_field(
    field: Field, order: int, outgoing_order: int | None = None, nodes: int | None = None
) -> Complexes:
    r"""Project the light field of an isotropic material, known by its values, on C_lmpq.

    .. math:: B_{lmpq} = \int\!\!\int B(\alpha, \beta, \theta_o, \phi_o)\,
              \Lambda_l^{-1} D^{l*}_{mq}(\alpha, \beta)\, Y^*_{pq}(\theta_o, \phi_o)\, d\omega_o\, d\omega_n

    (Ramamoorthi & Hanrahan 2004, equation 48), by a product of two grids that are exact where B has no degrees above
    `nodes` - 1 minus those asked for.

    Parameters
    ----------
    field
        A function of (normals (n, 1, 3), outgoing (1, m, 3)), outgoing in the frames of `tangent_frames`, to (n, m)
        finite numbers: B cos(theta_o) for the reciprocal form, 0 below the horizon.
    order, outgoing_order
        The highest l, and the highest p; `order` if not given.
    nodes
        Polar angles of each grid; it has twice as many azimuths. `1 + order + outgoing_order` if not given.

    Returns
    -------
    array
        ((order + 1)^2, outgoing_order + 1, q) complex, for q >= 0, as from `light_field`. While it works it holds
        the 4 nodes^4 samples, 8 bytes each.

    Raises
    ------
    HarmonicFaceError
        No function; values that are not finite or of another shape; more samples than the memory holds.

    Examples
    --------
    >>> matte = lambda normals, outgoing: 1 + normals[..., 2] + 0 * outgoing[..., 2]
    >>> project_light_field(matte, order=1, outgoing_order=0)[:, 0, 0].real.round(4) + 0.0
    array([12.5664,  0.    ,  7.2552,  0.    ])
    """
    order = _validate.at_least(order, 0, "order")
    outgoing_order = order if outgoing_order is None else _validate.at_least(outgoing_order, 0, "outgoing_order")
    nodes = 1 + order + outgoing_order if nodes is None else _validate.at_least(nodes, 1, "nodes")
    if not callable(field):
        raise HarmonicFaceError(f"field: expected a function of (normals, outgoing), got {_validate.describe(field)}")
    require(32 * nodes**4, f"light field sampled at {nodes} polar angles")
    points, weights = _grid(nodes)
    samples = _validate.finite(field(points[:, None], points[None]), "field's values").astype(np.float64)
    if samples.shape != (len(points), len(points)):
        raise HarmonicFaceError(
            f"field: expected values of shape {(len(points), len(points))}, got {_validate.describe(samples)}"
        )
    outward = (samples * weights) @ real_harmonics(points, outgoing_order).T * weights[:, None]  # normals, pq
    alpha, beta = np.arccos(points[:, 2]), np.arctan2(points[:, 1], points[:, 0])
    waves = [turns_about_z(angle, order) for angle in (alpha, beta, np.zeros_like(alpha))]
    orders = min(order, outgoing_order) + 1
    result = np.zeros((count(order), outgoing_order + 1, orders))
    for degree in range(order + 1):
        every = np.eye(2 * degree + 1)[:, None]
        turned = degree_in_frames(every, waves)  # s, normals, m
        result[degree**2 : (degree + 1) ** 2] = _coupled(turned, outward, orders)
        result[degree**2 : (degree + 1) ** 2] /= degree_norms(degree)[degree]
    return np.asarray(to_complex(result), np.complex128)


def _coupled(turned: Reals, outward: Reals, orders: int) -> Reals:
    """Return the integrals over the normals for each (m, p, q), the mean of q and -q."""
    degree = len(turned) // 2
    outgoing_order = int(np.sqrt(outward.shape[1])) - 1
    result = np.zeros((len(turned), outgoing_order + 1, orders))
    for mode in range(min(degree, orders - 1) + 1):
        columns = np.arange(mode, outgoing_order + 1) * np.arange(mode + 1, outgoing_order + 2)
        plus = turned[degree + mode].T @ outward[:, columns + mode]
        minus = turned[degree - mode].T @ outward[:, columns - mode]
        result[:, mode:, mode] = (plus + minus) / 2
    return result


def _grid(nodes: int) -> tuple[Reals, Reals]:
    """Return the directions and weights of Gauss polar angles and even azimuths."""
    cosines, weights = np.polynomial.legendre.leggauss(nodes)
    azimuths = np.linspace(0, 2 * np.pi, 2 * nodes, endpoint=False)
    return directions(cosines[:, None], azimuths).reshape(-1, 3), np.repeat(weights * np.pi / nodes, 2 * nodes)
