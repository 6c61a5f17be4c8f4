"""The round layouts: light probes (angular maps) and photographs of a mirror ball."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.layout import Layout, Shape, bilinear, check_image

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


class BallLayout(Layout):
    """A disc in a square picture; the direction turns away from an axis as the radius grows from 0 to 1.

    What is outside the disc has no solid angle and gives no light.
    """

    forward: float  # the z of the direction at the centre

    def shape(self, size: int) -> Shape:
        return size, size

    def check(self, radiance: Floats) -> None:
        check_image(radiance)
        if radiance.shape[0] != radiance.shape[1]:
            height, width = radiance.shape[:2]
            raise HarmonicFaceError(f"radiance: expected a square ({self.name}), got {width} x {height}")

    @abstractmethod
    def angle(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle from the axis at a radius of 0 to 1."""

    @abstractmethod
    def radius(self, angle: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the radius of an angle from the axis, 0 to pi."""

    @abstractmethod
    def cap(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (1 - cos(angle)) / radius^2: the cap inside the radius, over 2 pi radius^2."""

    @abstractmethod
    def spread(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the area of sphere around a radius for the same area of picture, up to a factor."""

    def _directions(self, shape: Shape, across: float, down: float) -> NDArray[np.float64]:
        right, up = _points(shape[-1], across, down)
        radius = np.hypot(right, up)
        angle = self.angle(np.minimum(radius, 1))
        scale = np.divide(np.sin(angle), radius, out=np.zeros_like(radius), where=radius > 0)
        return np.stack([right * scale, up * scale, self.forward * np.cos(angle)], axis=-1)

    def area_element(self, shape: Shape, across: float = 0.5, down: float = 0.5) -> NDArray[np.float64]:
        radius = np.hypot(*_points(shape[-1], across, down))
        return np.where(radius <= 1, self.spread(np.minimum(radius, 1)), 0.0)

    def solid_angles(self, shape: Shape) -> NDArray[np.float64]:
        r"""Return the solid angle of the part of each pixel that is inside the disc.

        By Green's theorem it is the integral of (1 - cos(angle)) d phi around the pixel. Along an edge at the
        height v that is cap(r) v du, smooth, so that six Gauss-Legendre points give it to rounding error; outside
        the disc the angle stays pi. The sum over pixels telescopes to 4 pi.
        """
        size = shape[-1]
        edges = np.linspace(-1.0, 1.0, size + 1)
        along = self._edge(edges[:, None], edges[None, :-1], edges[None, 1:])  # (size + 1, size): by height and column
        across = along[1:] - along[:-1]
        nearest = np.maximum(np.maximum(edges[:-1], -edges[1:]), 0)  # of a column to the middle
        outside = np.hypot(nearest[:, None], nearest[None, :]) >= 1
        return np.where(outside, 0.0, np.maximum(across + across.T, 0))

    def _edge(
        self, height: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the integral of cap(min(r, 1)) height du along edges at a height, with cap(r) = 2 / r^2 beyond 1."""
        reach = np.sqrt(np.maximum(1 - height**2, 0))
        first, last = np.clip(start, -reach, reach), np.clip(end, -reach, reach)
        half = (last - first) / 2
        points = (first + half)[..., None] + half[..., None] * NODES
        inside = (self.cap(np.hypot(height[..., None], points)) @ WEIGHTS) * half * height
        outside = _turn(height, start, np.minimum(end, -reach)) + _turn(height, np.maximum(start, reach), end)
        return np.asarray(inside + 2 * outside)

    def sample(self, radiance: Floats, directions: NDArray[np.float64]) -> Floats:
        size = radiance.shape[0]
        x, y, z = np.moveaxis(directions, -1, 0)
        across = np.hypot(x, y)
        radius = self.radius(np.arctan2(across, self.forward * z))
        scale = np.divide(radius, across, out=np.zeros_like(across), where=across > 0)
        # what is straight behind lies on the whole border: take its right end
        right = np.where(across > 0, x * scale, radius)
        column, row = (right + 1) / 2 * size - 0.5, (1 - y * scale) / 2 * size - 0.5
        step = (np.arange(size) + 0.5) / size * 2 - 1
        inside = (step[:, None] ** 2 + step[None, :] ** 2 <= 1).astype(radiance.dtype)
        if size == 1:
            return bilinear(radiance, row, column)
        known = inside if radiance.ndim == 2 else inside[..., None]
        weight = bilinear(inside, row, column)  # the black around the disc takes no part
        values = bilinear(radiance * known, row, column)
        return np.asarray(values / (weight if radiance.ndim == 2 else weight[..., None]))


class AngularLayout(BallLayout):
    """A light probe: the centre looks away from the camera (-z), the rim behind it (+z), angles grow evenly with r.

    Debevec's angular map: the angle from -z is pi r, +x is to the right, +y up (Debevec, Rendering synthetic objects
    into real scenes, 1998, and the Light Probe Image Gallery). Figure 3 of Ramamoorthi & Hanrahan 2001 puts
    +z at the centre instead: the mirror image of this, in which the coefficients odd in z, L_10, L_2-1 and L_21 up to
    order 2, change their signs.
    """

    name = "angular"
    forward = -1.0

    def angle(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.pi * radius

    def radius(self, angle: NDArray[np.float64]) -> NDArray[np.float64]:
        return angle / np.pi

    def cap(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.pi**2 / 2 * np.sinc(radius / 2) ** 2)

    def spread(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sinc(radius)


class MirrorBallLayout(BallLayout):
    """A photograph of a mirror ball from far away along -z: the centre shows the camera (+z), the rim what is behind.

    The normal at (x, y) has z = sqrt(1 - x^2 - y^2), and the mirror turns the view by twice its angle: the angle from
    +z is 2 asin(r). Every pixel has the same solid angle, 4 times its area.
    """

    name = "mirrorball"
    forward = 1.0

    def angle(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(2 * np.arcsin(radius))

    def radius(self, angle: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.sin(angle / 2))

    def cap(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.full_like(radius, 2.0)

    def spread(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.ones_like(radius)


def _points(size: int, across: float, down: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a point in each pixel, from -1 to 1: (1, n) to the right and (n, 1) up."""
    steps = np.arange(size)
    return ((steps + across) / size * 2 - 1)[None, :], (1 - (steps + down) / size * 2)[:, None]


def _turn(height: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the integral of height / (height^2 + u^2) du between two points of one side; 0 if end <= start."""
    width = np.maximum(end - start, 0)
    return np.arctan2(height * width, height**2 + start * (start + width))
