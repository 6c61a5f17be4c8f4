"""What are shadows and bounces worth, and how far are ours from those of an independent renderer? Beside mitsuba.

python benchmarks/rendering.py [--quick] [--json FILE] [--heads NAME...] [--lights NAME...]

Each picture of ours is compared with mitsuba's of the same mesh, view, texture and light, both averaged over the
square of a pixel, over the mask eroded by one pixel. The error is the RMS of the difference over the RMS of mitsuba's
picture, with the part that is mitsuba's own noise taken away; the note has the raw number and the noise.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from scipy.ndimage import binary_erosion

import harmonicface as hf
from harmonicface.bench.agreement import Agreement, agreement
from harmonicface.bench.command_line import benchmark_parser, finish, there
from harmonicface.bench.measure import Record
from harmonicface.bench.mitsuba_oracle import mitsuba_picture, mitsuba_renderer
from harmonicface.bench.timing import Stopwatch, Timing, once, record
from harmonicface.people.ict import ict_person

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
FACE = (-1.524, -0.479, 1.364, 2.409)
LAMPS = (30, 60, 75, 85)  # degrees between the lamp and the camera
UPWARD = 20.0  # degrees that the lamps stand up from the horizontal plane, where they can
PATHS, PATHS_OF_A_LAMP = 256, 64  # in each pixel of each picture of mitsuba's; its noise under lamps is far lower
QUIET = 0.01  # the noise at which no more of its pictures are asked for
MOST_PICTURES, MOST_QUICK = 4, 2
UNIT = "% RMS of the picture's, mitsuba's noise taken away; mitsuba: its noise"
ENOUGH = {"shadows": 0.02, "one bounce": 0.04}

Head = Callable[[int], hf.Surface]


def heads() -> dict[str, Head]:
    """Return how to see each head at a size."""
    scan, model = DATA / "heads" / "LeePerrySmith", DATA / "heads" / "ICT-FaceKit" / "FaceXModel"
    found: dict[str, Head] = {
        "LeePerrySmith": lambda size: hf.load_surface(
            scan / "LeePerrySmith.glb", size, texture=scan / "Map-COL.jpg", flip_texture=True, frame=FACE
        )
    }
    for number in range(3):
        found[f"ICT {number}"] = lambda size, number=number: ict_person(model, number, size)
    return found


def lights() -> dict[str, hf.Light]:
    """Return the lamps and each measured environment as a latitude-longitude map."""
    found: dict[str, hf.Light] = {f"lamp at {angle}": lamp(angle) for angle in LAMPS}
    for path in sorted((DATA / "probes" / "latlong").glob("*.hdr")):
        found[path.stem] = hf.EnvironmentMap.load(path)
    for layout in ("angular", "cube"):
        for path in sorted((DATA / "probes" / layout).iterdir()):
            found[path.stem] = hf.EnvironmentMap.load(path, layout).converted("latlong")
    return found


def lamp(angle: float) -> hf.Light:
    """Return a lamp so many degrees from the camera's axis, to the right and a little up."""
    around = np.radians(UPWARD)
    across = np.sin(np.radians(angle))
    return hf.lights.directional([across * np.cos(around), across * np.sin(around), np.cos(np.radians(angle))])


def oracle(surface: hf.Surface, light: hf.Light, depth: int | None, most: int) -> tuple[list[np.ndarray], Timing]:
    """Return mitsuba's pictures, as many as it takes to be quiet, and the time they took, the scene's included."""
    scene, mask = surface.scene, inner(surface)
    assert scene is not None
    pictures: list[np.ndarray] = []
    paths = paths_under(light)
    watch = Stopwatch(mitsuba_renderer(), about=f"{paths} paths per pixel, until the noise is low")
    while len(pictures) < 2 or (len(pictures) < most and agreement(pictures[0], pictures, mask).noise > QUIET):
        seed = len(pictures)
        pictures.append(watch.run(partial(mitsuba_picture, scene.mesh, scene.view, light, paths, depth, seed=seed)))
    return pictures, watch.timing(sum)


def paths_under(light: hf.Light) -> int:
    """Return how many paths each pixel of each picture of mitsuba's gets."""
    return PATHS if isinstance(light, hf.EnvironmentMap) else PATHS_OF_A_LAMP


def inner(surface: hf.Surface) -> np.ndarray:
    """Return the mask without its outermost pixels, which the mesh does not fill."""
    return np.asarray(binary_erosion(surface.mask))


def coloured(picture: np.ndarray) -> np.ndarray:
    """Return a picture as (h, w, 3)."""
    return np.broadcast_to(picture if picture.ndim == 3 else picture[..., None], (*picture.shape[:2], 3))


def compare(name: str, surface: hf.Surface, label: str, light: hf.Light, most: int) -> Iterator[Record]:
    """Compare pictures with shadows, with one bounce and without shadows with mitsuba's."""
    mask = inner(surface)
    direct, direct_timing = oracle(surface, light, None, most)
    bounced, bounced_timing = oracle(surface, light, 3, most)
    for what, pictures, peer, options in (
        ("shadows", direct, direct_timing, {"shadows": True}),
        ("one bounce", bounced, bounced_timing, {"bounces": 1}),
        ("no shadows, against mitsuba with", direct, direct_timing, {}),
        ("no bounce, against mitsuba with one", bounced, bounced_timing, {"shadows": True}),
    ):
        timing, picture = once(partial(hf.render, surface, light, **options))
        found = agreement(coloured(picture), pictures, mask)
        yield record(
            f"render, {what}, {label}",
            f"{name} {surface.shape[0]} x {surface.shape[1]}",
            timing,
            peer,
            error=100 * found.error,
            peer_error=100 * found.noise,
            unit=UNIT,
            bytes=picture.nbytes,
            seed="0, 1, ...",
            question=f"render, {what}",
            note=f"{len(pictures)} pictures of mitsuba's; {in_words(found)}",
        )


def in_words(found: Agreement) -> str:
    """Return the numbers in percent."""
    return (
        f"relative RMS difference {100 * found.raw:.2f} %, of which mitsuba's noise {100 * found.noise:.2f} %, "
        f"without it {100 * found.error:.2f} %"
    )


def summary(records: Sequence[Record]) -> list[str]:
    """Return the range of errors of each kind, beside what is asked for."""
    lines = []
    for name in dict.fromkeys(one.question for one in records):
        errors = [one.error for one in records if one.question == name and one.error is not None]
        limit = ENOUGH.get(name.removeprefix("render, "))
        asked = "" if limit is None else f"; at most {100 * limit:.0f} % asked"
        middle = np.median(errors)
        lines.append(
            f"{name}: {min(errors):.2f} to {max(errors):.2f} %, median {middle:.2f} %, of {len(errors)}{asked}"
        )
    return lines


def main() -> None:
    """Run, and say the range of errors of each kind."""
    parser = benchmark_parser(__doc__, "one head at 64 x 64 under three lights")
    parser.add_argument("--heads", nargs="+", help="some of the heads: LeePerrySmith, 'ICT 0' and so on")
    parser.add_argument("--lights", nargs="+", help="some of the lights: 'lamp at 60', ennis and so on")
    options = parser.parse_args()
    if not there(DATA / "heads"):
        return
    size, most = (64, MOST_QUICK) if options.quick else (128, MOST_PICTURES)
    named = options.heads or (["LeePerrySmith"] if options.quick else list(heads()))
    everywhere = lights()
    lit = options.lights or (["lamp at 60", "lamp at 85", "uffizi"] if options.quick else list(everywhere))
    seen = ((name, heads()[name](size)) for name in named)
    found = finish(
        (
            one
            for name, surface in seen
            for label in lit
            for one in compare(name, surface, label, everywhere[label], most)
        ),
        options.json,
    )
    print(*summary(found), sep="\n")


if __name__ == "__main__":
    main()
