"""Harmonic images under light that cannot be negative."""

from __future__ import annotations

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.nonnegative_light import fibonacci_sphere
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.recognition.estimators.cone import NearestCone
from harmonicface.recognition.models import harmonic9
from harmonicface.surfaces.surface import Surface


class HarmonicNonnegative(NearestCone):
    """Nearest picture of nine harmonic images under a light of lamps (Basri & Jacobs 2003, section 3.3).

    The light's nine coefficients are sums of those of lamps, Y_lm(w), with weights of at least 0, in directions spread
    over the whole sphere.

    Parameters
    ----------
    image_shape, registration
        See `SurfaceClassifier`.
    directions
        How many.
    """

    def __init__(
        self, image_shape: tuple[int, int] | None = None, registration: bool = False, directions: int = 100
    ) -> None:
        super().__init__(image_shape, registration)
        self.directions = directions

    def _pictures(self, surface: Surface) -> Floats:
        lamps = fibonacci_sphere(_validate.at_least(self.directions, 1, "directions"))
        return real_harmonics(lamps, 2).T @ harmonic9(surface)
