"""A table of pictures: a ball and a Surface under a few lights, exact and by harmonics."""

from __future__ import annotations

import html
from collections.abc import Callable

import numpy as np

from harmonicface._validate import Floats
from harmonicface.appearance.render import render
from harmonicface.bench.page import encoded, image
from harmonicface.bench.pictures import white_ball
from harmonicface.io.colour import luminance
from harmonicface.io.pictures import signed_colours, to_display
from harmonicface.lighting import lights
from harmonicface.lighting.light import Light
from harmonicface.surfaces.surface import Surface

FULL = 0.25  # of white: the error that is shown in full colour
MOST = 240  # pixels a side of a picture


def usual_lights() -> dict[str, Light]:
    """Return the lights of the table by what they are called there."""
    return {
        "lamp in front": lights.directional([0, 0, 1]),
        "lamp 60° to the side": lights.from_angles(60, 15),
        "Grace Cathedral, nine published coefficients": lights.published("grace"),
        "natural light": lights.natural(0),
    }


def light_table(
    surface: Surface, order: int, shadows: bool, bounces: int, tell: Callable[[str], None] = lambda _: None
) -> str:
    """Return the HTML table: a row a light, exact picture, harmonic pictures of order 2 and of the order, errors.

    Parameters
    ----------
    surface
        What is lit.
    order
        Highest degree of the last columns; at 2 they are left out.
    shadows, bounces
        See `render`.
    tell
        Is told which light is next.
    """
    orders = sorted({2, order})
    heads = ["", "ball", "exact", *(head for number in orders for head in (f"order {number}", "error"))]
    rows = []
    for name, light in usual_lights().items():
        tell(f"pictures under {name}")
        rows.append(_row(surface, name, light, orders, shadows, bounces))
    head = "".join(f"<th>{text}</th>" for text in heads)
    return f'<table class="pictures"><tr>{head}</tr>{"".join(rows)}</table>'


def _row(surface: Surface, name: str, light: Light, orders: list[int], shadows: bool, bounces: int) -> str:
    ball = render(white_ball(96), light)
    exact = render(surface, light, shadows=shadows, bounces=bounces)
    white = _white(exact)
    cells = [_cell(to_display(ball, _white(ball)), f"ball: {name}"), _cell(to_display(exact, white), f"exact: {name}")]
    for order in orders:
        found = render(surface, light, order=order, shadows=shadows, bounces=bounces)
        error = found - exact
        percent = 100 * float(np.linalg.norm(error) / (np.linalg.norm(exact) or 1.0))
        cells.append(_cell(to_display(np.clip(found, 0, None), white), f"order {order}: {name}"))
        colours = signed_colours(_grey(error), surface.mask, FULL * white)
        cells.append(_cell(colours, f"error at order {order}: {name}", f"{percent:.1f} %"))
    return f"<tr><th>{html.escape(name)}</th>{''.join(cells)}</tr>"


def _cell(picture: Floats, description: str, caption: str = "") -> str:
    return f"<td>{image(encoded(picture, MOST), description)}{caption}</td>"


def _white(picture: Floats) -> float:
    """Return what is shown as white: the brightest hundredth of what is lit."""
    lit = picture[picture > 0]
    return float(np.quantile(lit, 0.99)) if lit.size else 1.0


def _grey(picture: Floats) -> Floats:
    return picture if picture.ndim == 2 else luminance(picture)
