"""The page of a Surface: what it is, what it is made of, its harmonic images, and how it looks under a few lights."""

from __future__ import annotations

import html
import math
from collections.abc import Callable

import numpy as np

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.bench.light_table import light_table
from harmonicface.bench.page import definitions, encoded, image, page
from harmonicface.harmonics.indexing import order_of
from harmonicface.io.pictures import signed_colours
from harmonicface.surfaces.pictures import common_scale, contour_interval, harmonic_pictures, surface_pictures
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport

FILES = "harmonicface-files"  # the name under which a page lists the files beside it
NAMES = ("1", "y", "z", "x", "xy", "yz", "3z²-1", "xz", "x²-y²")
GRAZING = 75.0  # degrees
WIDTH = 960  # pixels of the page
PART = 320  # pixels of a picture in the page


def surface_page(
    surface: Surface,
    title: str,
    images: Floats,
    shadows: bool,
    bounces: int,
    files: list[str],
    tell: Callable[[str], None] = lambda _: None,
) -> str:
    """Return the HTML page of a Surface.

    Parameters
    ----------
    surface
        What is shown.
    title
        Plain text, such as the name of its file.
    images
        (k, p) its harmonic images, k = (order + 1)^2.
    shadows, bounces
        Whether cast shadows are in them, and how often light is thrown back.
    files
        Names of the files that were written beside the page.
    tell
        Is told what is being done.

    Returns
    -------
    str
        The page; it needs no other file.
    """
    order = order_of(len(images))
    shadows = shadows or bounces > 0
    fields = {
        "title": html.escape(title),
        "height": surface.shape[0],
        "width": surface.shape[1],
        "inside": f"{_thousands(int(surface.mask.sum()))} of them ({100 * surface.mask.mean():.0f} %)",
        "facts": definitions(facts(surface)),
        "parts": _parts(surface),
        "count": len(images),
        "about": _about(order, shadows, bounces),
        "triangle": _triangle(surface, images),
        "shadows": _shadows(surface, images, bounces) if shadows else "",
        "beyond": " past what casts shadows" if shadows else "",
        "lights": light_table(surface, order, shadows, bounces, tell),
        "files": html.escape(_summary(files)),
    }
    return page("surface.html.template", title, fields, {FILES: " ".join(files)})


def facts(surface: Surface) -> dict[str, str]:
    """Return what can be said of a Surface in numbers, as plain texts by name.

    Examples
    --------
    >>> facts(Surface(np.tile([0.0, 0.0, 1.0], (2, 4, 1)), np.full((2, 4), 0.5), pixel_size=0.25))
    {'pixel': '0.25 world units; the picture is 1 by 0.5', 'depth': 'none',
     'albedo': '0.5 to 0.5, mean 0.5, grey', 'normals': '0.0 % graze: more than 75° from the camera'}
    """
    height, width = surface.shape
    size = surface.pixel_size
    albedo = surface.grey_albedo
    colour = "grey" if surface.albedo.ndim == 2 else "colour (numbers are its luminance)"
    steep = np.mean(surface.pixel_normals[:, 2] < math.cos(math.radians(GRAZING)))
    found = {
        "pixel": f"{size:.4g} world units; the picture is {width * size:.4g} by {height * size:.4g}",
        "depth": "none",
        "albedo": f"{albedo.min():.3g} to {albedo.max():.3g}, mean {albedo.mean():.3g}, {colour}",
        "normals": f"{100 * steep:.1f} % graze: more than {GRAZING:.0f}° from the camera",
    }
    if surface.depth is not None:
        depth = surface.depth[surface.mask].astype(np.float64)
        found["depth"] = f"{depth.min():.4g} to {depth.max():.4g} world units, {np.ptp(depth):.4g} from back to front"
    if surface.scene is not None:
        mesh = surface.scene.mesh
        found["mesh"] = f"{_thousands(len(mesh.vertices))} vertices, {_thousands(len(mesh.faces))} triangles"
    return found


def _about(order: int, shadows: bool, bounces: int) -> str:
    """Say what the images are and what is in them."""
    text = "Any matte picture of it is close to a combination of these: red adds light, blue takes it away."
    if shadows:
        text += " Cast shadows are in them"
        text += f", and light that is thrown back {_times(bounces)}." if bounces else "."
    else:
        text += " Attached shadows are in them, cast shadows are not."
        text += " Odd degrees above 1 are zero: the cosine has none." if order > 2 else ""
    return text


def _parts(surface: Surface) -> str:
    """Show normals, albedo, depth and mask beside one another."""
    interval = contour_interval(surface)
    captions = {
        "normals": "Normals: red to the right, green up, blue toward the camera",
        "albedo": "Albedo",
        "depth": "Depth: yellow near, blue far" + ("" if interval is None else f"; a contour every {interval:.3g}"),
        "mask": "Mask",
    }
    figures = (
        f"<figure>{image(encoded(picture, PART), name)}<figcaption>{captions[name]}</figcaption></figure>"
        for name, picture in surface_pictures(surface).items()
    )
    return f'<div class="row">{"".join(figures)}</div>'


def _legend(scale: float) -> str:
    """Show the colours from minus to plus the scale."""
    ramp = signed_colours(np.linspace(-1, 1, 256)[None], np.ones((1, 256), bool), 1.0)
    return f'<div class="legend">{-scale:.3g} {image(encoded(ramp), "colours")} {scale:+.3g}</div>'


def _triangle(surface: Surface, images: Floats) -> str:
    """Show images with a row for each degree and a column for each m, zero in the middle, and their common scale."""
    order = order_of(len(images))
    scale = common_scale(images)
    most = min(PART, 2 * WIDTH // (2 * order + 1))
    pictures = harmonic_pictures(surface, images, scale)
    rows = []
    for degree in range(order + 1):
        first, beyond = degree**2, (degree + 1) ** 2
        cells = ["<td></td>"] * (order - degree)
        for index in range(first, beyond):
            mode = f"m = {index - degree * (degree + 1)}"
            shown = image(encoded(pictures[index], most), f"l = {degree}, {mode}")
            cells.append(f"<td>{shown}{mode}{' · ' + NAMES[index] if index < len(NAMES) else ''}</td>")
        cells += ["<td></td>"] * (order - degree)
        reach = common_scale(images[first:beyond]) if images[first:beyond].any() else 0.0
        rows.append(f"<tr><th>l = {degree}<br>up to {reach:.2g}</th>{''.join(cells)}</tr>")
    return f'{_legend(scale)}<table class="pictures">{"".join(rows)}</table>'


def _shadows(surface: Surface, images: Floats, bounces: int) -> str:
    """Show how much sky each pixel sees, and what cast shadows change in the images."""
    change = images - harmonic_images(surface, order_of(len(images)))
    share = np.linalg.norm(change) / np.linalg.norm(images) if images.any() else 0.0
    seen = sky_share(surface)
    picture = encoded(sky_picture(surface), PART)
    back = " and light that is thrown back" if bounces else ""
    return (
        f"<h2>What cast shadows{back} change</h2>"
        f"<p>A pixel sees {100 * seen.mean():.0f} % of the sky that it faces"
        f" ({100 * seen.min():.0f} to {100 * seen.max():.0f} %), each direction by its cosine: ambient occlusion.</p>"
        f'<div class="row"><figure>{image(picture, "ambient occlusion")}'
        "<figcaption>Ambient occlusion: white sees all of its sky</figcaption></figure></div>"
        f"<p>The images with cast shadows{back} minus those without: {100 * share:.1f} % of the former (root mean"
        f" square). Red gains, blue loses; this scale is their own.</p>{_triangle(surface, change)}"
    )


def sky_share(surface: Surface) -> Floats:
    """Return the share of the sky above each masked pixel that nothing hides, by the cosine, (p,): T_00 / (pi Y_00)."""
    values = transport(surface, 0).values[0]
    return np.asarray(np.clip(values / (math.pi * math.sqrt(1 / (4 * math.pi))), 0, 1))


def sky_picture(surface: Surface) -> Floats:
    """Return the ambient occlusion of a Surface as display values, (h, w): 1 sees all of its sky, outside is 0."""
    picture = np.zeros(surface.shape, surface.normals.dtype)
    picture[surface.mask] = sky_share(surface)
    return picture


def _summary(files: list[str]) -> str:
    """Name the files, of the harmonic images the first and the last."""
    harmonic = [name for name in files if name.startswith("harmonic_")]
    return ", ".join([f"{harmonic[0]} to {harmonic[-1]}", *(name for name in files if name not in harmonic)])


def _times(number: int) -> str:
    return {1: "once", 2: "twice"}.get(number, f"{number} times")


def _thousands(number: int) -> str:
    return f"{number:,}".replace(",", " ")
