"""Transport: how much of each harmonic light reaches a pixel past what stands in its way."""

from __future__ import annotations

from dataclasses import dataclass

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of


@dataclass(frozen=True, eq=False)
class Transport:
    r"""The harmonic coefficients of visibility times the clamped cosine, one row a harmonic.

    .. math:: T_{lm}(x) = \int V(x, w) \max(n(x) \cdot w, 0) Y_{lm}(w) \, dw

    so that the irradiance with cast shadows is `light.coefficients(order) @ values` (Sloan, Kautz & Snyder,
    Precomputed Radiance Transfer, 2002). Without anything in the way it is A_l Y_lm(n).

    Parameters
    ----------
    values
        (k, p) finite numbers with k = (order + 1)^2 and p masked pixels in row-major order; (k, p, 3) where light
        that coloured skin throws back makes a difference between colours.
    bounces
        How often light may be thrown back from surface to surface before it arrives; 0 is direct light alone.

    Raises
    ------
    HarmonicFaceError
        Another shape, a count that is not a square number, NaN or infinity, a negative count of bounces.

    Examples
    --------
    >>> import numpy as np
    >>> Transport(np.zeros((9, 5))).order
    2
    """

    values: Floats
    bounces: int = 0

    def __post_init__(self) -> None:
        values = _validate.finite(self.values, "transport")
        if values.ndim not in (2, 3) or (values.ndim == 3 and values.shape[2] != 3):
            raise HarmonicFaceError(f"transport: expected shape (k, p) or (k, p, 3), got {values.shape}")
        order_of(len(values))
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "bounces", _validate.at_least(self.bounces, 0, "bounces"))

    @property
    def order(self) -> int:
        """The highest degree that it has rows for."""
        return order_of(len(self.values))
