"""The evaluation on an object of DiLiGenT: how far the normals are from the measured ones, method by method."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.datasets.diligent import DiligentObject, load_diligent
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.bad_images import find_bad_images
from harmonicface.stereo.least_squares import plain_least_squares
from harmonicface.stereo.robust import robust_normals
from harmonicface.stereo.semi_calibrated import semi_calibrated
from harmonicface.stereo.unknown_directions import unknown_directions
from harmonicface.stereo.unknown_lamps import unknown_lamps

Mask = NDArray[np.bool_]
PUBLISHED = {"ballPNG": 4.10, "bearPNG": 8.39, "catPNG": 8.41, "readingPNG": 19.80}  # least squares, Shi et al. 2016


@dataclass(frozen=True)
class MethodResult:
    """How one method did.

    Parameters
    ----------
    mean_deg, median_deg
        Of the angles between normals found and measured.
    seconds
        Wall time, the reading of files not included.
    left_out
        Photographs that the method did not use because they do not belong, by their number in the folder's order.
    """

    mean_deg: float
    median_deg: float
    seconds: float
    left_out: tuple[int, ...] = ()


@dataclass(frozen=True)
class DiligentResult:
    """The table of an object.

    Parameters
    ----------
    object
        The folder's name.
    photographs, pixels
        How many there are; pixels without a measured normal are not counted.
    methods
        By name.
    left_out
        Photographs that do not belong, by file name, each with its reason.
    failed
        Methods that refused, each with its reason.
    """

    object: str
    photographs: int
    pixels: int
    methods: dict[str, MethodResult]
    left_out: dict[str, str] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Case:
    """An object, and which of its photographs belong."""

    object: DiligentObject
    kept: Mask


def _least_squares(case: _Case) -> Floats:
    """Woodham: all photographs, all pixels, nothing left out."""
    return plain_least_squares(case.object.grey(), case.object.directions)


def _robust(case: _Case) -> Floats:
    """Known lamps; photographs that do not belong and saturated observations left out."""
    known, kept = case.object, case.kept
    return robust_normals(known.grey()[kept], known.directions[kept], usable=~known.saturated()[kept]).scaled


def _semi_calibrated(case: _Case) -> Floats:
    """Known directions, brightness found from the photographs."""
    known, kept = case.object, case.kept
    observations, lamps, usable = known.grey(divided=False)[kept], known.directions[kept], ~known.saturated()[kept]
    brightness = semi_calibrated(observations, lamps, usable).values
    return robust_normals(observations, lamps * brightness[:, None], usable=usable).scaled


def _unknown_directions(case: _Case) -> Floats:
    """Intensities divided out, directions found from the photographs."""
    observations, ceiling = _with_ceiling(case, divided=True)
    return unknown_directions(observations, case.object.mask, ceiling).pixels.scaled


def _unknown(case: _Case) -> Floats:
    """Nothing known but the photographs and the mask."""
    observations, ceiling = _with_ceiling(case, divided=False)
    return unknown_lamps(observations, case.object.mask, saturation=ceiling).pixels.scaled


def _with_ceiling(case: _Case, *, divided: bool) -> tuple[Floats, float]:
    """Return grey levels in which saturated ones stand at a common ceiling, and the ceiling."""
    observations = case.object.grey(divided=divided)
    ceiling = float(observations.max()) * 1.001
    observations[case.object.saturated()] = ceiling
    return observations, ceiling


METHODS: dict[str, Callable[[_Case], Floats]] = {
    "least_squares": _least_squares,
    "robust": _robust,
    "semi_calibrated": _semi_calibrated,
    "unknown_directions": _unknown_directions,
    "unknown": _unknown,
}
LEAVING_OUT = ("robust", "semi_calibrated")


def evaluate_diligent(
    folder: str | os.PathLike[str],
    methods: Sequence[str] = tuple(METHODS),
    tell: Callable[[str, int, int], None] = lambda *_: None,
) -> DiligentResult:
    """Find the normals of an object of DiLiGenT by each method, and the angles to the measured ones.

    Parameters
    ----------
    folder
        The object's (see `load_diligent`).
    methods
        Names from `METHODS`: "least_squares" and "robust" know the lamps, "semi_calibrated" their directions,
        "unknown_directions" their brightness, "unknown" nothing.
    tell
        Called with what is being done, how much of it, of how much.

    Returns
    -------
    DiligentResult
        Photographs that do not belong to the others are looked for with known lamps, before "robust" and
        "semi_calibrated", and not used by these two.

    Raises
    ------
    HarmonicFaceError
        No such method, what `load_diligent` refuses. A method that refuses the object is reported in `failed`.
    """
    for name in methods:
        if name not in METHODS:
            raise HarmonicFaceError(f"methods: expected names from {', '.join(METHODS)}, got {name!r}")
    tell("photographs", 0, 1)
    known = load_diligent(folder)
    tell("photographs", 1, 1)
    start = time.perf_counter()
    bad = find_bad_images(known.grey(), known.directions, usable=~known.saturated())
    looking = time.perf_counter() - start
    case = _Case(known, bad.kept(len(known.files)))
    found: dict[str, MethodResult] = {}
    failed: dict[str, str] = {}
    for done, name in enumerate(methods):
        tell("methods", done, len(methods))
        start = time.perf_counter()
        try:
            scaled = METHODS[name](case)
        except HarmonicFaceError as error:
            failed[name] = str(error)
            continue
        angles = angular_errors(scaled, known.normals)
        seconds = time.perf_counter() - start + (looking if name in LEAVING_OUT else 0)
        left = tuple(sorted(bad.left_out)) if name in LEAVING_OUT else ()
        found[name] = MethodResult(float(angles.mean()), float(np.median(angles)), seconds, left)
    tell("methods", len(methods), len(methods))
    reasons = {known.files[index].name: reason for index, reason in bad.left_out.items()}
    measured = int(known.normals.any(axis=1).sum())
    return DiligentResult(known.name, len(known.files), measured, found, reasons, failed)


def angular_errors(scaled: Floats, true: Floats) -> NDArray[np.float64]:
    """Return the angles in degrees between vectors and the measured normals, where there are such.

    Parameters
    ----------
    scaled
        (p, 3) vectors of any length; one of length 0 says nothing and errs by 90 degrees.
    true
        (p, 3) unit normals; zeros where none was measured.

    Examples
    --------
    >>> angular_errors(np.array([[0.0, 0.0, 2.0], [3.0, 0.0, 3.0]]), np.array([[0.0, 0.0, 1.0]] * 2)).round(6)
    array([ 0., 45.])
    """
    measured = true.any(axis=1)
    found, right = np.asarray(scaled, np.float64)[measured], true[measured]
    across = np.linalg.norm(np.cross(found, right), axis=1)
    along = np.einsum("pi,pi->p", found, right)
    return np.asarray(np.where(found.any(axis=1), np.degrees(np.arctan2(across, along)), 90.0))


def diligent_json(result: DiligentResult) -> dict[str, object]:
    """Return what `evaluate diligent --json` prints.

    Examples
    --------
    >>> diligent_json(DiligentResult("ballPNG", 96, 2, {"robust": MethodResult(1.5, 1.0, 3.0)}))["methods"]
    {'robust': {'mean_deg': 1.5, 'median_deg': 1.0, 'seconds': 3.0, 'left_out': []}}
    """
    return {
        "object": result.object,
        "photographs": result.photographs,
        "pixels": result.pixels,
        "methods": {
            name: {
                "mean_deg": method.mean_deg,
                "median_deg": method.median_deg,
                "seconds": method.seconds,
                "left_out": list(method.left_out),
            }
            for name, method in result.methods.items()
        },
        "left_out": result.left_out,
        "failed": result.failed,
    }


def diligent_table(result: DiligentResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per method mean and median angular error in degrees, seconds, photographs left out."""
    rows = [
        [name, f"{method.mean_deg:.2f}", f"{method.median_deg:.2f}", f"{method.seconds:.1f}", str(len(method.left_out))]
        for name, method in result.methods.items()
    ]
    if result.object in PUBLISHED:
        rows.append(["least squares as published", f"{PUBLISHED[result.object]:.2f}", "-", "-", "-"])
    return ["method", "mean °", "median °", "s", "left out"], rows
