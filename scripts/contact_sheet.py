"""Draw a contact sheet of people who do not exist: python scripts/contact_sheet.py people.png [--ict FaceXModel]."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from harmonicface.io.images import write_image
from harmonicface.people.ict import ict_person
from harmonicface.people.synthetic import synthetic_people
from harmonicface.surfaces.surface import Surface

# Lamps, and the even light besides: from the upper left toward the camera's side, and from the right.
LIGHTS = {"key": (np.array([-0.55, 0.5, 0.75]), 0.15), "side": (np.array([0.9, 0.15, 0.4]), 0.08)}
EXPOSURE = 1.1


def tile(person: Surface, what: str, light: str = "key") -> np.ndarray:
    """Return the picture of one person as linear light."""
    if what == "normals":
        return np.where(person.mask[..., None], (0.5 + 0.5 * person.normals) ** 2.2, 0)
    if what == "albedo":
        return person.albedo
    lamp, ambient = LIGHTS[light]
    shading = ambient + np.clip(person.normals @ (lamp / np.linalg.norm(lamp)), 0, None)
    shading = np.where(person.mask, EXPOSURE * shading, 0)
    if what == "shape":
        return 0.6 * shading
    return person.albedo * (shading if person.albedo.ndim == 2 else shading[..., None])


def main() -> None:
    """Write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", help="PNG file to write")
    parser.add_argument("--rows", type=int, default=5)
    parser.add_argument("--columns", type=int, default=5)
    parser.add_argument("--size", type=int, default=128, help="pixels a person")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--what", choices=("photo", "albedo", "shape", "normals"), default="photo")
    parser.add_argument("--light", choices=tuple(LIGHTS), default="key")
    parser.add_argument("--ict", type=Path, help="folder FaceXModel of ICT-FaceKit: its people instead")
    parser.add_argument("--yaw", type=float, default=0.0, help="degrees by which ICT people look to the right")
    options = parser.parse_args()
    count = options.rows * options.columns
    if options.ict is None:
        people = synthetic_people(count, options.size, options.seed)
    else:
        turn = (options.yaw, 0.0, 0.0)
        people = (ict_person(options.ict, k, options.size, seed=options.seed, rotation=turn) for k in range(count))
    tiles = [tile(person, options.what, options.light) for person in people]
    rows = [np.hstack(tiles[k : k + options.columns]) for k in range(0, count, options.columns)]
    write_image(options.out, np.clip(np.vstack(rows), 0, 1).astype(np.float32))


if __name__ == "__main__":
    main()
