"""The face prior: how the nine harmonic images of aligned faces vary between people, learned from any people."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.appearance.basis import harmonic_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.synthetic import synthetic_people
from harmonicface.store.archive import read_arrays, write_arrays
from harmonicface.surfaces.surface import Surface

IMAGES = 9
PEOPLE = 200  # of the built-in prior
SEED = 271_828  # far from the small numbers that tests and benchmarks draw their people from
SHAPE = (96, 84)  # height and width: 1.5 mm a pixel
MODES = 120
FORMAT = "harmonicface face prior 1"
ARRAYS = {"mean": 2, "modes": 3, "rest": 1, "mask": 2, "tone": 1}  # dimensions of what a file holds


@dataclass(frozen=True, eq=False)
class FacePrior:
    r"""Mean and covariance of the nine harmonic images between people whose faces are aligned; made by `FacePrior.of`.

    .. math:: b = \bar b + \sum_i c_i u_i + e, \quad c_i \sim N(0, 1), \quad e \sim N(0, r^2)

    Each person's albedo is first divided by its mean: one photograph cannot tell a dark face from a dim light. The
    statistics of Zhang & Samaras (Face recognition from a single training image under arbitrary unknown lighting
    using spherical harmonics, 2006) are those of each pixel for itself, here `pixel_covariances`; the modes keep
    besides how pixels vary together, so that what is in the light says something of what is in shadow.

    Parameters
    ----------
    mean
        (9, p) float32, harmonic images of order 2 as of `harmonic_images`.
    modes
        (m, 9, p) float32: principal directions times their standard deviations, the strongest first.
    rest
        (9,) root mean square of what the modes leave of each image.
    mask
        (h, w) booleans with p pixels: those that all people have.
    tone
        Mean albedo of the people, by which images of this scale become those of a usual face.
    source
        Of whom it was made.
    """

    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    rest: NDArray[np.float64]
    mask: NDArray[np.bool_]
    tone: float
    source: str

    @classmethod
    def of(cls, people: Iterable[Surface], modes: int = MODES, source: str = "") -> FacePrior:
        """Learn the prior from people, as of `synthetic_people` or `ict_people`.

        Parameters
        ----------
        people
            At least three Surfaces of one shape, aligned with each other; all their pixels in common count.
        modes
            How many principal directions to keep, at least 1; there are never more than people less one.
        source
            A few words on who they are, kept with the prior.

        Raises
        ------
        HarmonicFaceError
            Fewer than three people, different shapes, no pixel in common, somebody who is black, fewer than one mode.

        Examples
        --------
        >>> from harmonicface.people.synthetic import synthetic_people
        >>> prior = FacePrior.of(synthetic_people(5, size=24), source="five synthetic people")
        >>> prior.mean.shape == (9, prior.mask.sum()), len(prior.modes)
        (True, 4)
        """
        most = _validate.at_least(modes, 1, "modes")
        everybody = list(people)
        if len(everybody) < 3:
            raise HarmonicFaceError(f"people: expected at least three Surfaces, got {len(everybody)}")
        shapes = sorted({person.shape for person in everybody})
        if len(shapes) > 1:
            raise HarmonicFaceError(f"people: expected Surfaces of one shape, got {shapes}")
        mask = np.asarray(np.stack([person.mask for person in everybody]).all(axis=0))
        if not mask.any():
            raise HarmonicFaceError("people: expected pixels that all of them have, got none")
        tones = [float(person.grey_albedo[mask[person.mask]].mean()) for person in everybody]
        if min(tones) == 0:
            raise HarmonicFaceError(
                f"people: expected an albedo above 0, got 0 everywhere of person {np.argmin(tones)}"
            )
        images = np.stack(
            [
                (harmonic_images(person)[:, mask[person.mask]] / tone).ravel()
                for person, tone in zip(everybody, tones, strict=True)
            ]
        )
        mean = images.mean(axis=0, dtype=np.float64)
        found, rest = _principal(images - mean, min(most, len(images) - 1))
        return cls(
            mean.reshape(IMAGES, -1).astype(np.float32),
            found.reshape(len(found), IMAGES, -1).astype(np.float32),
            np.sqrt((rest.reshape(len(rest), IMAGES, -1) ** 2).sum(axis=(0, 2)) / (len(rest) - 1) / mask.sum()),
            mask,
            float(np.mean(tones)),
            source or f"{len(everybody)} people",
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the aligned face in pixels."""
        return self.mask.shape[0], self.mask.shape[1]

    @property
    def nbytes(self) -> int:
        """Memory."""
        return self.mean.nbytes + self.modes.nbytes + self.mask.nbytes

    @property
    def pixel_covariances(self) -> NDArray[np.float64]:
        """The (p, 9, 9) covariances of the nine numbers of each pixel between people."""
        modes = self.modes.astype(np.float64)
        return np.asarray(np.einsum("mip,mjp->pij", modes, modes) + np.diag(self.rest**2))

    def images(self, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the (9, p) images of the face with these coefficients c, (m,)."""
        return np.asarray(self.mean + np.tensordot(coefficients, self.modes, 1))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the prior to one file, replaced whole or not at all.

        Raises
        ------
        HarmonicFaceError
            The file cannot be written.
        """
        arrays: dict[str, NDArray[Any]] = {"mean": self.mean, "modes": self.modes, "rest": self.rest}
        arrays |= {"mask": self.mask, "tone": np.array([self.tone])}
        write_arrays(path, arrays, {"format": FORMAT, "source": self.source})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> FacePrior:
        """Read what `save` wrote.

        Raises
        ------
        HarmonicFaceError
            The file is missing, damaged, or holds something else.
        """
        arrays, about = read_arrays(path)
        if about.get("format") != FORMAT or {name: array.ndim for name, array in arrays.items()} != ARRAYS:
            raise HarmonicFaceError(f"{path}: expected a {FORMAT}, got a file of {about.get('format', 'no format')!r}")
        mean, modes, mask = arrays["mean"], arrays["modes"], arrays["mask"]
        if mask.dtype != np.bool_ or mean.shape != (IMAGES, mask.sum()) or modes.shape[1:] != mean.shape:
            got = f"mean {mean.shape}, modes {modes.shape} and a mask of {mask.sum()} pixels"
            raise HarmonicFaceError(f"{path}: expected nine images of the mask's pixels, got {got}")
        return cls(mean, modes, arrays["rest"], mask, float(arrays["tone"][0]), about.get("source", ""))


@lru_cache(maxsize=2)
def synthetic_prior(shape: tuple[int, int] = SHAPE, count: int = PEOPLE, seed: int = SEED) -> FacePrior:
    """Return the built-in prior: of 200 synthetic people at 96 x 84 pixels, made in the first call and kept.

    It takes about 5 seconds and 31 MB. Nothing of it comes in a file with the package.

    Parameters
    ----------
    shape
        Height and width in pixels, each at least 8.
    count
        How many people, at least 3.
    seed
        Of `synthetic_people`, at least 0.

    Raises
    ------
    HarmonicFaceError
        A shape, count or seed of another form.

    Examples
    --------
    >>> synthetic_prior((24, 21), count=4).source
    '4 synthetic people of seed 271828'
    """
    return FacePrior.of(synthetic_people(count, shape, seed), source=f"{count} synthetic people of seed {seed}")


def _principal(deviations: NDArray[np.float64], most: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the strongest principal directions of rows times their deviations, and what they leave of the rows.

    People are fewer than pixels, so the small matrix of their products is decomposed, not the covariance.
    """
    variances, mixtures = np.linalg.eigh(deviations @ deviations.T)
    strongest = np.argsort(variances)[::-1][:most]
    strongest = strongest[variances[strongest] > variances.max() * 1e-10]
    units = mixtures[:, strongest].T @ deviations / np.sqrt(variances[strongest])[:, None]
    rest = deviations - (deviations @ units.T) @ units
    return units * np.sqrt(variances[strongest] / (len(deviations) - 1))[:, None], rest
