"""Recognize faces under any lighting with harmonic subspaces."""

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface

__all__ = ["HarmonicFaceError", "Surface"]
