"""The reflected light field as a convolution: its coefficients from those of the light and of the BRDF."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.complex import complex_harmonics, to_complex
from harmonicface.harmonics.indexing import count, degrees, order_of
from harmonicface.reflectance._brdf_quadrature import Complexes
from harmonicface.reflectance.brdf import Brdf, values
from harmonicface.reflectance.local_light import real_light
from harmonicface.reflectance.outgoing_kernels import brdf_array
from harmonicface.reflectance.spectra import degree_norms


def light_field(light: ArrayLike, brdf: ArrayLike) -> Complexes:
    r"""Return the coefficients of the light field that an isotropic material reflects.

    .. math:: B_{lmpq} = \Lambda_l L_{lm} \rho_{lpq}

    (Ramamoorthi & Hanrahan 2004, equations 49 and 53), of the orthonormal functions
    C_lmpq = Lambda_l^-1 D^l_mq(alpha, beta) Y_pq(theta_o, phi_o). B cos(theta_o) for a reciprocal BRDF.

    Parameters
    ----------
    light
        ((order + 1)^2,) real coefficients; as many degrees count as the BRDF has too.
    brdf
        (order + 1, outgoing_order + 1, q) from `isotropic_coefficients`.

    Returns
    -------
    array
        ((order + 1)^2, outgoing_order + 1, q) complex, for q >= 0: B_lmp(-q) = B_lmpq. 16 bytes each.

    Raises
    ------
    HarmonicFaceError
        Coefficients of another shape, more than the memory holds.

    Examples
    --------
    >>> light_field([1.0, 0.0, 0.0, 0.0], np.full((1, 2, 1), 0.5))[0, :, 0].round(4)
    array([1.7725+0.j, 1.7725+0.j])
    """
    table = brdf_array(brdf)
    if table.ndim != 3:
        raise HarmonicFaceError(f"brdf: expected isotropic coefficients (l, p, q), got {_validate.describe(table)}")
    complexes, order = _common(light, len(table))
    table = table[: order + 1, :, : min(order, table.shape[1] - 1) + 1]
    require(16 * count(order) * table[0].size, f"light field of order {order} by {table.shape[1] - 1}")
    degree = degrees(order)
    return np.asarray((degree_norms(order)[degree] * complexes)[:, None, None] * table[degree])


def light_field_at_angle(light: ArrayLike, kernel: ArrayLike) -> Complexes:
    r"""Return the coefficients of the light field of an isotropic material at one outgoing angle.

    .. math:: B_{lmq}(\theta_o) = \Lambda_l L_{lm} \rho_{lq}(\theta_o)

    (Ramamoorthi & Hanrahan 2004, equation 51), of (2 pi)^-1/2 Lambda_l^-1 D^l_mq(alpha, beta) exp(i q phi_o).

    Parameters
    ----------
    light
        As for `light_field`.
    kernel
        (order + 1, order + 1) from `coefficients_at_angle`.

    Returns
    -------
    array
        ((order + 1)^2, order + 1) complex, for q >= 0: B_lm(-q) = (-1)^q B_lmq.

    Raises
    ------
    HarmonicFaceError
        Coefficients of another shape.

    Examples
    --------
    >>> light_field_at_angle([1.0], [[1.0]]).round(4)
    array([[3.5449+0.j]])
    """
    table = _validate.finite(kernel, "kernel")
    if table.ndim != 2 or table.shape[0] != table.shape[1] or table.size == 0:
        raise HarmonicFaceError(f"kernel: expected shape (l + 1, l + 1), got {_validate.describe(table)}")
    complexes, order = _common(light, len(table))
    degree = degrees(order)
    return np.asarray((degree_norms(order)[degree] * complexes)[:, None] * table[degree])


def anisotropic_light_field(light: ArrayLike, brdf: ArrayLike, outgoing: ArrayLike | None = None) -> list[Complexes]:
    r"""Return the coefficients of the light field that any material reflects, one array a degree.

    .. math:: B_{lmnpq} = \sqrt{8\pi^2/(2l+1)}\; L_{lm}\, \rho_{ln,pq}, \qquad
              B_{lmn}(\omega_o) = \sqrt{8\pi^2/(2l+1)}\; L_{lm}\, \rho_{ln}(\omega_o)

    (Ramamoorthi & Hanrahan 2004, equations 39 and 40), of sqrt((2l + 1) / 8 pi^2) D^l_mn(alpha, beta, gamma)
    times Y_pq(theta_o, phi_o), or alone.

    Parameters
    ----------
    light
        As for `light_field`.
    brdf
        ((order + 1)^2, (outgoing_order + 1)^2) from `anisotropic_coefficients`.
    outgoing
        (3,) a local unit vector, for the second form.

    Returns
    -------
    list
        For each l an array [m + l, n + l, pq], complex; [m + l, n + l] in the second form.

    Raises
    ------
    HarmonicFaceError
        Coefficients of another shape, an outgoing direction that is not one unit vector, more than the memory holds.

    Examples
    --------
    >>> [each.shape for each in anisotropic_light_field([1.0, 0.0, 0.0, 0.0], np.eye(4))]
    [(1, 1, 4), (3, 3, 4)]
    """
    table = brdf_array(brdf)
    if table.ndim != 2:
        raise HarmonicFaceError(f"brdf: expected anisotropic coefficients (ln, pq), got {_validate.describe(table)}")
    complexes, order = _common(light, order_of(len(table)) + 1)
    if outgoing is not None:
        direction = _validate.unit_normals(outgoing, "outgoing")
        if direction.shape != (3,):
            raise HarmonicFaceError(f"outgoing: expected one direction (3,), got {_validate.describe(direction)}")
        table = table @ complex_harmonics(direction, order_of(table.shape[1]))
    entries = (order + 1) * (2 * order + 1) * (2 * order + 3) // 3 * table[0].size
    require(16 * entries, f"anisotropic light field of order {order}")
    result = []
    for degree in range(order + 1):
        rows = slice(degree**2, (degree + 1) ** 2)
        scaled = np.sqrt(8 * np.pi**2 / (2 * degree + 1)) * complexes[rows]
        result.append(np.tensordot(scaled, table[rows], axes=0))
    return result


def about_reflection(brdf: Brdf, form: str = "transfer") -> Callable[[Floats, Floats], Floats]:
    r"""Reparameterize a BRDF by the reflection vector instead of the normal.

    In the frame of R the outgoing direction is at twice the angle it has with the normal, and the normal stands
    half-way between z and it. A lobe about R becomes a function of theta_i alone (all but p = 0 vanish), and one that
    is nearly so becomes compact (Ramamoorthi & Hanrahan 2004, section 4.3.3). For isotropic BRDFs.

    Parameters
    ----------
    brdf
        See `brdf.values`.
    form
        The form of it that is reparameterized.

    Returns
    -------
    callable
        A kernel on the whole sphere: expand it with `form="kernel"`, and everything holds with R for the normal.

    Raises
    ------
    HarmonicFaceError
        When called, what `brdf.values` refuses.

    Examples
    --------
    >>> lobe = about_reflection(lambda i, o: (i * o * [-1, -1, 1]).sum(axis=-1).clip(0) ** 20, form="kernel")
    >>> float(lobe(np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])).round(6)), round(0.8**20, 6)
    (0.011529, 0.011529)
    """

    def kernel(incoming: Floats, outgoing: Floats) -> Floats:
        normal = outgoing + np.array([0.0, 0.0, 1.0])
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        normal = np.where(length > 0, normal / np.where(length > 0, length, 1), [1.0, 0.0, 0.0])
        local_incoming, local_outgoing = (_in_frame_of(normal, each) for each in (incoming, outgoing))
        return values(brdf, local_incoming, local_outgoing, form)

    return kernel


def _in_frame_of(normal: Floats, directions: Floats) -> Floats:
    """Return directions in the frame whose z is the normal, its tangent in the plane of the normal and the z axis."""
    across = np.stack([-normal[..., 1], normal[..., 0], np.zeros_like(normal[..., 0])], axis=-1)
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(length > 0, across / np.where(length > 0, length, 1), [0.0, 1.0, 0.0])
    along = np.cross(across, normal)
    return np.stack([(directions * axis).sum(axis=-1) for axis in (along, across, normal)], axis=-1)


def _common(light: ArrayLike, orders: int) -> tuple[Complexes, int]:
    """Return the complex coefficients of a light up to the order that the BRDF has too, and that order."""
    coefficients = real_light(light)
    if coefficients.ndim != 1:
        raise HarmonicFaceError(f"light: expected one channel, (k,), got {_validate.describe(coefficients)}")
    order = min(order_of(len(coefficients)), orders - 1)
    return np.asarray(to_complex(coefficients[: count(order)]), np.complex128), order
