"""What is said about the lights of photographs: files, a folder's own, a chrome ball, or nothing."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from harmonicface._validate import Floats
from harmonicface.datasets.chrome_ball import load_chrome_ball
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.lights_file import LightsFile, read_intensities, read_lights_file
from harmonicface.stereo.colour import effective

OWN_LIGHTS = ("lights.txt", "light_directions.txt")
UNKNOWN = "unknown"
OWN_INTENSITIES = "light_intensities.txt"


@dataclass(frozen=True, eq=False)
class KnownLights:
    """What was said about the lights; None where nothing was."""

    directions: Floats | None = None
    intensities: Floats | None = None
    coefficients: Floats | None = None
    source: str = ""


def known_lights(
    files: list[Path],
    folder: Path | None,
    lights: Path | None,
    intensities: Path | None,
    ball: Path | None,
    circle: tuple[float, ...] | None,
    unknown: bool,
    transfer: str | None,
) -> KnownLights:
    """Return what files and a chrome ball say of the lights."""
    options = {"--lights": lights, "--ball": ball or circle, "--unknown": unknown}
    asked = [name for name, given in options.items() if given]
    if len(asked) > 1:
        raise HarmonicFaceError(f"lights: expected one of --lights, --ball, --unknown, got {' and '.join(asked)}")
    names = [file.name for file in files]
    brightness = None if intensities is None or str(intensities) == UNKNOWN else _intensities(intensities, len(names))
    if ball is not None or circle is not None:
        found = load_chrome_ball(files if ball is None else ball, circle, transfer)
        if len(found) != len(names):
            raise HarmonicFaceError(
                f"{ball}: expected a photograph of the ball for each of {len(names)}, got {len(found)}"
            )
        where = "the chrome ball" if ball is None else f"the chrome ball in {ball}"
        return KnownLights(found, brightness, None, where)
    source = None if unknown else _lights_file(lights, folder)
    if source is None:
        return KnownLights(intensities=brightness)
    told: LightsFile = read_lights_file(source).of(names, str(source))
    if told.intensities is not None and str(intensities) != UNKNOWN:
        if brightness is not None:
            raise HarmonicFaceError(f"intensities: expected them once, got them in {source} and in {intensities}")
        brightness = told.intensities
    beside = source.parent / OWN_INTENSITIES
    if intensities is None and brightness is None and source.name == "light_directions.txt" and beside.is_file():
        brightness = _intensities(beside, len(names))
    return KnownLights(told.directions, brightness, told.coefficients, f"the file {source}")


def _lights_file(lights: Path | None, folder: Path | None) -> Path | None:
    """Return the file that tells the lights: the one given, or one in the folder given, or beside the photographs."""
    if lights is not None and not lights.is_dir():
        return lights
    place = lights if lights is not None else folder
    if place is None:
        return None
    found = next((place / name for name in OWN_LIGHTS if (place / name).is_file()), None)
    if found is None and lights is not None:
        raise HarmonicFaceError(f"{lights}: expected {' or '.join(OWN_LIGHTS)} in the folder, got neither")
    return found


def _intensities(path: Path, count: int) -> Floats:
    found = read_intensities(path)
    if len(found) != count:
        raise HarmonicFaceError(f"{path}: expected a line for each of {count} photographs, got {len(found)} lines")
    return found


def brightness_of(known: KnownLights, asked: Path | None) -> Floats | Literal["unknown"] | None:
    """Return the brightness of lamps in grey, or that it is to be found."""
    if known.intensities is not None:
        return effective(known.intensities)
    return "unknown" if str(asked) == UNKNOWN and known.directions is not None else None
