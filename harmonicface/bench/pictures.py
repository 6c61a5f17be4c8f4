"""The pictures of the report: lights, harmonic images, explanations of photographs, error against time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.render import render
from harmonicface.bench.benchmark import BenchmarkResult, Query
from harmonicface.bench.drawing import BESIDE, INK, png
from harmonicface.bench.measure import Record
from harmonicface.bench.speed_plot import Point, speed_error_picture
from harmonicface.gallery.gallery import Gallery
from harmonicface.io.pictures import signed_colours, to_display
from harmonicface.surfaces.surface import Surface

HARMONIC_NAMES = ("1", "y", "z", "x", "xy", "yz", "3z²-1", "xz", "x²-y²")
EXAMPLES = 4


def lights_picture(result: BenchmarkResult) -> bytes:
    """Draw white balls under lights of each tier, beside the photographs that they make."""
    ball = white_ball(96)
    figure, axes = _grid(len(result.asked), 2 * EXAMPLES, 1.05)
    for row, (tier, queries) in zip(axes, result.asked.items(), strict=True):
        row[0].set_ylabel(tier, rotation=0, ha="right", va="center", color=INK, fontsize=10)
        for column, query in enumerate(_spread(queries, EXAMPLES)):
            row[2 * column].imshow(to_display(render(ball, query.light)), cmap="gray")
            row[2 * column + 1].imshow(to_display(query.photo, scale=1.0), cmap="gray", vmin=0, vmax=1)
    return png(figure)


def harmonics_picture(surface: Surface) -> bytes:
    """Draw the nine harmonic images of a person: red adds light, blue takes it away."""
    figure, axes = _grid(1, 9, 1.1)
    for axis, image, name in zip(axes[0], harmonic_images(surface), HARMONIC_NAMES, strict=True):
        picture = np.zeros(surface.shape, np.float32)
        picture[surface.mask] = image
        axis.imshow(signed_colours(picture, surface.mask))
        axis.set_title(name, fontsize=10, color=INK)
    return png(figure)


def explanations_picture(result: BenchmarkResult, tiers: Sequence[str] = ()) -> bytes:
    """Draw a photograph of each tier (all by default), explained by the right and by the nearest wrong person."""
    titles = ("photograph", "gallery saw", "right person", "residual", "nearest wrong", "residual")
    shown = tiers or tuple(result.asked)
    figure, axes = _grid(len(shown), len(titles), 1.25)
    for axis, title in zip(axes[0], titles, strict=True):
        axis.set_title(title, fontsize=10, color=INK)
    for number, (row, tier) in enumerate(zip(axes, shown, strict=True)):
        queries = result.asked[tier]
        row[0].set_ylabel(tier, rotation=0, ha="right", va="center", color=INK, fontsize=10)
        _explain(row, result, queries[(2 * number + 1) * len(queries) // (2 * len(shown))])
    return png(figure)


def tradeoff_picture(records: Sequence[Record]) -> bytes:
    """Draw the error against the time of a photograph, one point a method."""
    points = [Point(one.name, one.seconds, one.error or 0.0, one.name not in BESIDE) for one in records]
    return speed_error_picture(points, records[0].unit, "time a photograph")


def _explain(row: Sequence[Axes], result: BenchmarkResult, query: Query) -> None:
    """Fill one row: photograph, gallery picture, right person, wrong person, with residuals in the same scale."""
    gallery: Gallery = result.gallery
    right = result.people[query.person].name
    candidates = gallery.match(query.photo, top=len(gallery)).candidates
    wrong = next(candidate.name for candidate in candidates if candidate.name != right)
    distances = {candidate.name: candidate.distance for candidate in candidates}
    row[0].imshow(to_display(query.photo, scale=1.0), cmap="gray", vmin=0, vmax=1)
    row[1].imshow(to_display(result.people[query.person].photographs[0], scale=1.0), cmap="gray", vmin=0, vmax=1)
    for column, name in ((2, right), (4, wrong)):
        explained = gallery.reconstruct(name, query.photo)
        residual = query.photo - explained
        row[column].imshow(to_display(np.clip(explained, 0, None), scale=1.0), cmap="gray", vmin=0, vmax=1)
        row[column].set_xlabel(f"distance {distances[name]:.3f}", fontsize=8, color=INK)
        row[column + 1].imshow(signed_colours(residual, np.ones(residual.shape, np.bool_), 0.15))


def white_ball(size: int) -> Surface:
    """Return a white ball in front of nothing."""
    across = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(across, -across)
    squared = 1 - x**2 - y**2
    normals = np.stack([x, y, np.sqrt(np.maximum(squared, 0))], axis=-1)
    return Surface(normals, np.ones((size, size)), squared > 0)


def _spread(queries: Sequence[Query], count: int) -> list[Query]:
    """Return a few queries spread over all."""
    places = np.linspace(0, len(queries) - 1, min(count, len(queries))).astype(int)
    return [queries[place] for place in places]


def _grid(rows: int, columns: int, inches: float) -> tuple[Figure, NDArray[np.object_]]:
    """Return axes for pictures, without ticks or frames."""
    figure = Figure(figsize=(columns * inches + 0.9, rows * (inches + 0.18) + 0.2), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.flat:
        axis.set_xticks([])
        axis.set_yticks([])
        axis.spines[:].set_visible(False)
    return figure, axes
