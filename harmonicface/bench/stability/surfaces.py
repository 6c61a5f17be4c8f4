"""Rows of the stability table: surfaces from depth and meshes, their pictures, horizons and shadows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.render import render
from harmonicface.bench.stability import exact_harmonics
from harmonicface.bench.stability.hard_surfaces import ball, bumpy_mesh, nine_images
from harmonicface.bench.stability.row import Answers, Measured, rounded
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.horizon import horizons
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport

Row: TypeAlias = tuple[tuple[str, str], Callable[[], Measured]]

SIDE = 24
ALBEDO = 0.7
LIGHT = np.array([0.6, 0.0, 0.8])


def of_surfaces() -> Answers:
    """Return a function for each row; errors are of a closed form, of meshes of the same without the difficulty."""
    cases = (_wall, _few_pixels, _black, _grazing, _spike, _steps_and_holes, _units, _bright_lamp, _single)
    rows: Answers = {}
    for case in cases:
        rows.update(case())
    return rows


def _row(
    name: str,
    made: Callable[[], Any],
    expected: Any,
    note: str,
    dtype: DTypeLike = np.float64,
    condition: float = 1.0,
) -> Row:
    """Return one row by its case and solver."""
    case, solver = name.rsplit(": ", 1)
    return (solver, case), lambda: rounded(made(), expected, condition, dtype, note)


def _transport(surface: Surface) -> Floats:
    return transport(surface, 2).values


def _flat(shape: tuple[int, int] = (SIDE, SIDE), mask: NDArray[np.bool_] | None = None) -> Surface:
    normals = np.tile([0.0, 0.0, 1.0], (*shape, 1))
    return Surface(normals, np.full(shape, ALBEDO), mask, np.zeros(shape))


def _wall() -> Iterator[Row]:
    wall = _flat()
    name = "all normals equal (a wall)"
    expected = nine_images(wall.pixel_normals, ALBEDO)
    yield _row(f"{name}: harmonic images", lambda: harmonic_images(wall), expected, "nine multiples of one")
    note = "nothing stands above the wall: the closed form without shadows"
    yield _row(f"{name}: transport", partial(_transport, wall), expected / ALBEDO, note)
    lit = np.full(wall.shape, ALBEDO * LIGHT[2])
    yield _row(f"{name}: render", lambda: render(wall, LIGHT, shadows=True), lit, "albedo times the cosine")


def _few_pixels() -> Iterator[Row]:
    for count in (9, 1):
        name = f"a mask of 9 pixels or fewer ({count})"
        mask = np.zeros((5, 5), dtype=bool)
        mask[1:4, 1:4] = True
        if count == 1:
            mask[:] = False
            mask[2, 2] = True
        normals = ball(5)[0]
        small = Surface(normals, np.full((5, 5), ALBEDO), mask)
        expected = nine_images(small.pixel_normals, ALBEDO)
        note = "fewer pixels than images: computed all the same, a basis of them has at most as many rows"
        yield _row(f"{name}: harmonic images", partial(harmonic_images, small), expected, note)
        flat = _flat((5, 5), mask)
        expected = nine_images(flat.pixel_normals)
        note = "outside the mask nothing blocks"
        yield _row(f"{name}: transport", partial(_transport, flat), expected, note)


def _black() -> Iterator[Row]:
    normals, inside = ball(SIDE)
    albedo = np.full(inside.shape, ALBEDO)
    albedo[::2] = 0
    surface = Surface(normals, albedo, inside)
    expected = nine_images(surface.pixel_normals, surface.pixel_albedo)
    note = "exactly 0 where the albedo is, nothing is divided by it"
    name = "albedo zero in places: harmonic images"
    yield _row(name, lambda: harmonic_images(surface), expected, note)


def _grazing() -> Iterator[Row]:
    heights = np.repeat([0.0, 1e-12, 1e-6, 1e-3], SIDE)
    around = np.linspace(0, 2 * np.pi, len(heights), endpoint=False)
    flat = np.sqrt(1 - heights**2)
    normals = np.stack([flat * np.cos(around), flat * np.sin(around), heights], axis=1)[None]
    surface = Surface(normals, np.full(normals.shape[:2], ALBEDO))
    name = "grazing normals (z from 0 to 1e-3)"
    expected = nine_images(normals[0], ALBEDO)
    yield _row(f"{name}: harmonic images", lambda: harmonic_images(surface), expected, "as any other normal")
    along = np.array([0.0, 0.0, 1.0])
    note = "light along the line of sight: the cosine is z; error over the largest"
    yield _row(f"{name}: render", lambda: render(surface, along), ALBEDO * heights[None], note)
    steep = np.tile(1e4 * np.arange(float(SIDE)), (SIDE, 1))
    expected_normal = np.array([-1e4, 0, 1]) / np.hypot(1e4, 1)
    note = "a slope of 10000 a pixel; expected: the plane's normal"
    yield _row(
        "grazing depth: normals",
        lambda: surface_from_depth(steep).normals,
        np.broadcast_to(expected_normal, (SIDE, SIDE, 3)),
        note,
    )


def _spike() -> Iterator[Row]:
    height = 50.0
    depth = np.zeros((SIDE, SIDE + 1))
    row, column = SIDE // 2, SIDE // 2
    depth[row, column] = height
    beside = np.arange(1, column + 1)
    expected = np.arctan2(height, beside)

    def toward() -> Floats:
        found = horizons(depth, None, 1.0, [0.0])[0].reshape(depth.shape)
        return np.asarray(found[row, column - beside])

    note = "kept; it hides the sky up to arctan(height / distance), exact at whole pixels"
    yield _row("a spike one pixel wide: horizon", toward, expected, note)
    flat = np.broadcast_to([0.0, 0.0, 1.0], (SIDE, SIDE + 1, 3)).copy()
    flat[row, column] = 0
    note = "with steepest=80 it is left outside and its neighbours' normals stay those of the wall"
    yield _row(
        "a spike one pixel wide: normals",
        lambda: surface_from_depth(depth, steepest=80).normals,
        flat,
        note,
    )


def _steps_and_holes() -> Iterator[Row]:
    columns = np.tile(np.arange(float(SIDE)), (SIDE, 1))
    upper = columns >= SIDE // 2
    depth = np.where(upper, 10 + 0.5 * columns, -0.2 * columns)
    holes = np.random.default_rng(0).random(depth.shape) < 0.05
    depth[holes] = np.nan
    surface = surface_from_depth(depth, steepest=80)
    slopes = np.where(upper, 0.5, -0.2)
    exact = np.stack([-slopes, np.zeros_like(slopes), np.ones_like(slopes)], axis=2)
    exact /= np.linalg.norm(exact, axis=2, keepdims=True)
    exact[~surface.mask] = 0
    share = surface.mask.sum() / (~holes).sum()
    note = (
        f"one-sided at steps and holes; {share:.1%} of the measured pixels have a normal, the others are left outside"
    )
    yield _row(
        "depth with steps and holes: normals",
        lambda: surface_from_depth(depth, steepest=80).normals,
        exact,
        note,
    )
    step = np.where(upper[:1], 10.0, 0.0)
    distance = SIDE // 2 - np.arange(SIDE // 2)
    note = "the step hides the sky up to arctan(height / distance)"
    yield _row(
        "depth with steps: horizon",
        lambda: horizons(step, None, 1.0, [0.0])[0][: SIDE // 2],
        np.arctan2(10.0, distance),
        note,
    )


def _units() -> Iterator[Row]:
    mesh = bumpy_mesh()
    seen = surface_from_mesh(mesh, 32)
    expected = {shadows: harmonic_images(seen, 2, shadows=shadows) for shadows in (False, True)}
    for factor, shift in ((1e-3, 0.0), (1e3, 0.0), (1.0, 1e6)):
        other = replace(mesh, vertices=factor * mesh.vertices + shift)
        surface = surface_from_mesh(other, 32)
        same = bool((surface.mask == seen.mask).all())
        what = f"a mesh times {factor:g}" if shift == 0 else f"a mesh {shift:g} away from the origin"
        for shadows, right in expected.items():
            note = f"the same {surface.mask.sum()} pixels: {same}; expected: the mesh as it was"
            name = f"{what}: harmonic images" + " with shadows" * shadows
            made = partial(harmonic_images, surface, 2, shadows=shadows)
            # the mesh is float32; what its units or its place add to the roundings is the ratio of place to size
            yield _row(name, made, right, note, np.float32)


def _bright_lamp() -> Iterator[Row]:
    height, width = 32, 64
    radiance = np.ones((height, width))
    radiance[8, 40] = 1e6
    polar = np.linspace(0, np.pi, height + 1)
    up = (np.arange(height) + 0.5) * np.pi / height
    around = (np.arange(width) + 0.5) * 2 * np.pi / width - np.pi  # 0 in the middle column, which is -z
    areas = (np.cos(polar[:-1]) - np.cos(polar[1:])) * 2 * np.pi / width
    directions = np.stack(
        [
            np.outer(np.sin(up), np.sin(around)),
            np.outer(np.cos(up), np.ones(width)),
            -np.outer(np.sin(up), np.cos(around)),
        ],
        axis=2,
    ).reshape(-1, 3)
    weights = (radiance * areas[:, None]).ravel()
    normals, inside = ball(SIDE)
    surface = Surface(normals, np.full(inside.shape, ALBEDO), inside)
    expected = np.zeros(inside.shape)
    expected[inside] = ALBEDO * (np.maximum(surface.pixel_normals @ directions.T, 0) @ weights)
    low = float(render(surface, EnvironmentMap(radiance), order=2)[inside].min() / expected.max())
    for dtype in (np.float64, np.float32):
        light = EnvironmentMap(radiance.astype(dtype))
        note = (
            f"exact sum; expected: by every lamp in float64. By order 2 the darkest pixel is {low:.3f} of the largest"
        )
        name = f"1e6 : 1 dynamic range, {np.dtype(dtype).name}: render"
        yield _row(name, partial(render, surface, light), expected, note, dtype)


def _single() -> Iterator[Row]:
    normals, inside = ball(SIDE)
    heights = np.where(inside, SIDE / 2 * normals[..., 2], np.nan)
    single = Surface(
        normals.astype(np.float32), np.full(inside.shape, ALBEDO, np.float32), inside, heights.astype(np.float32)
    )
    seen = single.pixel_normals.astype(np.float64)
    name, note = "float32 against float64", "expected: the closed form in float64"
    yield _row(f"{name}: harmonic images", lambda: harmonic_images(single), nine_images(seen, ALBEDO), note, np.float32)
    lit = np.zeros(inside.shape)
    lit[inside] = ALBEDO * np.maximum(seen @ LIGHT, 0)
    yield _row(f"{name}: render", lambda: render(single, LIGHT), lit, f"one direction; {note}", np.float32)
    convex = exact_harmonics.harmonic_pictures(seen, 1.0, 4)
    note = "order 4, from the depth of a ball, on which no shadow falls; expected: the closed form without shadows"
    yield _row(f"{name}: transport", lambda: transport(single, 4).values, convex, note, np.float32)
