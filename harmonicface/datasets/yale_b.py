"""Extended Yale Face Database B, cropped: one person's face under 64 known lights, from the user's disk."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image

IMAGE_SHAPE = (192, 168)  # height and width of the cropped version
SUBSET_BOUNDS = (12.0, 25.0, 51.5, 77.0)  # degrees; subset 5 lies beyond
SLACK = 1e-6  # degrees: arccos(cos 25) is a little more than 25 in floats
FOLDER = re.compile(r"yaleB(\d{2})")
PHOTOGRAPH = re.compile(r"yaleB(?P<person>\d{2})_P00A(?P<azimuth>[+-]\d{3})E(?P<elevation>[+-]\d{2})")
AMBIENT = "_Ambient"


@dataclass(frozen=True, eq=False)
class YalePerson:
    """The photographs of one person, in the order of their file names.

    Parameters
    ----------
    number
        As in the name of the folder, `yaleB01` is 1.
    photographs
        (n, 192, 168) float32, linear, 0 to 1. n is 64, less the photographs that are missing.
    lights
        (n, 3) unit directions from the face to the light: x right, y up, z toward the camera.
    angles
        (n,) degrees between the light and the camera's axis.
    subsets
        (n,) the published subset of each photograph, 1 to 5 (see `subset_of`).
    files
        The n files.
    """

    number: int
    photographs: NDArray[np.float32]
    lights: NDArray[np.float64]
    angles: NDArray[np.float64]
    subsets: NDArray[np.int64]
    files: tuple[Path, ...]


def load_yale_b(folder: str | os.PathLike[str], people: Iterable[int] | None = None) -> list[YalePerson]:
    """Read people of the cropped Extended Yale B (Georghiades et al. 2001; Lee, Ho & Kriegman 2005).

    A file name tells the azimuth A and elevation E of the light in degrees, and +A lights the left of the picture, so
    the light is at (-sin A cos E, sin E, cos A cos E). The grey levels are proportional to the light; nothing is
    decoded. The photograph without flash (`_Ambient`) and those known to be corrupt (`.bad`) are skipped.

    Parameters
    ----------
    folder
        The folder that holds `yaleB01`, `yaleB02`, ...
    people
        Numbers of the people wanted, in the order wanted; all by default, in ascending order.

    Returns
    -------
    list of YalePerson

    Raises
    ------
    HarmonicFaceError
        No such folder, nobody in it, a person who is not in it or is asked for twice or has no photographs, a file
        name that is none of the data set, an image of another size, a corrupt image.

    Examples
    --------
    With the data set in the folder CroppedYale::

        first, second = load_yale_b("CroppedYale", people=[1, 2])
        frontal = first.photographs[first.subsets == 1]
    """
    root = Path(folder)
    if not root.is_dir():
        raise HarmonicFaceError(f"expected the folder of the Extended Yale B (yaleB01, ...), got no folder {root}")
    found = {int(match[1]): path for path in sorted(root.iterdir()) if (match := FOLDER.fullmatch(path.name))}
    if not found:
        raise HarmonicFaceError(f"expected folders yaleB01, yaleB02, ... in {root}, got none")
    wanted = sorted(found) if people is None else list(people)
    for index, number in enumerate(wanted):
        if number not in found:
            raise HarmonicFaceError(f"expected people that are in {root} ({_spell(found)}), got {number}")
        if number in wanted[:index]:
            raise HarmonicFaceError(f"people: expected each number once, got {number} twice")
    return [_load_person(number, found[number]) for number in wanted]


def subset_of(angle: float) -> int:
    """Return the published subset, 1 to 5, of a light at so many degrees from the camera's axis.

    Subset 1 reaches to 12 degrees, 2 to 25, 3 to 51.5, 4 to 77; 5 lies beyond. The bounds belong to the lower subset.

    Parameters
    ----------
    angle
        Degrees, 0 to 180.

    Raises
    ------
    HarmonicFaceError
        No angle from 0 to 180.

    Examples
    --------
    >>> [subset_of(angle) for angle in (0, 25, 25.1, 130)]
    [1, 2, 3, 5]
    """
    if not 0 <= angle <= 180:
        raise HarmonicFaceError(f"angle: expected degrees from 0 to 180, got {angle}")
    return 1 + sum(angle > bound + SLACK for bound in SUBSET_BOUNDS)


def light_direction(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """Return the unit direction to the light of a photograph whose name gives azimuth and elevation in degrees.

    Examples
    --------
    >>> (light_direction(90, 0) + 0.0).round(6)
    array([-1.,  0.,  0.])
    """
    a, e = np.radians([azimuth, elevation])
    return np.array([-np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])


def parse_people(text: str) -> list[int]:
    """Return the numbers that a list of numbers and ranges names.

    Parameters
    ----------
    text
        Numbers of at least 1 and ranges of them, separated by commas.

    Raises
    ------
    HarmonicFaceError
        Something else, a range that runs backward, a number named twice.

    Examples
    --------
    >>> parse_people("1,3,5-7")
    [1, 3, 5, 6, 7]
    """
    numbers: list[int] = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,4})\s*(?:-\s*(\d{1,4})\s*)?", part, re.ASCII)
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
        if not 1 <= first <= last:
            raise HarmonicFaceError(f"people: expected numbers and ranges such as 1,3,5-7, got {text!r}")
        numbers.extend(range(first, last + 1))
    if len(set(numbers)) < len(numbers):
        raise HarmonicFaceError(f"people: expected each number once, got {text!r}")
    return numbers


def _load_person(number: int, folder: Path) -> YalePerson:
    files = tuple(
        path
        for path in sorted(folder.glob("*.pgm"))
        if not path.name.startswith(".") and not path.stem.endswith(AMBIENT)
    )
    if not files:
        raise HarmonicFaceError(f"expected photographs yaleB{number:02d}_P00A...E....pgm in {folder}, got none")
    lights = np.array([_light_of(path, number) for path in files])
    angles = np.degrees(np.arccos(np.clip(lights[:, 2], -1, 1)))
    subsets = np.array([subset_of(angle) for angle in angles])
    return YalePerson(number, np.stack([_read(path) for path in files]), lights, angles, subsets, files)


def _light_of(path: Path, number: int) -> NDArray[np.float64]:
    match = PHOTOGRAPH.fullmatch(path.stem)
    if match is None or int(match["person"]) != number:
        raise HarmonicFaceError(f"expected a name such as yaleB{number:02d}_P00A+035E-20.pgm, got {path}")
    return light_direction(float(match["azimuth"]), float(match["elevation"]))


def _read(path: Path) -> NDArray[np.float32]:
    photograph = read_image(path, transfer="linear")
    if photograph.shape != IMAGE_SHAPE:
        raise HarmonicFaceError(f"{path}: expected a cropped grey image of shape {IMAGE_SHAPE}, got {photograph.shape}")
    return photograph


def _spell(numbers: Iterable[int]) -> str:
    """Spell numbers as `parse_people` reads them."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ",".join(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)
