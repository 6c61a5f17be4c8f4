"""Photographs of one thing under changing light: many files, read one by one, held on disk where they are many."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import check_transfer, linear_pixels
from harmonicface.io.pixels import ENDINGS, Pixels, read_pixels
from harmonicface.stereo.in_blocks import Images

LARGE = 1 << 29  # bytes of photographs beyond which they are held in a file
ROWS = 64  # decoded at a time
OTHERS = re.compile(r"mask|normal|depth|albedo", re.IGNORECASE)  # pictures beside photographs that are none
FULL = 1.0  # what a saturated photograph holds


@dataclass(frozen=True, eq=False)
class Photographs:
    """Photographs of one size, in grey; their colours are read again from the files when they are asked for.

    Parameters
    ----------
    files
        Where they were read from.
    images
        (n, h, w) float32, linear, in memory or mapped from a file: the mean of the colours, each multiplied by its
        part of `balance`; 1 where any colour is saturated.
    coloured
        Whether any of them has colour.
    brightest
        (h, w) float32, the most that any of them shows.
    transfer, reduce
        How they were read.
    """

    files: tuple[Path, ...]
    images: Images
    coloured: bool
    brightest: NDArray[np.float32]
    transfer: str | None
    reduce: int

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the files."""
        return tuple(file.name for file in self.files)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.brightest.shape[0], self.brightest.shape[1]

    def colours(self, index: int, mask: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Read the colours of a photograph again, of masked pixels in row-major order, (p, 3); infinite where full."""
        rows = _rows(self.files[index], read_pixels(self.files[index]), self.transfer, self.reduce)
        parts, top = [], 0
        for values, full in rows:
            inside = mask[top : top + len(values)]
            shown = np.where(
                full[inside][:, None], np.inf, values[inside] if values.ndim == 3 else values[inside, None]
            )
            parts.append(np.broadcast_to(shown, (len(shown), 3)))
            top += len(values)
        return np.concatenate(parts).astype(np.float32)


def photograph_files(sources: Sequence[Path]) -> list[Path]:
    """Return the photographs among files and folders: of a folder all images, ordered by the numbers in their names.

    Pictures in a folder that are called mask, normals, depth or albedo are left aside.

    Raises
    ------
    HarmonicFaceError
        Nothing there, a folder without images, the same file twice.
    """
    files: list[Path] = []
    for source in sources:
        files += images_in(source) if source.is_dir() else [source]
    if not files:
        raise HarmonicFaceError("images: expected photographs, got none")
    twice = next((file for file in files if files.count(file) > 1), None)
    if twice is not None:
        raise HarmonicFaceError(f"images: expected each photograph once, got {twice} twice")
    return files


def images_in(folder: Path) -> list[Path]:
    """Return the photographs of a folder, in the order of the numbers in their names.

    Raises
    ------
    HarmonicFaceError
        None there, or a folder that cannot be listed.
    """
    try:
        found = [file for file in folder.iterdir() if file.suffix.lower() in ENDINGS and not file.name.startswith(".")]
    except OSError as error:
        raise HarmonicFaceError(f"{folder}: expected a folder of photographs, got {error.strerror}") from None
    found = [file for file in found if not OTHERS.search(file.stem)]
    if not found:
        raise HarmonicFaceError(f"{folder}: expected a folder of photographs ({' '.join(ENDINGS)}), got none in it")
    return sorted(found, key=natural)


def natural(file: Path) -> list[tuple[int, str]]:
    """Return a key by which photo_2 comes before photo_10.

    Examples
    --------
    >>> sorted([Path("photo_10.png"), Path("photo_2.png")], key=natural)[0].name
    'photo_2.png'
    """
    return [(int(part), "") if part.isdigit() else (-1, part.lower()) for part in re.split(r"(\d+)", file.name) if part]


@contextmanager
def opened_photographs(
    files: Sequence[Path],
    *,
    transfer: str | None = None,
    balance: Floats | None = None,
    reduce: int = 1,
    folder: Path | None = None,
    tell: Callable[[str, int, int], None] = lambda *_: None,
) -> Iterator[Photographs]:
    """Read photographs one by one; more than 512 MB of them into a file that is removed afterwards.

    Memory does not grow with their number: of 96 photographs in colour, 16 bits and 12 megapixels (7.8 of them in the
    mask), photometric stereo by least squares took 4.1 GB at the peak, which was in drawing pictures of 12 megapixels;
    while they were read it was 0.9 GB. The file took 4.6 GB.

    Parameters
    ----------
    files
        Images of one size.
    transfer
        What their numbers mean, see `read_image`.
    balance
        (n, 3) by what the colours of each are multiplied before their mean is taken; a mean of 1 keeps what is below
        saturation there.
    reduce
        Squares of so many pixels a side become one.
    folder
        Where the file is made; by default where the system keeps such files, which may be memory.

    Yields
    ------
    Photographs

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, photographs of unlike sizes, another transfer, a disk that is full.
    """
    check_transfer(transfer)
    first = read_pixels(files[0])
    side = _validate.at_least(reduce, 1, "reduce")
    height, width = (length // side for length in first.values.shape[:2])
    if height == 0 or width == 0:
        raise HarmonicFaceError(f"reduce: expected at most {min(first.values.shape[:2])} pixels, got {side}")
    shape = (len(files), height, width)
    with _held(shape, folder) as images:
        brightest, coloured = np.zeros((height, width), np.float32), False
        for index, file in enumerate(files):
            tell("reading photographs", index, len(files))
            pixels = first if index == 0 else read_pixels(file)
            if pixels.values.shape[:2] != first.values.shape[:2]:
                expected, got = (" x ".join(map(str, each.values.shape[1::-1])) for each in (first, pixels))
                raise HarmonicFaceError(f"{file}: expected {expected} pixels as {files[0].name} has, got {got}")
            top, stored = 0, _picture(images, index)
            for values, full in _rows(file, pixels, transfer, side):
                grey = values if values.ndim == 2 else _grey(values, None if balance is None else balance[index])
                coloured = coloured or (values.ndim == 3 and bool((values[..., 1:] != values[..., :1]).any()))
                grey = np.where(full, np.float32(FULL), grey)
                bottom = top + len(values)
                stored[top:bottom] = grey
                np.maximum(brightest[top:bottom], grey, out=brightest[top:bottom])
                top = bottom
        tell("reading photographs", len(files), len(files))
        yield Photographs(tuple(files), images, coloured, brightest, transfer, side)


def _rows(
    file: Path, pixels: Pixels, transfer: str | None, side: int
) -> Iterator[tuple[NDArray[np.float32], NDArray[np.bool_]]]:
    """Yield linear rows of a photograph, and where they are saturated; squares of pixels become one."""
    values = pixels.values
    top = np.iinfo(values.dtype).max if values.dtype.kind == "u" else None
    height, width = (length // side for length in values.shape[:2])
    for first in range(0, height, ROWS):
        part = values[first * side : min(first + ROWS, height) * side, : width * side]
        shown = linear_pixels(part, transfer or pixels.transfer)
        if not np.isfinite(shown).all() or shown.min() < 0:
            raise HarmonicFaceError(f"{file}: expected finite pixels of at least 0, got others")
        full = np.zeros(part.shape[:2], bool) if top is None else (part == top).reshape(*part.shape[:2], -1).any(axis=2)
        if side > 1:
            squares = (len(part) // side, side, width, side)
            shown = shown.reshape(*squares, *shown.shape[2:]).mean(axis=(1, 3))
            full = full.reshape(squares).any(axis=(1, 3))
        yield shown, full


def _picture(images: Images, index: int) -> Images:
    """Return one picture to write to; of a file through a mapping of its own, which ends with it."""
    if not isinstance(images, np.memmap):
        return np.asarray(images[index])
    return np.memmap(str(images.filename), np.float32, "r+", images[:index].nbytes, images.shape[1:])


def _grey(colours: NDArray[np.float32], balance: Floats | None) -> NDArray[np.float32]:
    weights = np.full(3, 1 / 3, np.float32) if balance is None else (balance / 3).astype(np.float32)
    return np.asarray(colours @ weights)


@contextmanager
def _held(shape: tuple[int, int, int], folder: Path | None) -> Iterator[Images]:
    """Yield an array to be filled, in memory or in a file of its own."""
    needed = 4 * int(np.prod(shape))
    if needed <= LARGE:
        yield np.empty(shape, np.float32)
        return
    try:
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".photographs-") as file:
            file.truncate(needed)
            yield np.memmap(file.name, np.float32, "r+", 0, shape)
    except OSError as error:
        raise HarmonicFaceError(
            f"photographs: expected {needed / 1e9:.3g} GB of disk in {folder or tempfile.gettempdir()},"
            f" got {error.strerror}"
        ) from None
