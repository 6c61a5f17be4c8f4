"""Operations on the pixels of a Surface: cut a part out, show it at another size, keep every n-th pixel."""

from __future__ import annotations

import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces._resampling import MaskedMean, spread
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.seen_again import see_again
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transport import Transport
from harmonicface.surfaces.view import checked_shape
from harmonicface.surfaces.windows import Window, through

Span = slice | tuple[int, int]


def crop(surface: Surface, rows: Span, columns: Span) -> Surface:
    """Return a part of a Surface; every number in it stays what it was.

    The scene's camera and the transports follow, so shadows that fall into the part from outside remain. A Surface
    with depth alone and no transport yet loses what stands outside: compute its `transport` first to keep the shadows.

    Parameters
    ----------
    surface
        What is cut.
    rows, columns
        Which pixels stay: (first, beyond), or a slice of step 1, so that numpy's `np.s_[8:56, 4:60]` gives both.
        Negative numbers count from the end.

    Raises
    ------
    HarmonicFaceError
        Pixels that are not there, none at all, another step, or a part outside the mask.

    Examples
    --------
    >>> wall = Surface(np.tile([0.0, 0.0, 1.0], (4, 6, 1)), np.ones((4, 6)))
    >>> crop(wall, (1, 4), (2, 6)).shape, crop(wall, *np.s_[1:, :-4]).shape
    ((3, 4), (3, 2))
    """
    (top, bottom), (left, right) = (
        _checked_span(span, count, name)
        for span, count, name in zip((rows, columns), surface.shape, ("rows", "columns"), strict=True)
    )
    return _picked(
        surface, slice(top, bottom), slice(left, right), Window(top, left, 1.0, (bottom - top, right - left))
    )


def decimate(surface: Surface, every: int) -> Surface:
    """Return a Surface of every n-th pixel of every n-th row, from the first: what `[::n, ::n]` does to a picture.

    Nothing is averaged, so fine detail turns into noise; `resize` averages. The camera of the scene follows, with
    pixels n times as large around the same centres, and so do the transports.

    Parameters
    ----------
    surface
        What is thinned out.
    every
        n, at least 1.

    Raises
    ------
    HarmonicFaceError
        n below 1, or no pixel that is left lies in the mask.

    Examples
    --------
    >>> wall = Surface(np.tile([0.0, 0.0, 1.0], (4, 5, 1)), np.ones((4, 5)), pixel_size=0.5)
    >>> decimate(wall, 2).shape, decimate(wall, 2).pixel_size
    ((2, 3), 1.0)
    """
    n = _validate.at_least(every, 1, "every")
    height, width = (-(-side // n) for side in surface.shape)
    return _picked(
        surface, slice(None, None, n), slice(None, None, n), Window((1 - n) / 2, (1 - n) / 2, n, (height, width))
    )


def resize(surface: Surface, size: int | tuple[int, int]) -> Surface:
    r"""Return a Surface at another size.

    Pixels stay square, so where the proportions differ the picture shows more, centred on what it was, as the frame of
    a mesh does. A Surface with a scene is seen again from its mesh, and its transports are left to be computed again.
    Otherwise larger pixels hold the means of what lies in them and in the mask, smaller ones the lines between pixel
    centres; a pixel is inside where the mask covers at least half of it. Normals are means scaled to unit length.
    Transports are means weighted by albedo, so that albedo times transport, the harmonic images with shadows, are
    exactly the means of what they were.

    Normals and depth stay consistent: the slope of the mean depth is the mean of the slopes, and from that the mean
    normal differs in second order of how much the normals vary within a pixel.

    Parameters
    ----------
    surface
        What is resized.
    size
        Height and width in pixels; one number means a square.

    Returns
    -------
    Surface
        Of the same types; its pixel size has grown by max(old height / new height, old width / new width).

    Raises
    ------
    HarmonicFaceError
        A size that is none, or no pixel of which the mask covers half.

    Examples
    --------
    >>> ridge = np.array([[[-0.6, 0.0, 0.8], [0.6, 0.0, 0.8]]])
    >>> mean = resize(Surface(ridge, np.array([[0.2, 0.4]])), (1, 1))
    >>> mean.normals, mean.albedo.round(6), mean.pixel_size
    (array([[[0., 0., 1.]]]), array([[0.3]]), 2.0)
    """
    window = Window.over(surface.shape, checked_shape(size))
    if surface.scene is not None:
        return see_again(surface.scene.mesh, through(surface.scene.view, window))
    mean = MaskedMean(surface.mask, window)
    normals = mean(surface.pixel_normals)
    length = np.linalg.norm(normals, axis=1)
    directed = length > 1e-6  # opposite normals leave no direction
    inside = mean.inside.copy()
    inside[mean.inside] = directed
    if not inside.any():
        raise HarmonicFaceError(f"size: expected pixels that the mask covers half, got none at {window.shape}")
    depth = None if surface.depth is None else mean(surface.depth[surface.mask])[directed]
    return Surface(
        spread(normals[directed] / length[directed, None], inside, surface.normals.dtype),
        spread(mean(surface.pixel_albedo)[directed], inside, surface.albedo.dtype),
        inside,
        None if depth is None or surface.depth is None else spread(depth, inside, surface.depth.dtype),
        surface.pixel_size * window.step,
        transports=[
            Transport(_mean_transport(mean, known.values, surface)[:, directed], known.bounces)
            for known in surface.transports.values()
        ],
    )


def _mean_transport(mean: MaskedMean, values: Floats, surface: Surface) -> Floats:
    """Return means of (k, p) or (k, p, 3) rows, weighted by the albedo that they are multiplied by."""
    weights = surface.grey_albedo
    if values.ndim == 3:
        weights = np.broadcast_to(surface.pixel_albedo.reshape(values.shape[1], -1), values.shape[1:])
    rows = [mean.weighted(row, weights) for row in values]
    return np.stack(rows).astype(values.dtype, copy=False)


def _picked(surface: Surface, rows: slice, columns: slice, window: Window) -> Surface:
    """Return the Surface of some rows and columns, which a window shows."""
    inside = surface.mask[rows, columns]
    if not inside.any():
        raise HarmonicFaceError(
            f"surface: expected a part of the mask among the pixels that stay, got none of {surface.mask.sum()} pixels"
        )
    number = np.zeros(surface.shape, dtype=np.int64)
    number[surface.mask] = np.arange(surface.mask.sum())
    pixels = number[rows, columns][inside]
    scene = surface.scene
    return Surface(
        surface.normals[rows, columns],
        surface.albedo[rows, columns],
        inside,
        None if surface.depth is None else surface.depth[rows, columns],
        surface.pixel_size * window.step,
        scene=None if scene is None else Scene(scene.mesh, through(scene.view, window)),
        transports=[Transport(known.values[:, pixels], known.bounces) for known in surface.transports.values()],
    )


def _checked_span(span: Span, count: int, name: str) -> tuple[int, int]:
    """Return first and beyond, from 0 to count."""
    expected = f"{name}: expected (first, beyond) or a slice of step 1 within {count} pixels"
    parts = (span.start, span.stop) if isinstance(span, slice) and span.step in (None, 1) else span
    if not isinstance(parts, tuple) or len(parts) != 2:
        raise HarmonicFaceError(f"{expected}, got {_validate.describe(span)}")
    numbers = tuple(
        usual if part is None and isinstance(span, slice) else part
        for part, usual in zip(parts, (0, count), strict=True)
    )
    if any(isinstance(part, bool) or not isinstance(part, (int, np.integer)) for part in numbers):
        raise HarmonicFaceError(f"{expected}, got {_validate.describe(span)}")
    first, beyond = (int(part) + count if part < 0 else int(part) for part in numbers)
    if not 0 <= first < beyond <= count:
        raise HarmonicFaceError(f"{expected}, got {_validate.describe(span)}")
    return first, beyond
