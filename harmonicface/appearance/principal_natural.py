"""Statistics of natural light: mean and covariance of the harmonics of the environments that `natural` draws."""

from __future__ import annotations

import json
from functools import lru_cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from harmonicface.harmonics.indexing import count
from harmonicface.harmonics.rotation import rotation_blocks
from harmonicface.lighting.natural import natural

Array = NDArray[np.float64]

ORDER = 12
TABLE = "principal_natural.json"
DRAWS = 20_000
DIGITS = 6
UPRIGHT = Rotation.from_euler("x", 90, degrees=True)  # turns +y, up, to +z, the axis of the harmonics


@lru_cache
def natural_statistics() -> tuple[Array, Array]:
    """Return the mean (169,) and covariance (169, 169) of the light coefficients of natural light, to order 12.

    They are those of 20,000 environments of `lights.natural`, each turned about the vertical by all angles: nothing in
    how they are drawn prefers one. So they are known to about 1 %.
    """
    table = json.loads(files(__package__).joinpath(TABLE).read_text(encoding="utf-8"))
    return expanded(np.array(table["mean"]), [np.array(block) for block in table["covariance"]])


def sampled(draws: int, seed: int) -> tuple[Array, list[Array]]:
    r"""Return what the table holds, from environments drawn anew.

    With the vertical as the axis of the harmonics, the mean over all turns about it leaves

    .. math:: <L_{lm}> = \delta_{m0} \mu_l, \quad
              <L_{lm} L_{l'm'}> = \delta_{mm'} \frac{1}{2} (<L_{l|m|} L_{l'|m|}> + <L_{l-|m|} L_{l'-|m|}>)

    and the covariance is that less mu_l mu_l' for m = 0.

    Parameters
    ----------
    draws
        How many.
    seed
        Of the generator that draws them.

    Returns
    -------
    mean, covariance
        (13,) numbers mu_l; for m = 0 ... 12 the matrix (13 - m, 13 - m) over l, l' = m ... 12.
    """
    rng = np.random.default_rng(seed)
    upright = block_diag(*rotation_blocks(UPRIGHT, ORDER))
    lights = np.stack([natural(rng).coefficients(ORDER) for _ in range(draws)]) @ upright.T
    axial = np.array([degree * (degree + 1) for degree in range(ORDER + 1)])
    mean = lights[:, axial].mean(axis=0)
    lights[:, axial] -= mean
    blocks = []
    for mode in range(ORDER + 1):
        degree = np.arange(mode, ORDER + 1)
        centre = degree * (degree + 1)
        both = np.stack([lights[:, centre + mode], lights[:, centre - mode]])
        blocks.append(np.einsum("sni,snj->ij", both, both) / (2 * draws))
    return mean, blocks


def expanded(mean: Array, blocks: list[Array]) -> tuple[Array, Array]:
    """Return the mean (169,) and covariance (169, 169) of what `sampled` found, in the package's axes."""
    size = count(ORDER)
    whole, covariance = np.zeros(size), np.zeros((size, size))
    for mode, block in enumerate(blocks):
        degree = np.arange(mode, ORDER + 1)
        for places in {mode: degree * (degree + 1) + mode, -mode: degree * (degree + 1) - mode}.values():
            covariance[np.ix_(places, places)] = block
    degree = np.arange(ORDER + 1)
    whole[degree * (degree + 1)] = mean
    upright = block_diag(*rotation_blocks(UPRIGHT, ORDER))
    return upright.T @ whole, upright.T @ covariance @ upright


def write_table(draws: int = DRAWS, seed: int = 0) -> str:
    """Return the text of the table."""
    mean, blocks = sampled(draws, seed)
    rounded = [[[float(f"{value:.{DIGITS}g}") for value in row] for row in block] for block in blocks]
    lines = ",\n  ".join(json.dumps(block) for block in rounded)
    numbers = json.dumps([float(f"{value:.{DIGITS}g}") for value in mean])
    return f'{{"draws": {draws}, "seed": {seed}, "mean": {numbers},\n "covariance": [\n  {lines}]}}\n'
