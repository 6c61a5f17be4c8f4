"""Irradiance: the light that arrives at the pixels of a Surface, exactly or by harmonics, past obstacles or without."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats
from harmonicface.appearance._options import needed_order, with_shadows
from harmonicface.appearance.shadows import shadowed_irradiance
from harmonicface.lighting.light import HarmonicLight, Light
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport


def surface_irradiance(
    surface: Surface, light: Light, order: int | None = None, shadows: bool = False, bounces: int = 0
) -> Floats:
    r"""Return E(x) at the pixels of a Surface.

    .. math:: E = \int V(x, w) L(w) \max(n \cdot w, 0) \, dw \approx \sum_{lm} L_{lm} T_{lm}(x)

    with T_lm = A_l Y_lm(n) where nothing is in the way.

    Parameters
    ----------
    surface
        Its normals; its scene or depth with shadows; its albedo with bounces.
    light
        What falls on it.
    order
        None for the exact sum over the light's directions; otherwise the highest degree of the harmonic approximation,
        which may be below 0 in places; at most 200, with shadows 12. That of a `HarmonicLight` itself is enough, and
        no more is computed.
    shadows
        With what is in the way; without it V = 1.
    bounces
        How often light may be thrown back from surface to surface; more than 0 implies shadows.

    Returns
    -------
    array
        (p,) over the masked pixels in row-major order, or (p, 3) where light or bounces have colour.

    Raises
    ------
    HarmonicFaceError
        An order or a count of bounces out of range, shadows of a Surface with neither depth nor scene.
    """
    if order is not None:
        order = needed_order(light, order)
    if not with_shadows(shadows, bounces):
        source = light if order is None else HarmonicLight(light.coefficients(order))
        return source.irradiance(surface.pixel_normals)
    if order is None:
        return shadowed_irradiance(surface, light, bounces)
    reaching = transport(surface, order, bounces).values
    coefficients = light.coefficients(order).astype(reaching.dtype, copy=False)
    if coefficients.ndim == 2:  # a colour's light meets its own transport if there is one
        return np.asarray(np.einsum("kc,kpc->pc" if reaching.ndim == 3 else "kc,kp->pc", coefficients, reaching))
    return np.asarray(np.tensordot(coefficients, reaching, (0, 0)))
