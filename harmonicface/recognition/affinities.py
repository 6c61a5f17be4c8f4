"""Affinities: how alike the photographs of a set are, two by two, whoever is in them and whatever the light."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.recognition.blocks import correlations, unit_blocks
from harmonicface.recognition.estimators.nonnegative_least_squares import nonnegative_solutions
from harmonicface.recognition.grid import on_grid
from harmonicface.recognition.patterns import patterns, together

Affinity = NDArray[np.float64]

REACH = 2  # pixels of the pattern grid: people who moved farther are linked by photographs in between
AT_ONCE = 64  # photographs that stay in the cache
SMOOTH = 1.0  # pixels of the grid, before derivatives
FAINT = 0.1  # of the mean gradient: what is weaker has no direction
CONE_TOLERANCE = 1e-3  # of the largest product: photographs that add less are not taken into a combination


def pattern_affinity(images: Floats) -> Affinity:
    """Return the similarity of the local patterns of photographs, (n, n) symmetric, 1 on the diagonal.

    As `patterns.similarity`, each pair once, at common shifts of up to two pixels of the pattern grid. A photograph
    without any pattern (darkness, a wall) is at 0 from all others.

    Parameters
    ----------
    images
        (n, h, w) linear intensities, at least 24 pixels a side.

    Raises
    ------
    HarmonicFaceError
        Photographs that are too small, NaN.

    Examples
    --------
    >>> faces = np.random.default_rng(0).uniform(0.1, 1, (2, 48, 48))
    >>> found = pattern_affinity(np.stack([faces[0], faces[1], faces[0] ** 0.5]))
    >>> bool(found[0, 2] > 2 * found[0, 1])
    True
    """
    found = [patterns(image).sum(axis=0) for image in images]
    blocks = [unit_blocks(pattern) for pattern in found]
    result = np.eye(len(images))
    for i, pattern in enumerate(found[:-1]):
        for start in range(i + 1, len(images), AT_ONCE):
            others = slice(start, min(start + AT_ONCE, len(images)))
            result[i, others] = result[others, i] = together(*correlations(pattern, blocks[others], REACH))
    return result


def gradient_affinity(images: Floats) -> Affinity:
    r"""Return how well the directions of gradients agree, (n, n) symmetric, about 1 on the diagonal.

    .. math:: a_{ij} = \frac1p \sum_x \frac{g_i(x) \cdot g_j(x)}{(|g_i| + e_i)(|g_j| + e_j)}

    with e a tenth of the mean gradient of a photograph. (Ho et al. 2003 compare lengths and angles of gradients; the
    angle is what light changes least.)

    Parameters
    ----------
    images
        (n, h, w) linear intensities, at least 24 pixels a side; they are compared at 96 rows or their own if fewer.

    Raises
    ------
    HarmonicFaceError
        Photographs that are too small, NaN.

    Examples
    --------
    >>> ramp = np.tile(np.arange(24.0), (24, 1))
    >>> gradient_affinity(np.stack([ramp, 2 * ramp, ramp.T]))[0].round(2) + 0.0
    array([0.82, 0.82, 0.  ])
    """
    small = [on_grid(image).light for image in images]
    features = np.empty((len(images), 2, *small[0].shape), np.float32)
    for image, feature in zip(small, features, strict=True):
        smooth = cv2.GaussianBlur(image, (0, 0), SMOOTH, borderType=cv2.BORDER_REPLICATE)
        down, right = np.gradient(smooth)
        length = np.hypot(down, right)
        scale = length + FAINT * length.mean()
        scale[scale == 0] = 1
        feature[:] = down / scale, right / scale
    flat = features.reshape(len(images), -1)
    return np.asarray(flat @ flat.T, np.float64) / (flat.shape[1] / 2)


def conic_affinity(pixels: Floats) -> Affinity:
    r"""Return with what weights other photographs combine to each one, (n, n) symmetric, 0 on the diagonal.

    .. math:: \min_{a_i \ge 0} \Big| x_i - \sum_{j \ne i} a_{ij} x_j \Big|^2, \qquad A = (a + a^T) / 2

    of photographs x of length 1: those of one person are in one convex cone (Ho, Yang, Lim, Lee & Kriegman, Clustering
    appearances of objects under varying illumination conditions, CVPR 2003).

    Parameters
    ----------
    pixels
        (n, p) linear intensities, n of at least 2.

    Examples
    --------
    >>> conic_affinity(np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])).round(2)
    array([[0.  , 0.71, 0.  , 0.  ],
           [0.71, 0.  , 0.71, 0.  ],
           [0.  , 0.71, 0.  , 0.  ],
           [0.  , 0.  , 0.  , 0.  ]])
    """
    rows = pixels.astype(np.float64)
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    rows /= np.where(lengths == 0, 1, lengths)
    gram = rows @ rows.T
    weights = np.zeros(gram.shape)
    for i, products in enumerate(gram):
        others = np.arange(len(gram)) != i
        rest = gram[np.ix_(others, others)]
        weights[i, others] = nonnegative_solutions(rest[None], products[None, None, others], CONE_TOLERANCE)[0, 0]
    return (weights + weights.T) / 2
