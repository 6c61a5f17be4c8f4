"""Pictures of what photometric stereo found: photographs beside their model, a relit face turned round, the lights."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.render import render
from harmonicface.bench.drawing import ACCENT, INK, png
from harmonicface.bench.pictures import white_ball
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of
from harmonicface.io.pictures import signed_colours, to_display
from harmonicface.lighting.lights import from_angles
from harmonicface.stereo.in_blocks import Images
from harmonicface.stereo.result import StereoResult
from harmonicface.surfaces.operations import resize
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.turning import turn

PAPER = 0.96  # display value of what is no surface
SIDE = 240  # pixels of a picture in a strip
LAMPS = ((-70, 15), (-40, 25), (0, 60), (0, 15), (0, -40), (40, 25), (70, 15))  # degrees to the right, and up
YAWS = (-60, -40, -20, 0, 20, 40, 60)
CLAY = 0.8
FULL = 0.1  # of white: what is shown in full colour in differences
WORST = 30.0  # degrees of standard error that are shown in full colour
MARGIN = 0.06  # of the mask's size, around it
MOST_BALLS = 12
SHOWN = 6  # photographs beside their model


def window(mask: NDArray[np.bool_], margin: float = MARGIN) -> tuple[slice, slice]:
    """Return the rows and columns of a mask, with some around it."""
    spans = []
    for axis, length in ((1, mask.shape[0]), (0, mask.shape[1])):
        inside = np.flatnonzero(mask.any(axis=axis))
        more = round(margin * (inside[-1] + 1 - inside[0]))
        spans.append(slice(max(int(inside[0]) - more, 0), min(int(inside[-1]) + 1 + more, length)))
    return spans[0], spans[1]


def small(surface: Surface, side: int = SIDE) -> Surface:
    """Return a Surface of at most so many pixels a side, cut to its mask, without its scene."""
    part = window(surface.mask, 0.0)
    depth = None if surface.depth is None else surface.depth[part]
    cut = Surface(surface.normals[part], surface.albedo[part], surface.mask[part], depth, surface.pixel_size)
    largest = max(cut.shape)
    if largest <= side:
        return cut
    height, width = (max(round(length * side / largest), 1) for length in cut.shape)
    return resize(cut, (height, width))


def with_room(surface: Surface) -> Surface:
    """Return a Surface with as much room on both sides as turning it needs."""
    assert surface.depth is not None
    depth = surface.depth[surface.mask].astype(np.float64) / surface.pixel_size
    half, deep = surface.shape[1] / 2, float(np.ptp(depth)) / 2
    widest = max(half * np.cos(np.radians(yaw)) + deep * np.sin(np.radians(abs(yaw))) for yaw in YAWS)
    more = int(np.clip(widest - half, 0, half)) + 2
    beside = ((0, 0), (more, more))
    return Surface(
        np.pad(surface.normals, (*beside, (0, 0))),
        np.pad(surface.albedo, (*beside, (0, 0))[: surface.albedo.ndim]),
        np.pad(surface.mask, beside),
        np.pad(surface.depth, beside),
        surface.pixel_size,
    )


def white_of(surface: Surface) -> float:
    """Return the albedo that pictures show as white: all but the brightest hundredth lie below it."""
    values = surface.pixel_albedo
    bright = float(np.quantile(values, 0.99))
    return bright if bright > 0 else 1.0


def shaded(surface: Surface, light: tuple[float, float], clay: bool, white: float) -> Floats:
    """Return a picture under a lamp at angles to the right and up, (h, w, 3) display values."""
    albedo = np.full(surface.shape, CLAY, np.float32) if clay else surface.albedo / white * CLAY
    shown = Surface(surface.normals, albedo, surface.mask, surface.depth, surface.pixel_size)
    lit = render(shown, from_angles(*light))
    picture = to_display(np.clip(1.15 * lit + 0.03 * albedo, 0, None), 1.0)
    coloured = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
    coloured[~surface.mask] = PAPER
    return coloured


def relit_strip(surface: Surface) -> Floats:
    """Return rows of pictures: a lamp goes round; the surface turns under one lamp; it turns as clay, without albedo.

    Without depth there are the lamps alone, with and without albedo.
    """
    face, white = small(surface), white_of(surface)
    rows = [[shaded(face, lamp, False, white) for lamp in LAMPS]]
    if face.depth is None:
        rows.append([shaded(face, lamp, True, white) for lamp in LAMPS])
        return _montage(rows)
    roomy = with_room(face)
    turned = [_turned(roomy, yaw) for yaw in YAWS]
    rows[0] = [shaded(roomy, lamp, False, white) for lamp in LAMPS]
    for clay in (False, True):
        lamp = (-35, 30)
        rows.append([_blank(roomy) if each is None else shaded(each, lamp, clay, white) for each in turned])
    return _montage(rows)


def reprojections(result: StereoResult, images: Images) -> tuple[Floats, list[int], float]:
    """Return photographs, what the model makes of them and the difference, in three rows; which ones; white.

    In differences red is where the photograph is brighter than its model, blue where it is darker; full colour is a
    tenth of white.
    """
    surface, part = result.surface, window(result.surface.mask)
    used = [index for index in range(len(images)) if index not in result.left_out]
    chosen = sorted({used[round(each)] for each in np.linspace(0, len(used) - 1, min(SHOWN, len(used)))})
    step = max(-(-max(surface.mask[part].shape) // SIDE), 1)
    thin = slice(part[0].start, part[0].stop, step), slice(part[1].start, part[1].stop, step)
    albedo = surface.albedo[thin] if surface.albedo.ndim == 2 else surface.albedo[thin].mean(axis=2)
    mask = surface.mask[thin]
    face = Surface(surface.normals[thin], albedo, mask)
    photographs = [_grey(np.asarray(images[index][thin])) for index in chosen]
    modelled = [spread_out(model_of(face, result.lights[index]), mask) for index in chosen]
    white = max(float(np.quantile(np.stack(photographs)[:, mask], 0.995)), 1e-9)
    rows: list[list[Floats]] = [[], [], []]
    for photograph, model in zip(photographs, modelled, strict=True):
        rows[0].append(_coloured(to_display(photograph, white)))
        shown = _coloured(to_display(np.maximum(model, 0), white))
        shown[~mask] = PAPER
        rows[1].append(shown)
        rows[2].append(signed_colours(np.where(mask, photograph - model, 0.0), mask, FULL * white))
    return _montage(rows), chosen, white


def model_of(surface: Surface, light: Floats) -> Floats:
    """Return what the model says of the masked pixels of a grey Surface, (p,), under a light as results have it."""
    if len(light) == 3:
        return np.asarray(surface.pixel_albedo * np.maximum(surface.pixel_normals @ light, 0))
    return np.asarray(light @ harmonic_images(surface, order_of(len(light))))


def spread_out(values: Floats, mask: NDArray[np.bool_]) -> Floats:
    """Lay values of masked pixels out as a picture."""
    picture = np.zeros(mask.shape, np.float64)
    picture[mask] = values
    return picture


def error_pictures(result: StereoResult) -> dict[str, Floats]:
    """Return pictures of the residual and of the standard error of the normals, display values (h, w, 3).

    The residual's full colour is its 99th percentile; that of the standard error 30 degrees, where nothing is known
    too.
    """
    mask = result.surface.mask
    residual = result.residual / (float(np.quantile(result.residual[mask], 0.99)) or 1.0)
    error = np.minimum(result.confidence / WORST, 1.0)
    return {"residual": _heat(residual, mask), "confidence": _heat(error, mask)}


def singular_values_picture(result: StereoResult) -> bytes:
    """Draw the singular values of the photographs, those of the model in colour."""
    size = {"linear3": 3, "ambient4": 4, "harmonic9": 9}[result.model]
    values = result.singular_values[: max(3 * size, 16)]
    relative = values / (values[0] or 1.0)
    figure = Figure(figsize=(7, 2.4), layout="constrained")
    axis = figure.add_subplot()
    numbers = np.arange(1, len(relative) + 1)
    colours = [ACCENT if number <= size else "#b9c4cd" for number in numbers]
    floor = max(relative[relative > 0].min(initial=1.0) / 2, 1e-8)
    axis.bar(numbers, np.maximum(relative, floor) - floor, bottom=floor, color=colours, width=0.7)
    axis.set_yscale("log")
    axis.set_xticks(numbers)
    axis.set_xlabel("singular value", color=INK)
    axis.set_ylabel("over the largest", color=INK)
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    return png(figure)


def lights_picture(result: StereoResult, names: Sequence[str]) -> bytes:
    """Draw where the lamps are, seen by the camera; or balls under the lights, where they are no lamps."""
    kept = [index for index in range(len(result.lights)) if index not in result.left_out]
    if result.lights.shape[1] == 3:
        return _lamps(result.lights[kept], kept)
    ball = white_ball(96)
    shown = kept[:MOST_BALLS]
    pictures = [spread_out(np.maximum(model_of(ball, result.lights[index]), 0), ball.mask) for index in shown]
    figure = Figure(figsize=(9, 1.3 * -(-len(shown) // 6) + 0.2), layout="constrained")
    for place, (index, picture) in enumerate(zip(shown, pictures, strict=True)):
        axis = figure.add_subplot(-(-len(shown) // 6), 6, place + 1)
        display = to_display(picture, 1.15 * float(picture.max()) or 1.0)
        display[~ball.mask] = 1
        axis.imshow(display, cmap="gray", vmin=0, vmax=1)
        axis.set_title(str(names[index])[:16], fontsize=7, color=INK)
        axis.axis("off")
    return png(figure)


def _lamps(lights: Floats, numbers: Sequence[int]) -> bytes:
    """Draw directions on the disc that the camera sees of the half sphere: the middle is behind the camera."""
    strength = np.linalg.norm(lights, axis=1)
    directions = lights / strength[:, None]
    figure = Figure(figsize=(4.2, 4.2), layout="constrained")
    axis = figure.add_subplot(projection="polar")
    angles = np.degrees(np.arccos(np.clip(directions[:, 2], -1, 1)))
    around = np.arctan2(directions[:, 1], directions[:, 0])
    axis.scatter(around, angles, s=20 + 60 * strength / strength.max(), color=ACCENT, alpha=0.8, zorder=3)
    if len(lights) <= 30:
        for number, angle, turn_ in zip(numbers, angles, around, strict=True):
            axis.annotate(str(number + 1), (turn_, angle), textcoords="offset points", xytext=(5, 4), fontsize=8)
    reach = 30 * max(int(np.ceil(angles.max() / 30)), 1)
    axis.set_ylim(0, reach)
    axis.set_yticks(range(30, reach + 1, 30), [f"{each}°" for each in range(30, reach + 1, 30)], fontsize=7)
    axis.set_xticks(np.radians([0, 90, 180, 270]), ["right", "up", "left", "down"], fontsize=8)
    return png(figure)


def _turned(surface: Surface, yaw: float) -> Surface | None:
    """Return the surface turned; None where nothing of it can be seen."""
    if yaw == 0:
        return surface
    try:
        return turn(surface, (yaw, 0.0, 0.0))
    except HarmonicFaceError:
        return None


def _blank(surface: Surface) -> Floats:
    return np.full((*surface.shape, 3), PAPER)


def _grey(picture: Floats) -> Floats:
    return picture if picture.ndim == 2 else np.asarray(picture.mean(axis=2))


def _coloured(picture: Floats) -> Floats:
    return np.repeat(picture[..., None], 3, axis=2)


def _heat(share: Floats, mask: NDArray[np.bool_]) -> Floats:
    """Return numbers from 0 to 1 as colours from light to dark."""
    colours = np.asarray(matplotlib.colormaps["magma_r"](np.clip(share, 0, 1))[..., :3])
    colours[~mask] = PAPER
    return colours


def _montage(rows: list[list[Floats]], gap: int = 6) -> Floats:
    """Lay pictures of one size out in rows, with white between them."""
    height, width = rows[0][0].shape[:2]
    count = max(map(len, rows))
    sheet = np.ones((len(rows) * (height + gap) - gap, count * (width + gap) - gap, 3))
    for down, row in enumerate(rows):
        for across, picture in enumerate(row):
            top, left = down * (height + gap), across * (width + gap)
            sheet[top : top + height, left : left + width] = picture
    return sheet
