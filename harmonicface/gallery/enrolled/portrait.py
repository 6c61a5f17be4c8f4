"""What the default model keeps of a person beside her rows: a template of her looks, and her pictures on the grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.render import render
from harmonicface.io.colour import luminance
from harmonicface.lighting.lights import directional
from harmonicface.recognition.patterns import Template, patterns
from harmonicface.recognition.render_compare import Pictures
from harmonicface.surfaces.surface import Surface

# Lamps in front of a person, on a ring about the camera, and on one to her sides: what light does to fine detail
# averages out, what it does not do stays.
TILTS = ((0.0, 1), (30.0, 6), (60.0, 6))  # degrees from the camera's axis, and how many lamps


class Portrait:
    """A person's template and pictures; the pictures are put on the grid when they are first asked for.

    Parameters
    ----------
    template
        Of her photographs, or of her Surface under a spread of lamps.
    rows
        Returns her rows as pictures, (k, h, w).
    mask
        (h, w) booleans: the gallery's.
    """

    def __init__(self, template: Template, rows: Callable[[], Floats], mask: NDArray[np.bool_]) -> None:
        self.template = template
        self._rows, self._mask = rows, mask
        self._pictures: Pictures | None = None

    @property
    def pictures(self) -> Pictures:
        """What spans her pictures, on the grid."""
        if self._pictures is None:
            self._pictures = Pictures.of(self._rows(), self._mask)
        return self._pictures

    @property
    def nbytes(self) -> int:
        """Memory: the template, and the pictures if they have been asked for."""
        return self.template.nbytes + (0 if self._pictures is None else self._pictures.nbytes)


def photographed_template(photographs: Sequence[Floats], mask: NDArray[np.bool_]) -> Template:
    """Return the template of grey photographs (h, w) that show a person at about the same place."""
    return Template.of([patterns(np.maximum(photo, 0), mask) for photo in photographs])


def rendered_template(surface: Surface, mask: NDArray[np.bool_]) -> Template:
    """Return the template of a Surface: the mean over its exact pictures, with attached shadows, under 13 lamps."""
    pictures = [render(surface, directional(towards)) for towards in _lamps()]
    return photographed_template([one if one.ndim == 2 else luminance(one) for one in pictures], mask)


def _lamps() -> list[list[float]]:
    """Return the directions of the lamps."""
    towards = []
    for tilt, count in TILTS:
        for around in 2 * np.pi * (np.arange(count) + tilt / 60) / count:  # the second ring between those of the first
            across = np.sin(np.radians(tilt))
            towards.append([across * np.cos(around), across * np.sin(around), np.cos(np.radians(tilt))])
    return towards
