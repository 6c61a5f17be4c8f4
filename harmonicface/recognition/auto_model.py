"""The pictures that natural light takes of a Surface: as few for each person as tell her from others."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.choose import choose_model
from harmonicface.appearance.principal_lights import HIGHEST_ORDER
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting.natural import natural
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

# The weights of dim pictures and the tolerance were tried on galleries of 120 to 500 synthetic people, in which a fifth
# row brought no fewer wrong answers; benchmarks/choose.py asks another.
TOLERANCE = 0.15
DRAWS = 400
NORMALS = 1000


def auto(surface: Surface) -> Floats:
    """Return as few pictures as natural light takes of this Surface, (169 or fewer, p) of low rank.

    Those of the cheapest model that leaves at most 0.15 of pictures under `dim_natural_light`: four independent ones
    of most faces (see `choose_model`). They are harmonic images projected onto the model's lights, so combining them to
    a photograph gives its light. As the nine images they are without cast shadows. Under natural light, in galleries
    of 120 people, of 1,440 photographs none was given to the wrong person.
    """
    choice = choose_model(surface, dim_natural_light(), TOLERANCE, shadows=False)
    pictures = choice.pictures(surface).astype(np.float64)  # whatever the Surface is: rank must not drown in rounding
    return np.asarray(np.linalg.pinv(choice.lights) @ pictures)


@lru_cache
def dim_natural_light() -> Array:
    r"""Return the second moment of natural light, (169, 169), in which lights count for more that give a face less.

    .. math:: \Big\langle \frac{L L^T}{b(L)^2} \Big\rangle, \quad b(L) = \langle E(n)^2 \rangle_{n_z > 0}

    A gallery compares pictures whatever their brightness. Light from behind gives a dim picture, whose error would
    count for nothing; but it is the hardest, and if anybody is taken for somebody else, it is there.
    """
    normals = np.random.default_rng(0).normal(size=(NORMALS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[:, 2] = np.abs(normals[:, 2])
    images = lambertian_weights(HIGHEST_ORDER)[:, None] * real_harmonics(normals, HIGHEST_ORDER)
    lights = np.stack([natural(seed, 16).coefficients(HIGHEST_ORDER) for seed in range(DRAWS)])
    brightness = np.mean((lights @ images) ** 2, axis=1)
    return np.asarray((lights / brightness[:, None] ** 2).T @ lights / DRAWS)
