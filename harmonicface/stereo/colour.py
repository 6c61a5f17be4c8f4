"""Colour: the albedo of each colour, once normals and lights are known from the grey photographs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats

LEAST, MOST = 0.5, 1.5  # of what the matte model predicts: below is shadow, above a highlight


def colour_albedo(photographs: Iterable[Floats], shading: Iterable[Floats], albedo: Floats) -> NDArray[np.float32]:
    r"""Return the albedo of each colour by least squares over the photographs that show it matte and lit.

    .. math:: \rho_c = \sum_i s_i I_{ic} / \sum_i s_i^2

    with the shading s of each photograph, over those whose grey (the mean of the colours) lies between half and one
    and a half of the grey albedo's, :math:`\rho s_i`. A pixel without any is grey.

    Parameters
    ----------
    photographs
        n of (p, 3) linear intensities, one after the other, each divided by the colour of its light; infinite where
        they are saturated.
    shading
        n of (p,) irradiances: what an albedo of 1 would show.
    albedo
        (p,) grey albedo.

    Returns
    -------
    array
        (p, 3) float32, at least 0.

    Examples
    --------
    >>> shown = np.array([[0.2, 0.4, 0.6]])
    >>> colour_albedo([shown, 0.5 * shown], [np.array([1.0]), np.array([0.5])], np.array([0.4])).round(3)
    array([[0.2, 0.4, 0.6]], dtype=float32)
    """
    total = np.zeros((len(albedo), 3), np.float32)
    weight = np.zeros(len(albedo), np.float32)
    grey_albedo = albedo.astype(np.float32)
    for photograph, shade in zip(photographs, shading, strict=True):
        shown = photograph.astype(np.float32)
        lit = np.maximum(shade, 0).astype(np.float32)
        predicted, grey = grey_albedo * lit, shown.mean(axis=1)
        matte = (lit > 0) & (grey >= LEAST * predicted) & (grey <= MOST * predicted)
        lit[~matte] = 0
        shown[~matte] = 0
        total += lit[:, None] * shown
        weight += lit**2
    result = np.repeat(grey_albedo[:, None], 3, axis=1)
    np.divide(total, weight[:, None], out=result, where=weight[:, None] > 0)
    return np.maximum(result, 0)
