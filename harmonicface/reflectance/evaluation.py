"""Reflected light at normals and viewing directions from the coefficients of the light and of the BRDF."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, degrees, modes, order_of
from harmonicface.reflectance._brdf_quadrature import Reals
from harmonicface.reflectance.local_light import local_light, oriented, real_light, tangent_frames
from harmonicface.reflectance.outgoing_kernels import brdf_array, outgoing_kernels, parity


def evaluate(
    light: ArrayLike,
    brdf: ArrayLike,
    normals: ArrayLike,
    outgoing: ArrayLike,
    gamma: ArrayLike = 0.0,
    extension: str = "zero",
) -> Reals:
    r"""Evaluate the reflected light B(alpha, beta, gamma, theta_o, phi_o), B cos(theta_o) for a reciprocal BRDF.

    .. math:: B = \sum_{lmpq} L_{lm}\, \rho_{lpq}\, D^l_{mq}(\alpha, \beta)\, Y_{pq}(\theta_o, \phi_o)

    (Ramamoorthi & Hanrahan 2004, equations 36 and 57).

    Parameters
    ----------
    light
        ((order + 1)^2,) or ((order + 1)^2, channels) real coefficients. Of the light's order and the BRDF's the lower
        one counts: what one of them lacks has no effect.
    brdf, extension
        See `outgoing_kernels`.
    normals, gamma
        See `tangent_frames`.
    outgoing
        (..., 3) *local* unit vectors (`tangent_frames` turns global ones into them); broadcasts with the normals. Its
        result holds above the horizon.

    Returns
    -------
    array
        (...) or (..., channels). For n normals of shape (n, 1, 3) and m directions of (1, m, 3) it is one matrix
        product; 8 (order + 1)^2 bytes for each normal and each direction are held meanwhile.

    Raises
    ------
    HarmonicFaceError
        What `local_light` and `outgoing_kernels` refuse; normals and directions that do not broadcast.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Lambertian
    >>> from harmonicface.reflectance.brdf_coefficients import isotropic_coefficients
    >>> uniform = [np.sqrt(4 * np.pi)]
    >>> up = [0.0, 0.0, 1.0]
    >>> matte = isotropic_coefficients(Lambertian(), order=0, outgoing_order=1)
    >>> float(evaluate(uniform, matte, up, up, extension="odd").round(6))   # radiance 1, cos(theta_o) = 1
    1.0
    """
    coefficients, table = real_light(light), brdf_array(brdf)
    kept = min(len(coefficients), len(table) if table.ndim == 2 else len(table) ** 2)
    coefficients = coefficients[:kept]
    (normals, turns), outgoing = oriented(normals, gamma), _validate.unit_normals(outgoing, "outgoing")
    turned = np.broadcast_shapes(normals.shape[:-1], turns.shape)
    shape = _together(turned, outgoing.shape[:-1], "outgoing")
    kernels = outgoing_kernels(table[: order_of(kept) + 1] if table.ndim == 3 else table[:kept], outgoing, extension)
    seen = local_light(coefficients.reshape(kept, -1), normals, turns)
    return _products(seen, kernels, shape).reshape((*shape, *coefficients.shape[1:]))


def evaluate_at_angle(light: ArrayLike, kernel: ArrayLike, normals: ArrayLike, azimuths: ArrayLike) -> Reals:
    r"""Evaluate the reflected light at one outgoing angle, with no series in that angle cut off.

    .. math:: B = \sum_{lmq} L_{lm}\, \rho_{lq}(\theta_o)\, \frac{1}{\sqrt{2\pi}} D^l_{mq}(\alpha, \beta) e^{iq\phi_o}

    (Ramamoorthi & Hanrahan 2004, equations 50 and 51).

    Parameters
    ----------
    light
        See `evaluate`.
    kernel
        (order + 1, order + 1) from `brdf_coefficients.coefficients_at_angle`.
    normals
        (..., 3) unit vectors.
    azimuths
        phi_o in radians, in the frame of `tangent_frames`; broadcasts with the normals' (...).

    Returns
    -------
    array
        (...) or (..., channels).

    Raises
    ------
    HarmonicFaceError
        Coefficients of another shape, azimuths that are not finite.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Lambertian
    >>> from harmonicface.reflectance.brdf_coefficients import coefficients_at_angle
    >>> kernel = coefficients_at_angle(Lambertian(), order=2, outgoing_angle=np.pi / 3)
    >>> float(evaluate_at_angle([np.sqrt(4 * np.pi)], kernel, [0.0, 0.0, 1.0], 0.0).round(6))   # radiance 1
    0.5
    """
    coefficients, table = real_light(light), _validate.finite(kernel, "kernel")
    if table.ndim != 2 or table.shape[0] != table.shape[1] or table.size == 0:
        raise HarmonicFaceError(
            f"kernel: expected coefficients of shape (l + 1, l + 1), got {_validate.describe(table)}"
        )
    angle = _validate.finite(azimuths, "azimuths")
    order = min(order_of(len(coefficients)), len(table) - 1)
    seen = local_light(coefficients[: count(order)].reshape(count(order), -1), normals)
    mode = modes(order)
    column = mode.reshape(-1, *[1] * angle.ndim)
    waves = np.where(column < 0, np.sin(-column * angle), np.cos(column * angle)) * np.where(column, np.sqrt(2), 1)
    signs = np.where(mode % 2, -1.0, 1.0) / np.sqrt(
        2 * np.pi
    )  # the phase that complex harmonics have and real ones not
    weights = (signs * table[degrees(order), np.abs(mode)]).reshape(column.shape)
    shape = _together(seen.shape[1:-1], angle.shape, "azimuths")
    return _products(seen, weights * waves, shape).reshape((*shape, *coefficients.shape[1:]))


def evaluate_under_lamp(
    lamp: ArrayLike,
    brdf: ArrayLike,
    normals: ArrayLike,
    outgoing: ArrayLike,
    gamma: ArrayLike = 0.0,
    extension: str = "even",
) -> Reals:
    r"""Evaluate the reflected light of one distant lamp of unit irradiance, dark exactly where it is below the horizon.

    .. math:: B = \sum_{lq,pq} \rho_{lq,pq}\, Y^*_{lq}(R^T w)\, Y_{pq}(\theta_o, \phi_o) \quad (n \cdot w > 0)

    The coefficients of a lamp do not decay, so that a BRDF which jumps at the horizon makes `evaluate` ring at the
    terminator, and the error falls as the square root of the order only. But where a lamp is up is known: here the
    series of the BRDF is continued below the horizon in both directions (see `outgoing_kernels`) and cut there.

    Parameters
    ----------
    lamp
        (3,) unit vector to the lamp, in global axes.
    brdf, normals, outgoing, gamma
        See `evaluate`.
    extension
        "even", "odd" or "zero", for both directions.

    Returns
    -------
    array
        (...), B cos(theta_o) for a reciprocal BRDF.

    Raises
    ------
    HarmonicFaceError
        As for `evaluate`; a lamp that is not one unit vector.

    Examples
    --------
    >>> from harmonicface.reflectance.brdf import Lambertian
    >>> from harmonicface.reflectance.brdf_coefficients import isotropic_coefficients
    >>> matte, up = isotropic_coefficients(Lambertian(), order=1), [0.0, 0.0, 1.0]
    >>> float(evaluate_under_lamp([0.0, 0.6, 0.8], matte, up, up, extension="odd").round(6)), round(0.8 / np.pi, 6)
    (0.254648, 0.254648)
    """
    direction = _validate.unit_normals(lamp, "lamp").astype(np.float64)
    if direction.shape != (3,):
        raise HarmonicFaceError(f"lamp: expected one direction (3,), got {_validate.describe(direction)}")
    incoming = np.einsum("...ji,j->...i", tangent_frames(normals, gamma), direction)
    outgoing = _validate.unit_normals(outgoing, "outgoing")
    shape = _together(incoming.shape[:-1], outgoing.shape[:-1], "outgoing")
    kernels = outgoing_kernels(brdf, outgoing, extension)
    seen = np.asarray(real_harmonics(incoming, order_of(len(kernels))), np.float64)
    if extension != "zero":
        seen *= parity(order_of(len(kernels)), extension).reshape(-1, *[1] * (seen.ndim - 1))
    seen *= incoming[..., 2] > 0
    return _products(seen[..., None], kernels, shape)[..., 0]


def _together(normals: tuple[int, ...], others: tuple[int, ...], name: str) -> tuple[int, ...]:
    """Return the shape of normals with something else for each."""
    try:
        return np.broadcast_shapes(normals, others)
    except ValueError:
        raise HarmonicFaceError(f"{name}: expected ones that broadcast with {normals} normals, got {others}") from None


def _products(seen: Reals, kernels: Reals, shape: tuple[int, ...]) -> Reals:
    """Return the sum over harmonics of (k, ..., channels) times (k, ...), broadcast to the shape."""
    if seen.ndim == 4 and seen.shape[2] == 1 and kernels.ndim == 3 and kernels.shape[1] == 1:
        return np.moveaxis(np.tensordot(seen[:, :, 0], kernels[:, 0], (0, 0)), 1, 2)
    lead = len(shape)
    seen = seen.reshape(len(seen), *[1] * (lead + 2 - seen.ndim), *seen.shape[1:])
    kernels = kernels.reshape(len(kernels), *[1] * (lead + 1 - kernels.ndim), *kernels.shape[1:])
    return np.asarray(np.einsum("k...c,k...->...c", seen, kernels))
