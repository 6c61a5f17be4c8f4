"""Shapes on which surfaces are tried, and the nine harmonic images of any normal in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.io.meshes import Mesh
from harmonicface.io.vertex_normals import vertex_normals

GREY = 0.7


def nine_images(normals: Floats, albedo: float | Floats = 1.0) -> Floats:
    """Return the nine harmonic images in closed form: albedo A_l Y_lm(n), polynomials of the normal.

    Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, equations 3 and 8.

    Parameters
    ----------
    normals
        (p, 3) unit vectors.
    albedo
        (p,) reflectances, or one for all.

    Returns
    -------
    (9, p) float64.

    Examples
    --------
    >>> nine_images(np.array([[0.0, 0.0, 1.0]]))[:3, 0].round(4)
    array([0.8862, 0.    , 1.0233])
    """
    x, y, z = np.asarray(normals, dtype=np.float64).T
    first, second = 2 / 3 * np.sqrt(3 * np.pi / 4), np.sqrt(15 * np.pi) / 8
    rows = [np.full_like(x, np.sqrt(np.pi) / 2), first * y, first * z, first * x, second * x * y, second * y * z]
    rows += [second * (3 * z**2 - 1) / np.sqrt(12), second * x * z, second * (x**2 - y**2) / 2]
    return np.asarray(rows) * albedo


def ball(side: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the normals of a ball that fills the picture, (side, side, 3), and where it is, (side, side).

    Examples
    --------
    >>> normals, inside = ball(5)
    >>> normals[2, 2] + 0.0, int(inside.sum())
    (array([0., 0., 1.]), 21)
    """
    places = (np.arange(side) + 0.5) * 2 / side - 1
    x, y = np.meshgrid(places, -places)
    inside = x**2 + y**2 < 0.98
    z = np.sqrt(np.where(inside, 1 - x**2 - y**2, 0))
    return np.stack([x, y, z], axis=2) * inside[..., None], inside


def bumpy_mesh() -> Mesh:
    """Return a grey ball of about unit radius with bumps that cast shadows on it.

    Examples
    --------
    >>> bumpy_mesh().faces.shape
    (25122, 3)
    """
    side = 80
    up, around = np.meshgrid(np.linspace(0, np.pi, side), np.linspace(0, 2 * np.pi, 2 * side), indexing="ij")
    radius = 1 + 0.15 * np.sin(5 * around) * np.sin(up) ** 2 * np.sin(6 * up)
    vertices = radius[..., None] * np.stack([np.sin(up) * np.sin(around), np.cos(up), np.sin(up) * np.cos(around)], 2)
    number = np.arange(up.size).reshape(up.shape)
    a, b, c, d = (corner.ravel() for corner in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    places = vertices.reshape(-1, 3)
    albedo = np.full((len(places), 3), GREY)
    return Mesh(places, faces, vertex_normals(places, faces), None, (), np.full(len(faces), -1), albedo)
