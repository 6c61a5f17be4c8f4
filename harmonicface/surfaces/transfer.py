"""Transfer: how light gets to the pixels of a Surface, by the best way that the Surface allows."""

from __future__ import annotations

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count
from harmonicface.surfaces.horizon_transport import horizon_transport
from harmonicface.surfaces.interreflection import exchange_of, with_bounces
from harmonicface.surfaces.ray_transport import ray_transport
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transport import Transport

HIGHEST_ORDER = 12  # where 32 azimuths err by 13 % in the last degree of a person's transport; 30 % at 16, 58 % at 20


def transport(surface: Surface, order: int = 4, bounces: int = 0) -> Transport:
    """Return how much of each harmonic light reaches the pixels of a Surface past what casts shadows.

    A Surface that was seen from a mesh is shadowed by all of the mesh (`ray_transport`), one with depth alone by its
    depth (`horizon_transport`), whose triangles throw light back if there are bounces. What has been computed is kept
    in `surface.transports` (and by `surface.save`), and not computed again for a lower order.

    Parameters
    ----------
    surface
        A Surface with depth or with a scene.
    order
        The highest degree l, 0 to 12: what casts shadows is sampled too coarsely for higher ones.
    bounces
        How often light may be thrown back from surface to surface before it arrives, at least 0.

    Returns
    -------
    Transport
        Its values are (k, p) with k = (order + 1)^2 and p masked pixels in row-major order; (k, p, 3) where
        coloured skin throws light back.

    Raises
    ------
    HarmonicFaceError
        A Surface with neither depth nor scene, an order that is not 0 to 12, a negative number of bounces.

    Examples
    --------
    >>> import numpy as np
    >>> wall = Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2)), depth=np.zeros((2, 2)))
    >>> transport(wall, order=1).values[:, 0].round(4) + 0.0
    array([0.8862, 0.    , 1.0233, 0.    ])
    """
    rows = count(order)
    if order > HIGHEST_ORDER:
        raise HarmonicFaceError(
            f"order: expected at most {HIGHEST_ORDER} with shadows, whose azimuths and rays tell no higher degrees "
            f"apart, got {order:.6g}; without an order they are exact"
        )
    bounces = _validate.at_least(bounces, 0, "bounces")
    known = surface.transports.get(bounces)
    if known is None or known.order < order:
        known = surface.transports[bounces] = _computed(surface, order, bounces)
    return known if known.order == order else Transport(known.values[:rows], bounces)


def _computed(surface: Surface, order: int, bounces: int) -> Transport:
    """Compute the transport by the way that the Surface allows."""
    if surface.scene is not None:
        return Transport(ray_transport(surface, order, bounces), bounces)
    if surface.depth is None:
        raise HarmonicFaceError(
            "surface: expected depth, which casts the shadows, got a Surface with neither depth nor scene"
        )
    direct = horizon_transport(surface, order)
    if bounces:
        thrown = exchange_of(surface, bounces).bounced(direct.T, bounces)
        return Transport(with_bounces(direct, thrown).astype(direct.dtype), bounces)
    return Transport(direct)
