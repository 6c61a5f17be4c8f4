"""Predicted error: what a linear model of pictures leaves of them under random light, without rendering any."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.appearance.choose_images import MODEL_ORDER, Images
from harmonicface.appearance.principal_lights import HIGHEST_ORDER, LightStatistics
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count, degrees

Array = NDArray[np.float64]

ROUNDING = 3e-6  # of the largest singular value: of images in float32, as a `Subspace` takes it
DOUBT = 1.5  # by how much what is above order 12 may be stronger, over the root of the ways in which light varies
TOP = np.arange(HIGHEST_ORDER - 2, HIGHEST_ORDER + 1)  # degrees that stand for all above them


@dataclass(frozen=True)
class PredictedError:
    """How far a model's pictures are from exact ones, and why.

    Parameters
    ----------
    total
        Root of the mean square, over lights and pixels, of what is wrong, relative to that of the exact pictures.
    most
        What it may be, since light above order 12 is only estimated, and the worse the fewer lights there are.
    missing
        The part that the model's images do not span: light of higher degrees, cast shadows, gloss.
    noise
        The part that the photograph's noise brings in through the model's fit.
    rank
        How many independent images the model has.
    condition
        Largest over smallest singular value of its images: by how much more noise is amplified in the worst determined
        coefficient than in the best.
    """

    total: float
    most: float
    missing: float
    noise: float
    rank: int
    condition: float


class ErrorTheory:
    r"""The expected residual of linear models of pictures under random light.

    With the exact images F, (k, p), to order 12, the second moment C = S S^T of the light's coefficients and a model
    whose images span the projector P, the pictures are L F, and

    .. math:: \epsilon^2 = \frac{\|S^T F (1 - P)\|^2 + t(P)}{\|S^T F\|^2 + t(0)} + \frac{r}{p} \sigma^2

    where r is the model's rank, p the number of pixels and \sigma the noise of a pixel over the root mean square of
    pictures. t is what light above order 12 adds: as much more than degrees 10 to 12 as the surface's and the light's
    spectra say. That of a matte surface is A_l^2 (Basri & Jacobs, Lambertian Reflectance and Linear Subspaces, 2003;
    Ramamoorthi & Hanrahan, On the relationship between radiance and irradiance, 2001), that of cast shadows goes on as
    l^-2 or l^-2.75, as edges have it, and the light's as from degree 6 to 12. If a model spans a share s of degrees 10
    to 12, it spans s^3 of what is above: on heads shares fall about so fast from three degrees to the next.

    All is done in the space that the images span, reduced to a triangle.

    Parameters
    ----------
    images
        What photographs show, and what models are made of.
    lights
        How light is distributed.
    power
        (201,) mean square of its coefficients by degree.

    Raises
    ------
    HarmonicFaceError
        Light that does not reach the surface.
    """

    def __init__(self, images: Images, lights: LightStatistics, power: Array) -> None:
        self.pixels = images.pixels
        scale = float(np.abs(lights.moment).max())
        if scale == 0:
            raise HarmonicFaceError("lights: expected light that reaches the surface, got none")
        moment, power = lights.moment / scale, power / scale
        few = count(MODEL_ORDER)
        others = {kind: each for kind, each in images.models.items() if not np.array_equal(each, images.exact[:few])}
        blocks = [images.exact, *others.values()]
        triangle = np.linalg.qr(np.concatenate(blocks).T, mode="r")
        exact, *split = np.split(triangle, np.cumsum([len(block) for block in blocks])[:-1], axis=1)
        self._models = dict.fromkeys(images.models, exact[:, :few]) | dict(zip(others, split, strict=True))
        top = np.flatnonzero(np.isin(degrees(HIGHEST_ORDER), TOP))
        self._pictures = exact @ square_root(moment)
        strongest = exact[:, top] @ square_root(moment[np.ix_(top, top)])
        self._strongest = strongest * np.sqrt(_above(images.spectrum, power))
        self._doubt = DOUBT / np.sqrt(_ways(moment[np.ix_(top, top)]))
        self._root = square_root(moment[:few, :few])
        self.energy = float((self._pictures**2).sum() + (self._strongest**2).sum())
        if not self.energy > 0:
            raise HarmonicFaceError("lights: expected light that reaches the surface, got none")

    def of_images(self, family: tuple[bool, bool], combinations: Array, noise: float) -> PredictedError:
        """Return the error of a model whose images are combinations, (k, 49), of a family's images."""
        return self._of_span(self._models[family] @ combinations.T, noise)

    def principal_lights(self, family: tuple[bool, bool], most: int) -> Array:
        """Return the lights (k, 49) of the strongest principal pictures about 0, at most so many."""
        images = self._models[family] @ self._root
        _, values, turned = np.linalg.svd(images, full_matrices=False)
        rank = int((values > ROUNDING * values[0]).sum())
        return np.asarray((self._root @ turned[: min(most, rank)].T / values[: min(most, rank)]).T)

    def _of_span(self, span: Array, noise: float) -> PredictedError:
        """Return the error of a model by its images in the triangle's space, (n, k)."""
        left, values, _ = np.linalg.svd(span, full_matrices=False)
        if not values[0] > 0:
            return PredictedError(1.0, 1.0, 1.0, 0.0, 0, np.inf)
        rank = int((values > ROUNDING * values[0]).sum())
        basis = left[:, :rank]
        residual = self._pictures - basis @ (basis.T @ self._pictures)
        above, spanned = (self._strongest**2).sum(), ((basis.T @ self._strongest) ** 2).sum()
        beyond = above * max(1 - (spanned / above) ** 3, 0.0) if above > 0 else 0.0
        missing = float(np.sqrt(((residual**2).sum() + beyond) / self.energy))
        noisy = float(noise * np.sqrt(min(rank / self.pixels, 1.0)))
        total, doubt = float(np.hypot(missing, noisy)), float(np.sqrt(self._doubt * beyond / self.energy))
        condition = float(values[0] / values[rank - 1])
        return PredictedError(total, float(np.hypot(total, doubt)), missing, noisy, rank, condition)


def square_root(moment: Array) -> Array:
    """Return S with S S^T = a symmetric matrix without negative eigenvalues."""
    values, vectors = np.linalg.eigh(moment)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0)))


def _above(spectrum: Array, power: Array) -> float:
    """Return the energy of pictures by light above order 12, over that by degrees 10 to 12."""
    energy = spectrum * power
    here = float(energy[TOP].sum())
    return float(energy[HIGHEST_ORDER + 1 :].sum()) / here if here > 0 else 0.0


def _ways(moment: Array) -> float:
    """Return in how many ways light varies: the square of the sum of its variances over the sum of their squares."""
    square = float((moment**2).sum())
    return float(np.trace(moment) ** 2 / square) if square > 0 else 1.0
