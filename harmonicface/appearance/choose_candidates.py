"""Candidates: the linear models of pictures that are compared, their images, and what they cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.choose_error import ErrorTheory
from harmonicface.appearance.choose_images import MODEL_ORDER
from harmonicface.appearance.gloss import gloss
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count, order_of
from harmonicface.lighting.light import HarmonicLight
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

PRINCIPAL = (1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 16, 25)  # numbers of analytic components that are compared
SHADOWED = {"shadowed9": 2, "shadowed16": 3, "shadowed25": 4, "shadowed49": 6}  # orders, by name
HARMONIC = {"harmonic9": 2, "harmonic25": 4, "harmonic49": 6}  # of 25 and 49 images 18 and 31 are not 0


@dataclass(frozen=True)
class Cost:
    """What a model costs, for each person and photograph.

    Parameters
    ----------
    rows
        How many orthonormal rows a Surface needs.
    bytes
        That they take in float32.
    flops
        Of one product of a photograph with them, which is what a query costs.
    images
        How many harmonic images have to be computed first to make them.
    shadows
        Whether with cast shadows, which takes most of the time.
    """

    rows: int
    bytes: int
    flops: int
    images: int
    shadows: bool

    @property
    def order(self) -> tuple[int, int, int]:
        """What is compared: a query's cost, then that of making the rows."""
        return self.flops, int(self.shadows), self.images


@dataclass(frozen=True, eq=False)
class Candidate:
    """A linear model of the pictures of a Surface.

    Parameters
    ----------
    name
        "linear3", "ambient4", "harmonic9" ..., "shadowed9" ..., "pca5" ..., with "+gloss" where its images shine.
    shadows
        Whether its images have cast shadows.
    material
        The coat that they have; None: matte.
    lights
        (k, n) harmonic coefficients of the light that each of its images is lit by.
    """

    name: str
    shadows: bool
    material: Material | None
    lights: Array

    @property
    def kind(self) -> tuple[bool, bool]:
        """Whether its images have shadows and gloss."""
        return self.shadows, self.material is not None

    def pictures(self, surface: Surface) -> Floats:
        """Return the images that span the model's pictures of a Surface, (k, p).

        Raises
        ------
        HarmonicFaceError
            Shadows of a Surface with neither depth nor scene.
        """
        order = order_of(self.lights.shape[1])
        images = harmonic_images(surface, order, self.shadows)
        if self.material is not None:
            shine = [
                gloss(surface, HarmonicLight(each), self.material, order, self.shadows) for each in np.eye(len(images))
            ]
            images = images + np.stack(shine).astype(images.dtype)
        return np.asarray(self.lights.astype(images.dtype) @ images)

    def cost(self, rank: int, pixels: int) -> Cost:
        """Return what it costs when so many of its images are independent."""
        return Cost(rank, 4 * rank * pixels, 2 * rank * pixels, self.lights.shape[1], self.shadows)


def candidates(theory: ErrorTheory, shadows: bool, material: Material | None) -> list[Candidate]:
    """Return the models that are compared where pictures have cast shadows and gloss or not."""
    found = [
        Candidate("linear3", False, None, np.eye(4)[1:]),
        Candidate("ambient4", False, None, np.eye(4)),
        *(Candidate(name, False, None, np.eye(count(order))) for name, order in HARMONIC.items()),
    ]
    if shadows:
        found += [Candidate(name, True, None, np.eye(count(order))) for name, order in SHADOWED.items()]
    if material is not None:
        orders = SHADOWED if shadows else HARMONIC
        found += [Candidate(f"{name}+gloss", shadows, material, np.eye(count(n))) for name, n in orders.items()]
    components = theory.principal_lights((shadows, material is not None), PRINCIPAL[-1])
    suffix = "" if material is None else "+gloss"
    few = [number for number in PRINCIPAL if number <= len(components)]
    found += [Candidate(f"pca{number}{suffix}", shadows, material, components[:number]) for number in few]
    return found


def padded(lights: Array) -> Array:
    """Return combinations of the images up to a model's highest order, (k, 49)."""
    if lights.shape[1] > count(MODEL_ORDER):
        raise HarmonicFaceError(f"lights: expected at most {count(MODEL_ORDER)} coefficients, got {lights.shape[1]}")
    return np.pad(lights, ((0, 0), (0, count(MODEL_ORDER) - lights.shape[1])))
