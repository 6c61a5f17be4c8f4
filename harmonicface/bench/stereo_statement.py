"""What photometric stereo could determine and what it could not, in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from harmonicface.stereo.result import Ambiguity, StereoResult

SURE = 10.0  # degrees of standard error
UNKNOWNS = {"linear3": 3, "ambient4": 4, "harmonic9": 9}
LIGHTS = {
    "linear3": "one distant lamp a photograph",
    "ambient4": "any distant light, to the first order of its harmonics",
    "harmonic9": "any distant light, to the second order of its harmonics",
}
FAMILIES = {
    "none": "The shape is determined: no other one explains the photographs as well.",
    "convex-concave": "Convex or concave is not determined: the mirror image in depth, lit from the other side,"
    " explains the photographs as well.",
    "bas-relief": "How deep the relief is, and whether it is tilted, is not determined: flatter, deeper and tilted"
    " versions with other lights and albedo explain the photographs as well (bas-relief ambiguity).",
    "lorentz": "The shape is one of a family with six parameters that explain the photographs alike, in first order.",
    "linear": "The shape is known up to an unknown 3 x 3 matrix only: it is distorted by as much.",
}


@dataclass(frozen=True)
class Circumstances:
    """What the user said, which the result does not tell.

    Parameters
    ----------
    lights
        Where the lights are from, as "the file lights.txt", or "" where they were unknown.
    mask
        Where the mask is from.
    metric
        What lengths are in, as "pixels".
    moved
        How far photographs were moved to register them, in pixels, at the most; None where they were not.
    """

    lights: str
    mask: str
    metric: str = "pixels"
    moved: float | None = None


def headline(result: StereoResult, told: Circumstances) -> str:
    """Say in a line what came out."""
    count = len(result.lights) - len(result.left_out)
    what = "Normals and albedo" if result.surface.depth is None else "Normals, albedo and depth"
    lights = "known" if told.lights else "found"
    doubt = "" if result.ambiguity.name == "none" else f"; {result.ambiguity.name} ambiguity"
    return f"{what} from {count} photographs, lights {lights}{doubt}"


def determined(result: StereoResult, told: Circumstances) -> list[str]:
    """Return what is known, a sentence or two each."""
    surface, mask = result.surface, result.surface.mask
    count = len(result.lights) - len(result.left_out)
    lights = (
        f"The lights were given by {told.lights}."
        if told.lights
        else f"The lights of {count} photographs were found from the photographs alone."
    )
    confidence = result.confidence[mask]
    finite = confidence[np.isfinite(confidence)]
    found = [f"{lights} Model: {LIGHTS[result.model]}. {sentence(result.model_reason)}"]
    if finite.size:
        sure = (confidence <= SURE).mean()
        member = "" if result.ambiguity.name == "none" else " within the family named below"
        found.append(
            f"Normals{member}: standard error {np.median(finite):.2g}° at the median, at most {SURE:.0f}° in"
            f" {sure:.0%} of the {_thousands(int(mask.sum()))} pixels. What the model takes for shape comes on top:"
            " gloss, cast shadows, light thrown back within the thing; on measured objects 1 to 13° at the mean."
        )
    rms = float(np.sqrt(np.mean(result.residual[mask].astype(np.float64) ** 2)))
    found.append(
        f"The model explains what was used of the photographs to {100 * rms:.2g} % of full scale (root mean square);"
        f" each pixel was solved from {np.median(result.used[mask]):.0f} photographs at the median."
    )
    if surface.depth is not None:
        height = float(np.ptp(surface.depth[mask]))
        found.append(f"Depth: {height:.4g} {told.metric} from back to front, by integration of the normals.")
    if result.ambiguity.name == "none":
        found.append(f"{FAMILIES['none']} {sentence(result.ambiguity.reason)}")
    if told.moved is not None:
        found.append(f"The photographs were registered: one was moved by {told.moved:.2g} pixels, the others by less.")
    return found


def undetermined(result: StereoResult, told: Circumstances, names: Sequence[str]) -> list[str]:
    """Return what is not known, or rests on an assumption, a sentence or two each."""
    mask = result.surface.mask
    found = []
    if result.ambiguity.name != "none":
        found.append(
            f"{FAMILIES[result.ambiguity.name]} {sentence(result.ambiguity.reason)}{_member(result.ambiguity)}"
        )
    unknown = float((~np.isfinite(result.confidence[mask])).mean())
    if unknown > 0:
        found.append(f"{_percent(unknown)} of the pixels are not determined: too few photographs show them lit.")
    for index, reason in result.left_out.items():
        found.append(f"{names[index]} was left out: {sentence(reason)}")
    if result.gap < 2:
        found.append(
            f"The singular values do not tell the model's size: the last one of it is {result.gap:.2g} times the next."
        )
    if result.surface.depth is not None:
        parts = int(label(mask)[1])
        if parts > 1:
            found.append(f"How the {parts} parts of the mask lie to one another in depth: normals do not tell.")
        scale = "" if told.metric != "pixels" else "; lengths are in pixels, since nothing tells how large one is"
        found.append(f"The distance to the camera{scale}.")
    albedo = "Albedo is relative: " + (
        "lamps of brightness 1 would make it absolute." if told.lights else "the brightness of unknown lights is free."
    )
    found.append(albedo)
    found.append(f"What belongs to the thing was decided by {told.mask}.")
    return found


def _member(ambiguity: Ambiguity) -> str:
    """Name the member of the family that was chosen, and how far it may be off."""
    values = []
    for name, value in ambiguity.parameters.items():
        if not name.endswith("_std"):
            deviation = ambiguity.parameters.get(f"{name}_std")
            values.append(f"{name} = {value:.3g}" + ("" if deviation is None else f" ± {deviation:.2g}"))
    return f" Chosen: {', '.join(values)}." if values else ""


def sentence(text: str) -> str:
    """Return a text that begins and ends as a sentence does.

    Examples
    --------
    >>> sentence("the lights are known")
    'The lights are known.'
    """
    trimmed = text.strip()
    if not trimmed:
        return ""
    return trimmed[0].upper() + trimmed[1:] + ("" if trimmed[-1] in ".!?" else ".")


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %" if share >= 0.001 else "Less than 0.1 %"


def _thousands(number: int) -> str:
    return f"{number:,}".replace(",", " ")
