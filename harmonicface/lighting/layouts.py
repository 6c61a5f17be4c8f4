"""The layouts of environment maps by name."""

from __future__ import annotations

from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.ball import AngularLayout, MirrorBallLayout
from harmonicface.lighting.cube import CubeLayout
from harmonicface.lighting.latlong import LatLongLayout
from harmonicface.lighting.layout import Layout

LAYOUTS: dict[str, Layout] = {
    layout.name: layout for layout in (LatLongLayout(), AngularLayout(), CubeLayout(), MirrorBallLayout())
}


def layout_named(name: str) -> Layout:
    """Return the layout of a name.

    "latlong" (latitude-longitude), "angular" (light probe: the angle from the view grows with the radius), "cube"
    (six faces), "mirrorball" (a photograph of a mirror ball from far away).

    Raises
    ------
    HarmonicFaceError
        Another name.

    Examples
    --------
    >>> layout_named("cube").shape(64)
    (6, 64, 64)
    """
    if not isinstance(name, str) or name not in LAYOUTS:
        raise HarmonicFaceError(f"layout: expected one of {', '.join(map(repr, LAYOUTS))}, got {name!r}")
    return LAYOUTS[name]
