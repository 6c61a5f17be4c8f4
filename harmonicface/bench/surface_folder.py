"""A folder of pictures of a Surface, with a page that shows them."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from pathlib import Path

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.bench.surface_page import FILES, sky_picture, surface_page
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count
from harmonicface.io.files import replacing
from harmonicface.io.images import write_image
from harmonicface.io.normal_maps import write_normal_map
from harmonicface.surfaces.pictures import harmonic_pictures, surface_pictures
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import HIGHEST_ORDER

PAGE = "surface.html"
SURFACE = "surface.npz"
WRITTEN = re.compile(r"(harmonic_\d+_l\d+_m[+-]\d+|normals|albedo|depth|mask|ambient_occlusion)\.png")


def write_surface_folder(
    surface: Surface,
    folder: str | os.PathLike[str],
    title: str,
    order: int = 2,
    shadows: bool = False,
    bounces: int = 0,
    tell: Callable[[str], None] = lambda _: None,
) -> int:
    """Write harmonic images and other pictures of a Surface, the Surface itself, and a page that shows them all.

    The pictures are `harmonic_04_l2_m-2.png` and so on, one colour scale for all; `normals.png`, a normal map that
    can be read again; `albedo.png`, `depth.png`, `mask.png`, and with shadows `ambient_occlusion.png`. `surface.npz`
    keeps the transport that was computed. What an earlier call wrote there and this one does not, it removes, by the
    list in the earlier page; nothing else in the folder is touched.

    Parameters
    ----------
    surface
        What is shown.
    folder
        Where; it is made if it is not there.
    title
        What the page calls it.
    order
        The highest degree, 0 to 12.
    shadows, bounces
        See `harmonic_images`.
    tell
        Is told what is being done.

    Returns
    -------
    int
        How many harmonic images there are.

    Raises
    ------
    HarmonicFaceError
        What `harmonic_images` refuses; a folder that cannot be made or written to.
    """
    checked_order(order)
    tell("harmonic images")
    images = harmonic_images(surface, order, shadows, bounces)
    pictures = _pictures(surface, images, shadows or bounces > 0)
    text = surface_page(
        surface, title, images, shadows, bounces, [*pictures, SURFACE], tell
    )  # before anything is written
    tell("writing")
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot make the folder {target}: {error.strerror}") from None
    earlier = _listed(target / PAGE)
    for name, picture in pictures.items():
        if name == "normals.png":
            write_normal_map(target / name, surface.normals)  # in 16 bits
        else:
            write_image(target / name, picture, transfer="linear")
    surface.save(target / SURFACE)
    for name in earlier - set(pictures):
        _remove(target / name)
    with replacing(target / PAGE) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return len(images)


def checked_order(order: int) -> None:
    """Refuse more pictures than anybody looks at.

    Raises
    ------
    HarmonicFaceError
        An order that is not 0 to 12.
    """
    count(order)
    if order > HIGHEST_ORDER:
        most = count(HIGHEST_ORDER)
        raise HarmonicFaceError(f"order: expected at most {HIGHEST_ORDER}, which are {most} pictures, got {order}")


def _pictures(surface: Surface, images: Floats, shadows: bool) -> dict[str, Floats]:
    """Return the pictures by file name."""
    digits = max(2, len(str(len(images) - 1)))
    found = {}
    for index, picture in enumerate(harmonic_pictures(surface, images)):
        degree = math.isqrt(index)
        found[f"harmonic_{index:0{digits}d}_l{degree}_m{index - degree * (degree + 1):+d}.png"] = picture
    found |= {f"{name}.png": picture for name, picture in surface_pictures(surface).items()}
    if shadows:
        found["ambient_occlusion.png"] = sky_picture(surface)
    return found


def _listed(page: Path) -> set[str]:
    """Return the pictures that an earlier page lists; none if there is no such page."""
    try:
        text = page.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return set()
    match = re.search(f'<meta name="{FILES}" content="([^"]*)">', text)
    return {name for name in (match[1].split() if match else ()) if WRITTEN.fullmatch(name)}


def _remove(file: Path) -> None:
    """Remove a file that may be gone already."""
    try:
        file.unlink(missing_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot remove {file}: {error.strerror}") from None
