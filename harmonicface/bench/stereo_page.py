"""The page of photometric stereo: what went in, what came out, what could and could not be determined."""

from __future__ import annotations

import html
from collections.abc import Sequence

from harmonicface._validate import Floats
from harmonicface.bench.page import encoded, image, page
from harmonicface.bench.stereo_pictures import (
    PAPER,
    WORST,
    error_pictures,
    lights_picture,
    relit_strip,
    reprojections,
    singular_values_picture,
    white_of,
    window,
)
from harmonicface.bench.stereo_statement import LIGHTS, Circumstances, determined, headline, undetermined
from harmonicface.io.pictures import to_display
from harmonicface.stereo.in_blocks import Images
from harmonicface.stereo.result import StereoResult
from harmonicface.surfaces.pictures import contour_interval, surface_pictures
from harmonicface.surfaces.surface import Surface

PART = 420  # pixels of a picture in the page
MAPS = ("normals", "albedo", "depth")


def stereo_page(
    result: StereoResult,
    images: Images,
    names: Sequence[str],
    told: Circumstances,
    title: str,
    files: Sequence[str],
    seconds: float | None = None,
    relit: Floats | None = None,
) -> str:
    """Return the HTML page of a result.

    Parameters
    ----------
    result
        What photometric stereo found.
    images
        The photographs, (n, h, w) or (n, h, w, 3).
    names
        What each is called.
    told
        What the user said.
    title
        Plain text, such as the name of the folder.
    files
        Names of the files that are written beside the page.
    seconds
        How long it took, if that is to be told.
    relit
        What `relit_strip` gave, if it has been drawn already.

    Returns
    -------
    str
        The page; it needs no other file.
    """
    surface = result.surface
    shown, chosen, _ = reprojections(result, images)
    fields = {
        "headline": html.escape(headline(result, told)),
        "title": html.escape(title),
        "count": len(images),
        "width": surface.shape[1],
        "height": surface.shape[0],
        "pixels": f"{int(surface.mask.sum()):,}".replace(",", " "),
        "relit": image(
            encoded(relit_strip(surface) if relit is None else relit),
            "the surface under other lights and from other sides",
        ),
        "determined": _items(determined(result, told)),
        "undetermined": _items(undetermined(result, told, names)),
        "parts": _maps(surface),
        "reprojections": image(encoded(shown), "photographs, their model and the difference"),
        "shown": html.escape(", ".join(names[index] for index in chosen)),
        "errors": _errors(result),
        "singular": image(singular_values_picture(result), "singular values"),
        "model": html.escape(f"{len_of(result)} for {LIGHTS[result.model]}"),
        "rank": result.rank,
        "gap": f"{result.gap:.3g}",
        "condition": f"{result.condition:.3g}",
        "lights": image(lights_picture(result, names), "the lights"),
        "lights_about": _about_lights(result),
        "files": html.escape(", ".join(files)),
        "seconds": "" if seconds is None else f"It took {seconds:.1f} s.",
    }
    return page("stereo.html.template", f"photometric stereo: {title}", fields)


def map_pictures(surface: Surface) -> dict[str, Floats]:
    """Return pictures of normals, albedo and depth; the albedo's white is its 99th percentile."""
    pictures = surface_pictures(surface)
    albedo = to_display(surface.albedo, white_of(surface))
    return {name: albedo if name == "albedo" else pictures[name] for name in MAPS if name in pictures}


def len_of(result: StereoResult) -> int:
    """Return how many singular values the model has."""
    return {"linear3": 3, "ambient4": 4, "harmonic9": 9}[result.model]


def _maps(surface: Surface) -> str:
    interval = contour_interval(surface)
    captions = {
        "normals": "Normals: red to the right, green up, blue toward the camera",
        "albedo": "Albedo",
        "depth": "Depth: yellow near, blue far" + ("" if interval is None else f"; a contour every {interval:.3g}"),
    }
    return _figures({captions[name]: picture for name, picture in map_pictures(surface).items()}, surface)


def _errors(result: StereoResult) -> str:
    pictures = error_pictures(result)
    captions = {
        "residual": "Residual over the photographs that were used: dark is large",
        "confidence": f"Standard error of the normals: light 0°, black {WORST:.0f}° or unknown",
    }
    return _figures({captions[name]: picture for name, picture in pictures.items()}, result.surface)


def _figures(pictures: dict[str, Floats], surface: Surface) -> str:
    """Lay pictures out beside one another, on paper where there is no surface."""
    figures = []
    for caption, picture in pictures.items():
        shown = picture.copy()
        shown[~surface.mask] = PAPER
        shown = shown[window(surface.mask)]
        figures.append(
            f"<figure>{image(encoded(shown, PART), caption)}<figcaption>{html.escape(caption)}</figcaption></figure>"
        )
    return f'<div class="row">{"".join(figures)}</div>'


def _about_lights(result: StereoResult) -> str:
    if result.lights.shape[1] == 3:
        return (
            "<p>Directions to the lamps as the thing sees them, by the number of the photograph: in the middle beside"
            " the camera, further out to the side; larger is brighter.</p>"
        )
    return "<p>A white ball under the light of each photograph.</p>"


def _items(sentences: Sequence[str]) -> str:
    return "".join(f"<li>{html.escape(text)}</li>" for text in sentences)
