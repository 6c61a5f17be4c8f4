"""Draw a contact sheet of synthetic people: python scripts/contact_sheet.py people.png [--seed 0] [--what photo]."""

from __future__ import annotations

import argparse

import numpy as np

from harmonicface.io.images import write_image
from harmonicface.people.synthetic import synthetic_people
from harmonicface.surfaces.surface import Surface

KEY = np.array([-0.55, 0.5, 0.75])  # from the upper left, toward the camera's side
AMBIENT, EXPOSURE = 0.15, 1.1


def tile(person: Surface, what: str) -> np.ndarray:
    """Return the picture of one person as linear light."""
    if what == "normals":
        return np.where(person.mask[..., None], (0.5 + 0.5 * person.normals) ** 2.2, 0)
    albedo = 0.6 if what == "shape" else person.albedo
    if what == "albedo":
        return person.albedo
    shading = AMBIENT + np.clip(person.normals @ (KEY / np.linalg.norm(KEY)), 0, None)
    return np.where(person.mask, EXPOSURE * albedo * shading, 0)


def main() -> None:
    """Write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", help="PNG file to write")
    parser.add_argument("--rows", type=int, default=5)
    parser.add_argument("--columns", type=int, default=5)
    parser.add_argument("--size", type=int, default=128, help="pixels a person")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--what", choices=("photo", "albedo", "shape", "normals"), default="photo")
    options = parser.parse_args()
    people = synthetic_people(options.rows * options.columns, options.size, options.seed)
    tiles = [tile(person, options.what) for person in people]
    rows = [np.hstack(tiles[k : k + options.columns]) for k in range(0, len(tiles), options.columns)]
    write_image(options.out, np.clip(np.vstack(rows), 0, 1).astype(np.float32))


if __name__ == "__main__":
    main()
