"""What a person may call a light on the command line: a file, a published name, a direction."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from harmonicface.commands.options import numbers
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.as_light import as_light
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import Light
from harmonicface.lighting.published import TABLE
from harmonicface.surfaces.view import rotation_matrix

LIGHT_HELP = (
    f"An environment file (HDR, EXR, ...; of a cube also its folder), {', '.join(TABLE)}, or a lamp's direction x,y,z. "
    "Several add up."
)


def read_lights(texts: Sequence[str], layout: str, rotation: str | None) -> Light:
    """Return the sum of the lights that a person named, turned as she said.

    Raises
    ------
    HarmonicFaceError
        A text that is neither name nor file nor direction, a file that is no map of this layout.
    """
    lights = as_light([_read(text, layout) for text in texts])
    if rotation is None:
        return lights
    return lights.rotated(rotation_matrix(numbers(rotation, 3, "rotate-light")))


def _read(text: str, layout: str) -> Light:
    """Return one light; a file of a published name has to be called ./grace."""
    if text in TABLE:
        return as_light(text)
    try:
        there = Path(text).exists()
    except (OSError, ValueError):  # a name that no file can have
        there = False
    if there:
        return EnvironmentMap.load(text, layout=layout)
    if text.count(",") == 2:
        return as_light(list(numbers(text, 3, "light")))
    names = ", ".join(TABLE)
    raise HarmonicFaceError(f"light: expected the path of a file, one of {names}, or a direction x,y,z, got {text!r}")
