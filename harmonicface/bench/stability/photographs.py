"""Rows of the stability table: photometric stereo of hard photographs, and whether it is as sure as it should be."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from harmonicface._validate import Floats
from harmonicface.bench.stability.hard_photographs import SIDE, HardCase, hard_cases
from harmonicface.bench.stability.row import SURE, Answers, Measured
from harmonicface.stereo.photometric_stereo import photometric_stereo

ROUNDING = 0.05  # degrees, of float32 and of what is left of a solver's iterations
UNSURE = 5.0  # degrees: what has to be stated at least where the photographs tell nothing
SOLVER = "photometric_stereo, "


def of_photographs(side: int = SIDE) -> Answers:
    """Return a function for each case under each kind of light that it is about.

    Parameters
    ----------
    side
        Of the photographs, in pixels.

    Examples
    --------
    >>> found = of_photographs(24)["photometric_stereo, lights known", "nothing hard"]()
    >>> found.error < found.allowed < 5
    True
    """
    return {
        (f"{SOLVER}{lights}", case.name): partial(_measured, case, lights == "lights known", options)
        for case in hard_cases(side)
        for lights, options in _kinds(case)
    }


def _kinds(case: HardCase) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what is said of the lights, with the options."""
    if case.known is not None:
        yield "lights known", case.known
    if case.unknown is None:
        return
    if "intensities" in case.unknown:
        yield "lamps unknown", case.unknown
        return
    if "model" not in case.unknown:
        yield "lamps unknown", {**case.unknown, "model": "linear3"}
    yield "any light unknown", case.unknown


def _measured(case: HardCase, known: bool, options: dict[str, Any]) -> Measured:
    """Compare the median of the angles to the true normals with three standard errors as stated at the median."""
    given = case.lights if known else None
    found = photometric_stereo(case.images, given, case.mask, integration="none", **options)
    stated = found.confidence[case.mask].astype(np.float64)
    angles = _angles(found.surface.normals[case.mask], case.normals)
    told = np.isfinite(angles)
    note = f"degrees; {found.model}, ambiguity: {found.ambiguity.name}"
    if found.left_out:
        note += f", left out: {', '.join(map(str, found.left_out))}"
    if not told.any():
        note += ", stated where the photographs tell nothing, and the least that is to be stated there"
        return Measured(UNSURE, float(np.median(stated)), None, note)
    if not told.all() and np.median(stated[~told]) < UNSURE:
        return Measured(np.inf, UNSURE, None, f"{note}, sure of pixels that tell nothing")
    allowed = SURE * stated[told] + ROUNDING
    over = float((angles[told] > allowed).mean())
    note += (
        f", {angles[told].mean():.3g} on average, {over:.1%} of the pixels off by more than three times what they state"
    )
    return Measured(float(np.median(angles[told])), float(np.median(allowed)), None, note)


def _angles(found: Floats, truth: Floats) -> Floats:
    """Return the angles in degrees between unit vectors."""
    cosines = np.einsum("pk,pk->p", found.astype(np.float64), truth)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))
