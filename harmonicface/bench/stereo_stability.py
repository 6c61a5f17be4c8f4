"""Hard cases for photometric stereo: what is done with each, and whether it is as sure as it should be."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from harmonicface._validate import Floats
from harmonicface.bench.hard_photographs import SIDE, HardCase, hard_cases
from harmonicface.bench.measure import Record
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.photometric_stereo import photometric_stereo

Verdict = Literal["right", "wider stated uncertainty", "refused", "WRONG"]

SURE = 3.0  # standard errors: an error at most that large at the median is what was stated
ROUNDING = 0.05  # degrees, of float32 and of what is left of a solver's iterations
WIDER = 2.0  # times what is stated where nothing is hard
UNSURE = 5.0  # degrees: what has to be stated at least where the photographs tell nothing


@dataclass(frozen=True)
class Outcome:
    """What was done with a case.

    Parameters
    ----------
    case
        The difficulty.
    lights
        "known", "unknown lamps" or "unknown" (of which not even that they are lamps was said).
    verdict
        "right": no more than three stated errors off at the median; "wider stated uncertainty": the same, and less
        sure than without the difficulty; "refused"; "WRONG": surer than right.
    error
        Mean angle to the true normals in degrees; None where there are none, or no answer.
    median
        Median of it.
    stated
        Median standard error in degrees that was stated; infinite where nothing was determined.
    seconds
        Wall time.
    note
        The refusal, or what the result says of itself.
    """

    case: str
    lights: str
    verdict: Verdict
    error: float | None
    median: float | None
    stated: float | None
    seconds: float
    note: str


def stereo_outcomes(side: int = SIDE, *, quick: bool = False, only: str = "") -> Iterator[Outcome]:
    """Yield what is done with each case, under each kind of light that it is about.

    Parameters
    ----------
    side
        Of the photographs, in pixels.
    quick
        Without light of which nothing is known, which takes ten seconds a case, and without unknown lamps where they
        are unlikely to tell more than known ones.
    only
        Cases in whose names this stands; the first one, which nothing is hard about, always.

    Examples
    --------
    >>> [outcome.verdict for outcome in stereo_outcomes(24, quick=True, only="two images only")][2:]
    ['refused', 'refused', 'refused']
    """
    usual: dict[str, float] = {}
    for number, case in enumerate(hard_cases(side)):
        if number and only not in case.name:
            continue
        for lights, options in _kinds(case, quick):
            outcome = _outcome(case, lights, options, usual.get(lights))
            if outcome.stated is not None:
                usual.setdefault(lights, outcome.stated)
            yield outcome


def stability_records(*, quick: bool = False) -> list[Record]:
    """Return one record a case and kind of light: its error is the mean angle in degrees; the note has the verdict."""
    records = []
    for outcome in stereo_outcomes(quick=quick):
        said = "" if outcome.stated is None else f" (stated: {outcome.stated:.3g} degrees at the median)"
        note = f"{outcome.verdict}{said}; {outcome.note}"
        error = outcome.error
        records.append(Record(outcome.case, f"lights {outcome.lights}", outcome.seconds, error, note=note))
    return records


def verdict_of(median: float, stated: float, usual: float | None = None) -> Verdict:
    """Return the verdict on a result by its median error and its median stated error, in degrees.

    Parameters
    ----------
    median
        Of the angles to the true normals.
    stated
        Of the standard errors.
    usual
        Stated where nothing is hard.

    Examples
    --------
    >>> verdict_of(0.2, 0.3, 0.3), verdict_of(20.0, 15.0, 0.3), verdict_of(20.0, 1.0, 0.3)
    ('right', 'wider stated uncertainty', 'WRONG')
    """
    if median > SURE * stated + ROUNDING:
        return "WRONG"
    return "right" if usual is None or stated <= WIDER * usual else "wider stated uncertainty"


def _kinds(case: HardCase, quick: bool) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what is said of the lights, with the options."""
    if case.known is not None:
        yield "known", case.known
    if case.unknown is None:
        return
    if quick and not case.quick:
        return
    if "intensities" in case.unknown:
        yield "unknown lamps", case.unknown
        return
    if "model" not in case.unknown:
        yield "unknown lamps", {**case.unknown, "model": "linear3"}
    if not quick:
        yield "unknown", case.unknown


def _outcome(case: HardCase, lights: str, options: dict[str, Any], usual: float | None) -> Outcome:
    """Run one case."""
    start = time.perf_counter()
    given = case.lights if lights == "known" else None
    try:
        found = photometric_stereo(case.images, given, case.mask, integration="none", **options)
    except HarmonicFaceError as error:
        return Outcome(case.name, lights, "refused", None, None, None, time.perf_counter() - start, str(error))
    seconds = time.perf_counter() - start
    stated = found.confidence[case.mask].astype(np.float64)
    angles = _angles(found.surface.normals[case.mask], case.normals)
    told = np.isfinite(angles)
    note = f"{found.model}, ambiguity: {found.ambiguity.name}"
    if found.left_out:
        note += f", left out: {', '.join(map(str, found.left_out))}"
    if not told.any():
        whole = float(np.median(stated))
        verdict: Verdict = "wider stated uncertainty" if whole >= UNSURE else "WRONG"
        return Outcome(case.name, lights, verdict, None, None, whole, seconds, note)
    median, sure = float(np.median(angles[told])), float(np.median(stated[told]))
    verdict = verdict_of(median, sure, usual)
    if not told.all() and np.median(stated[~told]) < UNSURE:
        verdict, note = "WRONG", f"{note}, sure of pixels that tell nothing"
    over = float((angles[told] > SURE * stated[told] + ROUNDING).mean())
    note += f", {over:.1%} of the pixels off by more than three times what they state"
    return Outcome(case.name, lights, verdict, float(angles[told].mean()), median, sure, seconds, note)


def _angles(found: Floats, truth: Floats) -> Floats:
    """Return the angles in degrees between unit vectors."""
    cosines = np.einsum("pk,pk->p", found.astype(np.float64), truth)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))
