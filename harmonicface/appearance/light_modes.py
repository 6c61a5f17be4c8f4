"""Names for what a photograph tells of the light, and for what it does not: single modes or combinations of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats

SINGLE = 1e-9  # a coefficient's axis that is this near to lying in a space is named by itself
INDEPENDENT = 1e-6  # what must be left of a unit vector to be a direction of its own
VISIBLE = 0.05  # terms of a combination below this are left out of its name
LONGEST = 6  # terms of a name

ODD = "an odd degree above 1: no matte surface shows it"
HIDDEN = "hidden: no visible normal tells it from the rest of the light"
DROPPED = "dropped: not told from noise"
NOISE = "lost in noise: its error is larger than the ambient light"


@dataclass(frozen=True, eq=False)
class LightMode:
    """A direction in the space of light coefficients, and why it is listed.

    Parameters
    ----------
    direction
        ((order + 1)^2,) unit vector: one 1 for a single harmonic, several numbers for a combination.
    reason
        What the photograph says of it.
    channel
        Of a colour photograph, the channel 0, 1 or 2; None if it is so in all of them.

    Examples
    --------
    >>> LightMode(np.array([0.6, 0.0, -0.8, 0.0]), HIDDEN).name
    '0.60 L(0,0) - 0.80 L(1,0)'
    """

    direction: Floats
    reason: str
    channel: int | None = None

    @property
    def name(self) -> str:
        """The mode as `L(l,m)`, or as a combination of the strongest of them."""
        return mode_name(self.direction)

    def __str__(self) -> str:
        where = "" if self.channel is None else f" (channel {self.channel})"
        return f"{self.name}{where}: {self.reason}"


def mode_name(direction: Floats) -> str:
    """Return a direction of light coefficients in words: 'L(2,0)', or '0.60 L(0,0) - 0.80 L(1,0)'."""
    large = np.flatnonzero(np.abs(direction) >= VISIBLE)
    if len(large) == 1:
        return _coefficient(large[0])
    told = np.sort(large[np.argsort(-np.abs(direction[large]), kind="stable")[:LONGEST]])
    terms = [f"{'-' if direction[i] < 0 else '+'} {abs(direction[i]):.2f} {_coefficient(i)}" for i in told]
    text = " ".join(terms)
    first = text[2:] if text[0] == "+" else "-" + text[2:]
    return first if len(told) == len(large) else first + " ..."


def simple_basis(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a basis (n, k) of the space that orthonormal rows (n, k) span, single coefficients first.

    What is left when the axes that lie in the space are taken out keeps the given directions' order as far as it can.
    """
    count, size = directions.shape
    alone = np.flatnonzero((directions**2).sum(axis=0) > 1 - SINGLE)
    basis = np.eye(size)[alone]
    for row in directions:
        if len(basis) == count:
            break
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)  # twice: Gram-Schmidt keeps orthogonality to rounding then
        if (length := np.linalg.norm(rest)) > INDEPENDENT:
            basis = np.vstack([basis, rest * np.sign(rest[np.abs(rest).argmax()]) / length])
    return basis


def _coefficient(index: int) -> str:
    """Return 'L(l,m)' of a stored coefficient."""
    degree = int(np.sqrt(index))
    return f"L({degree},{index - degree * (degree + 1)})"
