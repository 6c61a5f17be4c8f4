"""Clustering: group photographs by who is in them, under any light, with nobody named beforehand."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.cluster import SpectralClustering
from sklearn.utils.validation import validate_data

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.affinities import Affinity, conic_affinity, gradient_affinity, pattern_affinity
from harmonicface.recognition.estimators.image_table import as_images

AFFINITIES = ("patterns", "gradient", "conic")
NOBODY = -1  # the label of a photograph that resembles none
LINK = 1e-6  # of a full weight, between all: so that the graph is one piece
LOOSE = 0.05  # largest eigenvalue of the graph's Laplacian that still counts as a piece of its own


class HarmonicClustering(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Group photographs by person, whatever the light, by spectral clustering of how alike they are.

    Two people under one lamp can be more alike than one person under two. So each photograph is linked to the few that
    it resembles most, where resemblance is counted in deviations from that with all others; photographs under lights
    in between link those of one person to each other (Ho, Yang, Lim, Lee & Kriegman, Clustering appearances of objects
    under varying illumination conditions, CVPR 2003, with conic and gradient affinities; here with local patterns too).

    Settings were chosen on people 1 to 5 of Yale B. On 6 to 11, on the ten people with 64 photographs each and on all
    eleven patterns make no error, and find how many people there are; gradients, which are 40 times faster, 0, 5.2 and
    4.9 % when told; cones 20 to 55 % (`benchmarks/clustering.py`). 640 photographs take about 12 seconds of one core
    and 3 MB a matrix. A number that is not told needs more photographs a person than `n_neighbors`.

    Parameters
    ----------
    n_clusters
        How many people there are, at least 1. None: as many as the graph has nearly separate pieces, where the
        eigenvalues of its Laplacian leave 0 with the largest step.
    affinity
        "patterns": similarity of local patterns at small shifts; "gradient": of the directions of gradients; both
        need `image_shape`. "conic": the weights with which other photographs combine to one, which make the graph.
    image_shape
        (h, w) of the photographs, which are the rows of a table.
    n_neighbors
        To how many others each photograph is linked, at least 1.
    random_state
        Seed of the last step, k-means.

    Attributes
    ----------
    labels_
        (n,) the group of each photograph, 0 and up; -1 where it resembles no other (darkness, a wall).
    affinity_matrix_
        (n, n) symmetric, how alike photographs are.
    n_clusters_
        How many groups were made.
    n_features_in_
        How many numbers a photograph has.

    Examples
    --------
    >>> random = np.random.default_rng(0)
    >>> people, lights = random.uniform(0.1, 1, (2, 1, 576)), random.uniform(0.3, 2, (2, 6, 1))
    >>> photographs = (people**lights).reshape(12, 576)
    >>> HarmonicClustering(image_shape=(24, 24)).fit_predict(photographs)
    array([0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1], dtype=int32)
    """

    def __init__(
        self,
        n_clusters: int | None = None,
        affinity: str = "patterns",
        image_shape: tuple[int, int] | None = None,
        n_neighbors: int = 8,
        random_state: int | None = 0,
    ) -> None:
        self.n_clusters = n_clusters
        self.affinity = affinity
        self.image_shape = image_shape
        self.n_neighbors = n_neighbors
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: Any = None) -> Self:
        """Group photographs.

        Parameters
        ----------
        X
            (n, p) linear intensities, one photograph a row, n of at least 2.
        y
            Ignored.

        Raises
        ------
        HarmonicFaceError
            A table of another form, NaN, an unknown affinity, an affinity without the image's shape, more groups than
            photographs, settings below 1.
        """
        pixels = self._table(X)
        wanted = None if self.n_clusters is None else _validate.at_least(self.n_clusters, 1, "n_clusters")
        neighbours = min(_validate.at_least(self.n_neighbors, 1, "n_neighbors"), len(pixels) - 1)
        if wanted is not None and wanted > len(pixels):
            raise HarmonicFaceError(f"n_clusters: expected at most the {len(pixels)} photographs, got {wanted}")
        self.affinity_matrix_ = self._affinity(pixels)
        alone = ~(self.affinity_matrix_ - np.diag(np.diag(self.affinity_matrix_)) > 0).any(axis=1)
        kept = np.flatnonzero(~alone)
        self.labels_ = np.full(len(pixels), NOBODY, np.int32)
        self.n_clusters_ = 0
        if len(kept):
            graph = self._graph(self.affinity_matrix_[np.ix_(kept, kept)], min(neighbours, len(kept) - 1))
            self.n_clusters_ = min(wanted or pieces(graph), len(kept))
            self.labels_[kept] = self._groups(graph)
        return self

    def _affinity(self, pixels: Floats) -> Affinity:
        """Return how alike photographs are."""
        if self.affinity not in AFFINITIES:
            given = _validate.describe(self.affinity)
            raise HarmonicFaceError(f"affinity: expected one of {', '.join(AFFINITIES)}, got {given}")
        if self.affinity == "conic":
            return conic_affinity(pixels)
        images = as_images(pixels, self.image_shape)
        return gradient_affinity(images) if self.affinity == "gradient" else pattern_affinity(images)

    def _graph(self, affinity: Affinity, neighbours: int) -> Affinity:
        """Return the weights of links: those of a cone are few and are taken as they are, others by rank."""
        return linked(affinity) if self.affinity == "conic" else neighbour_graph(affinity, neighbours)

    def _groups(self, graph: Affinity) -> NDArray[np.int32]:
        """Return the group of each node, numbered in the order in which they first appear."""
        if self.n_clusters_ == 1:
            return np.zeros(len(graph), np.int32)
        spectral = SpectralClustering(self.n_clusters_, affinity="precomputed", random_state=self.random_state)
        _, first, groups = np.unique(spectral.fit(graph).labels_, return_index=True, return_inverse=True)
        return np.asarray(np.argsort(np.argsort(first))[groups], np.int32)

    def _table(self, X: ArrayLike) -> Floats:
        """Let scikit-learn check a table; tell what it finds in one line."""
        try:
            return np.asarray(validate_data(self, X, dtype=[np.float64, np.float32], ensure_min_samples=2))
        except ValueError as problem:
            raise HarmonicFaceError(" ".join(str(problem).split())) from problem


def neighbour_graph(affinity: Affinity, neighbours: int) -> Affinity:
    r"""Return the weights of a graph that links each photograph to those that it resembles most, (n, n) symmetric.

    .. math:: z_{ij} = \frac{a_{ij} - m_i}{2 s_i} + \frac{a_{ij} - m_j}{2 s_j}

    with mean m and deviation s of each row without its diagonal; links are the k largest z of each row, of either end,
    where z > 0. All others are linked by a millionth of the mean weight.

    Parameters
    ----------
    affinity
        (n, n) symmetric, n of at least 2.
    neighbours
        k, from 1 to n - 1.

    Examples
    --------
    >>> alike = np.array([[1, 0.9, 0.1, 0.2], [0.9, 1, 0.2, 0.1], [0.1, 0.2, 1, 0.8], [0.2, 0.1, 0.8, 1]])
    >>> (neighbour_graph(alike, 1) > 0.1).astype(int)
    array([[0, 1, 0, 0],
           [1, 0, 0, 0],
           [0, 0, 0, 1],
           [0, 0, 1, 0]])
    """
    count = len(affinity)
    others = affinity[~np.eye(count, dtype=bool)].reshape(count, count - 1)
    deviation = others.std(axis=1)
    # two photographs have nobody to be compared with: alike is alike
    scaled = (affinity - others.mean(axis=1)[:, None]) / np.where(deviation > 0, deviation, 1)[:, None]
    scaled[deviation <= 1e-9 * np.abs(others).max()] = 1
    standard = (scaled + scaled.T) / 2
    np.fill_diagonal(standard, -np.inf)
    nearest = np.zeros((count, count), np.bool_)
    np.put_along_axis(nearest, np.argsort(-standard, axis=1, kind="stable")[:, :neighbours], True, axis=1)
    return linked(np.where(nearest | nearest.T, np.maximum(standard, 0), 0))


def linked(weights: Affinity) -> Affinity:
    """Return weights (n, n) with a millionth of the mean one added between all, 0 on the diagonal: one connected graph.

    Examples
    --------
    >>> linked(np.array([[5.0, 0.0], [0.0, 5.0]]))
    array([[0.e+00, 5.e-06],
           [5.e-06, 0.e+00]])
    """
    usual = float(weights[weights > 0].mean()) if (weights > 0).any() else 1.0
    graph = weights + LINK * usual
    np.fill_diagonal(graph, 0)
    return np.asarray(graph)


def pieces(graph: Affinity) -> int:
    r"""Return of how many nearly separate pieces a graph is made.

    The eigenvalues of I - D^-1/2 W D^-1/2 begin with a 0 for each separate piece, and small ones for pieces that few
    links connect; among those up to 0.05 the largest step to the next one is where they end (eigengap).

    Parameters
    ----------
    graph
        (n, n) symmetric weights, 0 on the diagonal.

    Examples
    --------
    >>> pieces(np.kron(np.eye(3), np.ones((4, 4)) - np.eye(4)))
    3
    """
    degree = np.sqrt(graph.sum(axis=1))
    degree[degree == 0] = 1
    values = np.linalg.eigvalsh(np.eye(len(graph)) - graph / degree[:, None] / degree[None])
    small = np.flatnonzero(values[:-1] <= LOOSE)
    return int(small[np.diff(values)[small].argmax()]) + 1 if len(small) else 1
