"""Blockers: what stands between the samples of a Surface and the light, a mesh or the Surface's own depth."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.surfaces.depth_mesh import pixel_positions
from harmonicface.surfaces.horizon import horizons
from harmonicface.surfaces.rays import RayCaster
from harmonicface.surfaces.scene import FineSamples
from harmonicface.surfaces.surface import Surface

Integers = NDArray[np.int64]
AZIMUTHS = 96  # of the horizons that many directions are compared with


class Blocker(Protocol):
    """Tells which samples do not see which directions."""

    def blocked(self, samples: Integers, directions: Floats) -> NDArray[np.bool_]:
        """Tell for (n,) sample numbers and as many unit directions (n, 3) whether something is in the way."""

    def blocked_toward(self, samples: Integers, direction: Floats) -> NDArray[np.bool_]:
        """Tell the same for one direction, (3,), to which no approximation of directions applies."""


class MeshBlocker:
    """A mesh in the way: one ray each.

    Parameters
    ----------
    caster
        The mesh.
    samples
        Points on it; rays start on the side of their geometric normals.
    """

    def __init__(self, caster: RayCaster, samples: FineSamples) -> None:
        self._caster = caster
        self._starts = caster.starts(samples.positions, samples.geometric)

    def blocked(self, samples: Integers, directions: Floats) -> NDArray[np.bool_]:
        """Tell which of as many samples and directions the mesh separates."""
        return self._caster.blocked_from(self._starts[samples], directions.astype(np.float32, copy=False))

    def blocked_toward(self, samples: Integers, direction: Floats) -> NDArray[np.bool_]:
        """Tell which samples the mesh separates from one direction."""
        return self.blocked(samples, np.broadcast_to(direction, (len(samples), 3)))


class DepthBlocker:
    """The depth of a Surface in the way: its horizons, linear between 96 azimuths, exact for a single direction.

    Parameters
    ----------
    surface
        A Surface with depth; its masked pixels are the samples.
    """

    def __init__(self, surface: Surface) -> None:
        self._surface = surface
        self._heights: NDArray[np.float32] | None = None

    def blocked(self, samples: Integers, directions: Floats) -> NDArray[np.bool_]:
        """Tell which of as many samples and directions lie below the horizon, linear between azimuths."""
        if self._heights is None:
            self._heights = self._horizons(2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS).astype(np.float32)
        place = np.arctan2(directions[:, 1], directions[:, 0]) * (AZIMUTHS / (2 * np.pi)) % AZIMUTHS
        below = np.minimum(place.astype(np.int64), AZIMUTHS - 1)
        part = place - below
        low, high = self._heights[below, samples], self._heights[(below + 1) % AZIMUTHS, samples]
        return np.asarray(np.arcsin(np.clip(directions[:, 2], -1, 1)) < low + part * (high - low))

    def blocked_toward(self, samples: Integers, direction: Floats) -> NDArray[np.bool_]:
        """Tell at which samples one direction lies below the horizon."""
        heights = self._horizons(np.arctan2(direction[1], direction[0]))[0]
        return np.asarray(np.arctan2(direction[2], np.hypot(direction[0], direction[1])) < heights[samples])

    def _horizons(self, azimuths: Floats) -> NDArray[np.float64]:
        assert self._surface.depth is not None
        return horizons(self._surface.depth, self._surface.mask, self._surface.pixel_size, azimuths)


def pixel_samples(surface: Surface) -> FineSamples:
    """Return the centres of the masked pixels of a Surface with depth as samples, one a pixel."""
    normals = surface.pixel_normals
    number = np.arange(len(normals))
    return FineSamples(pixel_positions(surface), normals, normals, surface.pixel_albedo, number, number[:, None])
