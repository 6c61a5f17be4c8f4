"""scripts/photometric_stereo.py: bad input ends in one line and exit code 2, never in a traceback."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from harmonicface.bench.stability.hard_photographs import lamps

SCRIPT = Path(__file__).parents[1] / "scripts" / "photometric_stereo.py"
LAMPS = lamps(6)
SIZE = 24


def folder_with(place: Path, what: str) -> list[Path]:
    """Write photographs with something wrong, and return what to call the script with."""
    place.mkdir()
    for number, lamp in enumerate(LAMPS):
        width = SIZE + 3 * (what == "unlike sizes" and number == 4)
        cv2.imwrite(str(place / f"{number}.png"), np.full((SIZE, width), round(40000 * lamp[2]), np.uint16))
    mask = np.full((SIZE, SIZE), 0 if what == "an empty mask" else 255, np.uint8)
    cv2.imwrite(str(place / "mask.png"), mask)
    rows = {
        "another length": LAMPS[:4],
        "not of unit length": 2 * LAMPS,
        "a zero direction": LAMPS * (np.arange(6) != 3)[:, None],
        "no numbers": np.full((6, 3), np.nan),
        "one lamp": LAMPS[[0] * 6],
    }
    np.savetxt(place / "lights.txt", rows.get(what, LAMPS))
    if what == "too few":
        np.savetxt(place / "lights.txt", LAMPS[:2])
        return [place / "0.png", place / "1.png", Path("--lights"), place / "lights.txt"]
    return [place]


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("unlike sizes", "4.png: expected 24 x 24 pixels as 0.png has, got 27 x 24"),
        ("too few", "images: expected at least 3"),
        ("another length", "expected a line for each of 6 photographs, got 4 lines"),
        ("not of unit length", "line 1: expected a unit direction"),
        ("a zero direction", "line 4: expected a unit direction"),
        ("no numbers", "lights.txt"),
        ("one lamp", "lights: expected directions that span space"),
        ("an empty mask", "mask.png: expected a mask with white in it, got an empty one"),
    ],
)
def test_bad_input_ends_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    what: str,
    message: str,
) -> None:
    given = folder_with(tmp_path / "photographs", what)
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), *map(str, given), "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(SCRIPT), run_name="__main__")
    printed = capsys.readouterr()
    assert ended.value.code == 2
    [line] = [line for line in printed.err.splitlines() if line.startswith("harmonicface: ")]
    assert message in line and "Traceback" not in printed.err and printed.out == ""
