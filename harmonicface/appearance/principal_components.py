"""PrincipalComponents: the pictures in which most of what light does to a Surface is told, and how much that is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.light import HarmonicLight

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PrincipalComponents:
    r"""The principal components u_j of the pictures of a Surface under random light.

    .. math:: \mathrm{picture} \approx \mathrm{mean} + \sum_j z_j u_j, \qquad
              z_j = \sum_x w(x) (\mathrm{picture}(x) - \mathrm{mean}(x)) \, u_j(x)

    Parameters
    ----------
    components
        (k, p) pictures over the masked pixels in row-major order, orthonormal if each pixel counts by its weight.
    variances
        (k,) variances of the z_j, largest first, summed over pixels: for lamps of strength 1 and albedos up to 1, up to
        the number of pixels.
    total
        Variance of the exact pictures, summed over pixels: see `analytic_pca` for which degrees of light it counts.
    mean
        (p,) mean picture, 0 if the components were not centered.
    lights
        (k, (order + 1)^2) coefficients of the light under which the Surface looks like each component; they may be
        negative in places.
    mean_light
        ((order + 1)^2,) coefficients of the light of the mean picture.
    mask
        (h, w) booleans: where the pixels are.
    weights
        (p,) by how much each pixel counts; 1 if nothing was said.

    Examples
    --------
    >>> import harmonicface as hf
    >>> from harmonicface.appearance.principal import analytic_pca
    >>> found = analytic_pca(hf.synthetic_person(0, size=32), n_components=3)
    >>> found.components.shape[0], found.lights.shape, found.pictures().shape
    (3, (3, 25), (3, 32, 32))
    """

    components: Floats
    variances: Array
    total: float
    mean: Floats
    lights: Array
    mean_light: Array
    mask: NDArray[np.bool_]
    weights: Floats

    @property
    def explained(self) -> Array:
        """Share of the total variance that each component explains, (k,)."""
        return self.variances / self.total

    def pictures(self) -> Floats:
        """Return the components as pictures, (k, h, w), 0 outside the mask."""
        result = np.zeros((len(self.components), *self.mask.shape), self.components.dtype)
        result[:, self.mask] = self.components
        return result

    def transform(self, pictures: ArrayLike) -> Floats:
        """Return how much of each component is in pictures.

        Parameters
        ----------
        pictures
            (p,) or (n, p) masked pixels, or (h, w) or (n, h, w) whole pictures, of linear grey intensities.

        Returns
        -------
        array
            (k,) or (n, k) numbers z.

        Raises
        ------
        HarmonicFaceError
            Another shape, NaN or infinity in the mask.
        """
        pixels = self._pixels(pictures)
        return np.asarray(((pixels - self.mean) * self.weights) @ self.components.T)

    def inverse_transform(self, scores: ArrayLike) -> Floats:
        """Return the pictures that numbers z, (k,) or (n, k), stand for: (p,) or (n, p) masked pixels.

        Raises
        ------
        HarmonicFaceError
            Another shape, NaN or infinity.
        """
        return np.asarray(self.mean + self._scores(scores) @ self.components)

    def light(self, scores: ArrayLike) -> HarmonicLight:
        """Return the light under which the Surface looks as numbers z, (k,), say.

        Raises
        ------
        HarmonicFaceError
            Another shape, NaN or infinity.

        Examples
        --------
        >>> import harmonicface as hf
        >>> from harmonicface.appearance.principal import analytic_pca
        >>> face = hf.synthetic_person(0, size=32)
        >>> found = analytic_pca(face, n_components=9, centered=False)
        >>> lamp = hf.lights.directional([0.0, 0.0, 1.0])
        >>> seen = found.light(found.transform(hf.render(face, lamp)))
        >>> bool(abs(hf.render(face, seen) - hf.render(face, lamp)).max() < 0.1)
        True
        """
        values = self._scores(scores)
        if values.ndim != 1:
            raise HarmonicFaceError(f"scores: expected those of one picture, got shape {values.shape}")
        return HarmonicLight(self.mean_light + values @ self.lights)

    def _pixels(self, pictures: ArrayLike) -> Floats:
        """Return masked pixels, (p,) or (n, p)."""
        array = _validate.floats(pictures, "pictures")
        height, width = self.mask.shape
        if array.ndim in (2, 3) and array.shape[-2:] == (height, width):
            array = array[..., self.mask]
        if array.ndim not in (1, 2) or array.shape[-1] != len(self.weights):
            expected = f"{len(self.weights)} masked pixels or pictures of shape {(height, width)}"
            raise HarmonicFaceError(f"pictures: expected {expected}, got {_validate.describe(array)}")
        return _validate.finite(array, "pictures")

    def _scores(self, scores: ArrayLike) -> Floats:
        """Return finite numbers z, (k,) or (n, k)."""
        array = _validate.finite(scores, "scores")
        if array.ndim not in (1, 2) or array.shape[-1] != len(self.components):
            got = _validate.describe(array)
            raise HarmonicFaceError(f"scores: expected {len(self.components)} numbers a picture, got {got}")
        return array
