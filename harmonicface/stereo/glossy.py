"""A glossy pixel: matte and microfacet shares that a few numbers mix, seen under many lamps at many normals at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats

ROUGHNESSES = (0.1, 0.25, 0.5)  # of the three lobes: varnish, satin, the broad sheen of paper and skin
SHARES = 1 + len(ROUGHNESSES)  # unknowns of a pixel's reflectance: matte, and one a lobe
LOWEST = 0.02  # cosine to the camera: nothing that is seen is turned away further
DAMPING = 1e-4  # of a share's own square: what the lamps do not tell apart is shared out
SWEEPS = 3  # of all shares, before those above 0 are solved for at once
TURNS = 2


@dataclass(frozen=True, eq=False)
class Lamps:
    """Distant lamps of brightness 1 before a camera on the z axis.

    Parameters
    ----------
    directions
        (n, 3) float32 unit vectors to the lamps.
    halves
        (n, 3) float32 unit vectors halfway between lamp and camera.
    """

    directions: NDArray[np.float32]
    halves: NDArray[np.float32]

    @classmethod
    def of(cls, directions: Floats) -> Lamps:
        """Return lamps in (n, 3) unit directions."""
        halves = directions + np.array([0.0, 0.0, 1.0])
        length = np.linalg.norm(halves, axis=1, keepdims=True)
        length[length == 0] = 1  # a lamp straight behind
        return cls(directions.astype(np.float32), (halves / length).astype(np.float32))


def shading(normals: Floats, lamps: Lamps) -> NDArray[np.float32]:
    r"""Return what matte and glossy surfaces of share 1 show, under every lamp, at every normal.

    The matte one shows n.l. A lobe of microfacets of roughness a shows, with GGX's distribution and Smith's masking
    (Walter et al., Microfacet Models for Refraction through Rough Surfaces, 2007) and without Fresnel's factor, which
    changes little between the lamps,

    .. math:: \frac{D(n \cdot h) \, G(n \cdot l) \, G(n \cdot v)}{4 \, n \cdot v}, \quad
              D(x) = \frac{a^2}{\pi (1 + (a^2 - 1) x^2)^2}, \quad
              G(x) = \frac{2 x}{x + \sqrt{a^2 + (1 - a^2) x^2}}

    and nothing where the lamp stands behind the surface.

    Parameters
    ----------
    normals
        (p, 3) unit vectors.
    lamps
        The n lamps.

    Returns
    -------
    array
        (4, n, p) float32, matte first.

    Examples
    --------
    >>> shading(np.array([[0.0, 0.6, 0.8]]), Lamps.of(np.array([[0.0, 0.0, 1.0]]))).round(3)[:, 0, 0]
    array([0.8  , 0.007, 0.038, 0.086], dtype=float32)
    """
    columns = np.asarray(normals, np.float32)
    cosines = np.maximum(lamps.directions @ columns.T, 0)
    squares = (lamps.halves @ columns.T) ** 2
    toward = np.maximum(columns[:, 2], LOWEST)
    result = np.empty((SHARES, *cosines.shape), np.float32)
    result[0] = cosines
    for shown, roughness in zip(result[1:], ROUGHNESSES, strict=True):
        area = np.float32(roughness**2)
        np.multiply(squares, area - 1, out=shown)
        shown += 1
        shown *= shown
        shown *= cosines + np.sqrt(area + (1 - area) * cosines**2)
        np.divide(cosines, shown, out=shown)
        masking = 2 / (toward + np.sqrt(area + (1 - area) * toward**2))  # G(n.v) / n.v
        shown *= area / np.float32(2 * np.pi) * masking
    return result


def shares_of(gram: Floats, right: Floats, start: Floats | None = None) -> NDArray[np.float64]:
    """Return the shares of at least 0 that explain observations best, pixel by pixel.

    Each minimizes `x' G x / 2 - r' x` over x >= 0 (nonnegative least squares), by coordinates in turn, and in between
    on the way to the solution of those above 0, from which the first to fall to 0 is dropped (Lawson & Hanson 1974).

    Parameters
    ----------
    gram
        (k, k, p) products of the shares' pictures with one another, damped: above 0 on the diagonal.
    right
        (k, p) products with the observations.
    start
        (k, p) where to begin, at 0 by default.
    """
    shares = np.zeros(right.shape) if start is None else start.astype(np.float64)
    for _ in range(TURNS):
        for _ in range(SWEEPS):
            for k, row in enumerate(gram):
                slope = right[k] - np.einsum("kp,kp->p", row, shares)
                np.maximum(shares[k] + slope / row[k], 0, out=shares[k])
        for _ in range(len(gram) - 1):
            aim = _solution(gram, right, shares > 0)
            falling = aim < 0
            reach = np.divide(shares, shares - aim, out=np.ones_like(shares), where=falling)
            shares += reach.min(axis=0) * (aim - shares)
            shares[falling & (reach == reach.min(axis=0))] = 0
    return shares


def _solution(gram: Floats, right: Floats, above: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the shares that solve the equations of those chosen, the others 0."""
    system = np.moveaxis(gram * above[:, None] * above[None], 2, 0) + np.eye(len(gram)) * ~above.T[:, None]
    return np.asarray(np.linalg.solve(system, (right * above).T[..., None])[..., 0].T)


def products(pictures: Floats, weights: Floats, observations: Floats) -> tuple[NDArray[np.float64], ...]:
    """Return the damped (k, k, p) products of the shares' (k, n, p) pictures, and their (k, p) with observations."""
    count, _, pixels = pictures.shape
    gram, right = np.empty((count, count, pixels)), np.empty((count, pixels))
    for k in range(count):
        weighted = pictures[k] * weights
        right[k] = np.einsum("np,np->p", weighted, observations)
        for m in range(k + 1):
            gram[k, m] = gram[m, k] = np.einsum("np,np->p", weighted, pictures[m])
        gram[k, k] += DAMPING * gram[k, k] + 1e-12
    return gram, right


def tangents(normals: Floats) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two (p, 3) unit vectors across each normal and each other."""
    aside = np.where(np.abs(normals[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    first = np.cross(normals, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)


def before_the_camera(vectors: Floats) -> NDArray[np.float64]:
    """Return (p, 3) vectors as unit normals; those that the camera could not see are turned until it does."""
    normals = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)
    normals[:, 2] = np.maximum(normals[:, 2], LOWEST)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))
