"""Lights files: a line of text for each photograph, its direction, its brightness, or its harmonic coefficients."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing

ROUNDING = 0.02  # of a unit vector's length in text: two decimals
COLUMNS = {3: "x y z", 4: "x y z intensity", 6: "x y z red green blue", 9: "nine harmonic coefficients"}

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LightsFile:
    """What a lights file says.

    Parameters
    ----------
    directions
        (n, 3) unit vectors *to* the lights, x right, y up, z toward the camera; None where it holds coefficients.
    intensities
        (n,) or (n, 3) brightness of each light, in each colour; None where the file says nothing.
    coefficients
        (n, 9) harmonic coefficients of radiance; None where it holds directions.
    names
        The photographs that the lines are about; None where lines begin with numbers.
    """

    directions: Doubles | None
    intensities: Doubles | None
    coefficients: Doubles | None
    names: tuple[str, ...] | None

    def __len__(self) -> int:
        return len(self._rows())

    def of(self, photographs: Sequence[str], source: str) -> LightsFile:
        """Return the lights of photographs by their names, in their order; without names the lines are in order.

        Raises
        ------
        HarmonicFaceError
            Another number of lines than of photographs, a photograph that no line names.
        """
        if self.names is None:
            if len(self) != len(photographs):
                raise HarmonicFaceError(
                    f"{source}: expected a line for each of {len(photographs)} photographs, got {len(self)} lines"
                )
            return self
        lines = {name: index for index, name in enumerate(self.names)}
        missing = [name for name in photographs if _word(name) not in lines]
        if missing:
            others = f" and {len(missing) - 1} others" if len(missing) > 1 else ""
            raise HarmonicFaceError(
                f"{source}: expected a line for each of {len(photographs)} photographs,"
                f" got none for {missing[0]}{others}"
            )
        rows = [lines[_word(name)] for name in photographs]
        directions, intensities, coefficients = (
            None if each is None else each[rows] for each in (self.directions, self.intensities, self.coefficients)
        )
        return LightsFile(directions, intensities, coefficients, tuple(photographs))

    def _rows(self) -> Doubles:
        rows = self.directions if self.coefficients is None else self.coefficients
        assert rows is not None
        return rows


def read_lights_file(path: str | os.PathLike[str]) -> LightsFile:
    r"""Read the lights of photographs from a text file, a line for each.

    A line holds numbers between spaces, tabs, commas or semicolons: three are a unit direction *to* the light (x
    right, y up, z toward the camera), a fourth its intensity, or three more those of red, green and blue; nine are the
    harmonic coefficients of any distant light. The photograph's file name may stand before them. What follows a # is a
    comment, and lines without anything else are skipped.

    Parameters
    ----------
    path
        The file, in UTF-8.

    Returns
    -------
    LightsFile
        Directions are scaled to unit length exactly, from the two decimals or more that they need in the file.

    Raises
    ------
    HarmonicFaceError
        No such file, no text, a line that is something else or unlike the others, two lines for one photograph, a
        direction that is zero or not of unit length, an intensity that is not above 0.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "lights.txt"
    >>> _ = path.write_text("# x y z\n0 0 1\n0.6, 0, 0.8  # from the right\n")
    >>> read_lights_file(path).directions
    array([[0. , 0. , 1. ],
           [0.6, 0. , 0.8]])
    """
    names, numbers, lines = _parsed(Path(path))
    rows = np.array(numbers, np.float64)
    if rows.shape[1] == 9:
        return LightsFile(None, None, rows, names)
    lengths = np.linalg.norm(rows[:, :3], axis=1)
    for index in np.flatnonzero(np.abs(lengths - 1) > ROUNDING):
        got = "zero" if lengths[index] == 0 else f"one of length {lengths[index]:.4g}"
        raise HarmonicFaceError(
            f"{path}, line {lines[index]}: expected a unit direction (brightness goes into a fourth number), got {got}"
        )
    intensities = _intensities(rows[:, 3:], f"{path}, line", lines)
    return LightsFile(rows[:, :3] / lengths[:, None], intensities, None, names)


def read_intensities(path: str | os.PathLike[str]) -> Doubles:
    """Read the brightness of lights from a text file: a number, or red, green and blue, for each photograph.

    Returns
    -------
    array
        (n,) or (n, 3), above 0.

    Raises
    ------
    HarmonicFaceError
        No such file, no text, lines of other numbers, an intensity that is not above 0.
    """
    _, numbers, lines = _parsed(Path(path), columns=(1, 3))
    found = _intensities(np.array(numbers, np.float64), f"{path}, line", lines)
    assert found is not None
    return found


def write_lights_file(
    path: str | os.PathLike[str],
    names: Sequence[str],
    lights: ArrayLike,
    left_out: dict[int, str] | None = None,
    comments: Sequence[str] = (),
) -> None:
    """Write lights so that `read_lights_file` reads them again; the file is replaced whole or not at all.

    Parameters
    ----------
    path
        The file.
    names
        The n photographs.
    lights
        (n, 3) directions times brightness, or (n, 4) or (n, 9) harmonic coefficients, which become nine.
    left_out
        Photographs without a light, by index, each with the reason: it becomes a comment.
    comments
        Lines to begin with.

    Raises
    ------
    HarmonicFaceError
        Another shape, a light that is not finite or has no direction, a file that cannot be written.
    """
    rows = _validate.floats(lights, "lights")
    if rows.ndim != 2 or rows.shape[1] not in (3, 4, 9) or len(rows) != len(names):
        expected = f"shape ({len(names)}, 3), (…, 4) or (…, 9)"
        raise HarmonicFaceError(f"lights: expected {expected}, got {_validate.describe(rows)}")
    skipped = left_out or {}
    width = max(map(len, names), default=0)
    text = [*(f"# {line}" for line in comments), f"# photograph, {COLUMNS[4 if rows.shape[1] == 3 else 9]}"]
    for index, (name, row) in enumerate(zip(names, rows, strict=True)):
        if index in skipped:
            text.append(f"# {name} left out: {skipped[index]}")
            continue
        text.append(f"{_word(name):{width}} " + " ".join(f"{number: .6f}" for number in _line(row, name)))
    with replacing(path) as temporary:
        temporary.write_text("\n".join(text) + "\n", encoding="utf-8")


def _word(name: str) -> str:
    """Return a file name as it stands in a line: what parts columns becomes an underscore."""
    return re.sub(r"[\s,;#]", "_", name)


def _line(row: Floats, name: str) -> Doubles:
    """Return the numbers of a line."""
    if not np.isfinite(row).all() or not row.any():
        raise HarmonicFaceError(f"lights: expected a finite light other than 0 for {name}, got {row.tolist()}")
    if len(row) == 3:
        brightness = np.linalg.norm(row)
        return np.array([*(row / brightness), brightness])
    return np.concatenate([row, np.zeros(9 - len(row))])


def _parsed(
    file: Path, columns: Sequence[int] = tuple(COLUMNS)
) -> tuple[tuple[str, ...] | None, list[list[float]], list[int]]:
    """Return names or None, the numbers of each line, and the numbers of the lines."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:  # ValueError: no UTF-8, or a null character in the name
        reason = getattr(error, "strerror", None) or "a file that is no text"
        raise HarmonicFaceError(f"{file!s:.300}: expected a text file of lights, got {reason}") from None
    names: list[str | None] = []
    numbers: list[list[float]] = []
    lines: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        name = None if _is_number(words[0]) else words.pop(0)
        if (
            not all(map(_is_number, words))
            or len(words) not in columns
            or not np.isfinite(list(map(float, words))).all()
        ):
            wanted = " or ".join(map(str, columns))
            raise HarmonicFaceError(
                f"{file}, line {number}: expected {wanted} finite numbers, got {line.strip()!r:.80}"
            )
        names.append(name)
        numbers.append([float(word) for word in words])
        lines.append(number)
        if len(words) != len(numbers[0]) or (name is None) != (names[0] is None):
            raise HarmonicFaceError(f"{file}, line {number}: expected a line like the first, got {line.strip()!r:.80}")
    if not lines:
        raise HarmonicFaceError(f"{file}: expected a line for each photograph, got none")
    known = tuple(name for name in names if name is not None)
    if len(set(known)) < len(known):
        twice = next(name for name in known if known.count(name) > 1)
        raise HarmonicFaceError(f"{file}: expected one line for each photograph, got two for {twice}")
    return known or None, numbers, lines


def _is_number(word: str) -> bool:
    """Tell whether a word is a number."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _intensities(rows: Doubles, place: str, lines: list[int]) -> Doubles | None:
    """Return brightness as (n,) or (n, 3), None for no columns."""
    if rows.shape[1] == 0:
        return None
    for index in np.flatnonzero((rows <= 0).any(axis=1)):
        raise HarmonicFaceError(f"{place} {lines[index]}: expected intensities above 0, got {rows[index].tolist()}")
    return rows[:, 0] if rows.shape[1] == 1 else rows
