"""A folder with photographs of a chrome ball, one for each lamp: the lamps' directions."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.datasets.photographs import images_in
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image
from harmonicface.io.pixels import ENDINGS
from harmonicface.stereo.known.mirror_ball import mirror_ball_lights

HALF = 0.5


def load_chrome_ball(
    folder: str | os.PathLike[str] | Sequence[Path],
    circle: Sequence[float] | None = None,
    transfer: str | None = None,
) -> NDArray[np.float64]:
    """Return the direction to the lamp of each photograph of a chrome ball (see `mirror_ball_lights`).

    Parameters
    ----------
    folder
        Photographs of the ball in the order of the numbers in their names, or a list of them; and unless there is a
        circle a picture whose name has "mask" in it, white on the ball.
    circle
        (x, y, radius) of the ball in pixels, from the upper left corner.
    transfer
        What the photographs' numbers mean, see `read_image`.

    Returns
    -------
    array
        (n, 3) unit vectors *to* the lamps, x right, y up, z toward the camera.

    Raises
    ------
    HarmonicFaceError
        No such folder, no photographs, neither mask nor circle, photographs of unlike sizes, what `mirror_ball_lights`
        refuses.
    """
    files = images_in(Path(folder)) if isinstance(folder, (str, os.PathLike)) else list(folder)
    mask = None
    if circle is None:
        mask = mask_in(Path(folder)) if isinstance(folder, (str, os.PathLike)) else None
        if mask is None:
            raise HarmonicFaceError(f"{folder}: expected a picture of the ball's mask, or a circle, got neither")
    ball = None if mask is None else read_image(mask, "linear")
    disc = None if ball is None else (ball if ball.ndim == 2 else ball.mean(axis=2)) > HALF
    directions = []
    for file in files:
        photo = read_image(file, transfer)
        grey = photo if photo.ndim == 2 else photo.mean(axis=2)
        try:
            directions.append(mirror_ball_lights(grey[None], circle, disc)[0])
        except HarmonicFaceError as error:
            raise HarmonicFaceError(f"{file.name}: {error}".replace(" in photograph 0", "")) from None
    return np.stack(directions)


def mask_in(folder: Path) -> Path | None:
    """Return the one picture of a folder that is called a mask; None if there is none, or more than one."""
    found = [file for file in folder.iterdir() if file.suffix.lower() in ENDINGS and "mask" in file.stem.lower()]
    return found[0] if len(found) == 1 else None
