"""Compare the spread between synthetic people with real ones: python scripts/people_spread.py DATA [--map FILE.png].

Shape: random heads of the ICT face model, whose first 16 of 100 modes are in DATA/heads, so real heads spread a little
more; their albedo is as invented as that of the synthetic people. Albedo: Yale B by photometric stereo from subsets 1
and 2, so its spread includes errors of stereo and of the photographs' rough alignment. All are aligned by eyes and
mouth, and compared over pixels that everybody has.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.people.anatomy import EYE
from harmonicface.people.crop import FRAME
from harmonicface.people.ict import ict_people
from harmonicface.people.spread import albedo_spread, common_mask, normal_spread
from harmonicface.people.synthetic import synthetic_people
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import View

YALE_EYES = (36.0, 131.5, 45.0)  # columns of the two irises and their row in the cropped photographs


def yale_people(folder: Path, size: int, people: range = range(1, 12)) -> list[Surface]:
    """Return people of Yale B by stereo, resampled to where the synthetic ones have their eyes."""
    surfaces = []
    for person in load_yale_b(folder, people):
        near = person.subsets <= 2
        stereo = calibrated_stereo(person.photographs[near], person.lights[near])
        surfaces.append(_in_our_frame(stereo.surface, size))
    return surfaces


def _in_our_frame(surface: Surface, size: int) -> Surface:
    """Return a Surface whose pixels lie where the synthetic people's lie; albedo only is meant."""
    view = View.fit(np.zeros((1, 3)), (size, size), frame=FRAME)
    place = (np.arange(size) + 0.5) * view.pixel_size
    x, y = np.meshgrid(view.frame[0] + place, view.frame[3] - place)
    left, right, row = YALE_EYES
    scale = (right - left) / (2 * EYE[0])  # photograph pixels a millimetre
    columns = ((left + right) / 2 + scale * x).astype(np.float32)
    rows = (row - scale * (y - EYE[1])).astype(np.float32)
    blurred = cv2.GaussianBlur(surface.albedo.astype(np.float32), (0, 0), 0.4 * view.pixel_size * scale)
    albedo = cv2.remap(blurred, columns, rows, cv2.INTER_LINEAR)
    height, width = surface.shape
    mask = (columns > 1) & (columns < width - 2) & (rows > 1) & (rows < height - 2)
    return Surface(np.tile([0.0, 0.0, 1.0], (size, size, 1)), albedo, mask, pixel_size=view.pixel_size)


def main() -> None:
    """Print the table; draw the maps if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="folder with heads/ICT-FaceKit and yaleb")
    parser.add_argument("--people", type=int, default=100, help="synthetic people")
    parser.add_argument("--heads", type=int, default=40, help="random ICT heads")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--map", help="PNG file for maps of the spread")
    options = parser.parse_args()
    ours = list(synthetic_people(options.people, options.size, options.seed))
    ict = ict_people(options.data / "heads/ICT-FaceKit/FaceXModel", options.heads, options.size, albedo="grey")
    yale = yale_people(options.data / "yaleb", options.size)
    shape_pixels, albedo_pixels = common_mask([*ours, *ict]), common_mask([*ours, *ict, *yale])
    shapes = [normal_spread(people, shape_pixels) for people in (ours, ict)]
    albedos = [albedo_spread(people, albedo_pixels) for people in (ours, ict, yale)]
    print(f"{'between people':34}{'synthetic':>10}{'ICT':>10}{'Yale B':>10}")
    for label, name in (("normals, RMS angle to the mean", "rms"), ("normals, mean angle to the mean", "mean")):
        print(f"{label:34}" + "".join(f"{getattr(spread, name):8.1f} °" for spread in shapes))
    rows = (
        ("albedo, spread between people", "between"),
        ("albedo, contrast within a face", "contrast"),
        ("albedo, spread of mean tones", "tone"),
    )
    for label, name in rows:
        print(f"{label:34}" + "".join(f"{100 * getattr(spread, name):8.1f} %" for spread in albedos))
    if options.map:
        _draw(options.map, [spread.map / 25 for spread in shapes], [albedos[0].map / 0.6, albedos[2].map / 0.6])


def _draw(path: str, shapes: list[np.ndarray], albedos: list[np.ndarray]) -> None:
    """Write the maps: synthetic left, real right; normals above (white is 25 degrees), albedo below (white is 60 %)."""
    picture = np.nan_to_num(np.vstack([np.hstack(shapes), np.hstack(albedos)]))
    grey = np.round(255 * np.clip(picture, 0, 1)).astype(np.uint8)
    cv2.imwrite(path, cv2.resize(grey, None, fx=4, fy=4, interpolation=cv2.INTER_NEAREST))


if __name__ == "__main__":
    main()
