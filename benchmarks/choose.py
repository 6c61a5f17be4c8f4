"""Is the model that is chosen the right one? Predicted errors beside those of exact pictures, and a gallery of them.

python benchmarks/choose.py [--quick] [--json FILE]

Each scene is a surface (sphere, ellipsoid, a part of them, people who do not exist, heads), an albedo, a distribution
of lights, a noise and a tolerance, drawn at random. `choose_model` sees the surface and the distribution alone. What it
predicts is then measured: exact pictures under lamps in 1,152 directions (clamped cosines; hard shadows cast by rays or
horizons, `render`), added up to pictures under the lights, with noise, fitted by each candidate's images. No setting of
the package was chosen on these people, views, crops, albedos and draws of light; they were chosen on others of them.

Then galleries that keep the chosen pictures of each person, beside the nine harmonic images and others.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

import harmonicface as hf
from harmonicface.appearance.choose import ModelChoice, choose_model
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Stopwatch, Timing, record
from harmonicface.lighting.layouts import layout_named
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.blockers import MeshBlocker

Array = NDArray[np.float64]

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data"))
SCENES, QUICK = 300, 40
SIZE = 40  # rows and columns of a picture
ROWS = 24  # of the maps of light: 1,152 directions
DRAWS = 600  # of natural light, other than those that its statistics come from
SEED = 2004
PROBES = (
    ("latlong/ennis.hdr", "latlong"),
    ("latlong/pedestrian_overpass_1k.hdr", "latlong"),
    ("latlong/uffizi.hdr", "latlong"),
    ("angular/beach_probe.hdr", "angular"),
    ("cube/grace", "cube"),
    ("cube/pisa", "cube"),
)


@dataclass(frozen=True, eq=False)
class Shape:
    """A white surface, and its exact pictures (p, n) under lamps of strength 1 from the directions of a map."""

    name: str
    surface: hf.Surface
    shadows: bool
    material: hf.Phong | None
    pictures: Array


@dataclass(frozen=True, eq=False)
class Lighting:
    """A distribution of lights: what `choose_model` is told, and lamps, (n, draws) strengths and (draws,) weights."""

    name: str
    told: object
    lamps: Array
    weights: Array


@dataclass(frozen=True, eq=False)
class Scene:
    """A question, its answer, and the measured error of each candidate by name."""

    name: str
    choice: ModelChoice
    measured: dict[str, float]

    @property
    def right(self) -> bool:
        """Whether what was said of the tolerance is so: the chosen model meets it, or none does."""
        if self.choice.meets:
            return self.measured[self.choice.name] <= self.choice.tolerance
        return min(self.measured.values()) > self.choice.tolerance

    @property
    def wasteful(self) -> bool:
        """Whether a model with a cheaper query would have met the tolerance."""
        rows = self.choice.cost.rows if self.choice.meets else np.inf
        cheaper = [row.name for row in self.choice.table if row.cost.rows < rows]
        return any(self.measured[name] <= self.choice.tolerance for name in cheaper)


def directions() -> tuple[Array, Array]:
    """Return the directions (n, 3) of a map's pixels and their solid angles (n,)."""
    layout, shape = layout_named("latlong"), (ROWS, 2 * ROWS)
    return layout.directions(shape).reshape(-1, 3), layout.solid_angles(shape).ravel()


def white(surface: hf.Surface) -> hf.Surface:
    """Return a surface with an albedo of 1."""
    return replace(surface, albedo=surface.mask.astype(np.float32), transports=())


def ellipsoid(across: float, up: float, toward: float) -> hf.Surface:
    """Return half an ellipsoid as the camera sees it; it casts no shadow on itself."""
    y, x = -np.mgrid[-1 : 1 : SIZE * 1j, -1 : 1 : SIZE * 1j]
    square = 1 - x**2 - y**2
    mask = square > 0
    z = np.sqrt(np.maximum(square, 0))
    normals = np.stack([-x / across, y / up, z / toward], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return hf.Surface(np.where(mask[..., None], normals, 0), mask.astype(float), mask)


def shapes(quick: bool) -> Iterator[tuple[str, bool, hf.Phong | None, Callable[[], hf.Surface]]]:
    """Yield name, whether it casts shadows, coat, and how to make each surface."""
    yield "sphere", False, None, partial(ellipsoid, 1, 1, 1)
    yield "ellipsoid", False, None, partial(ellipsoid, 1, 1.7, 0.8)
    yield "flat ellipsoid", False, None, partial(ellipsoid, 1.3, 1, 0.35)
    yield "glossy sphere", False, hf.Phong(9, 0.15), partial(ellipsoid, 1, 1, 1)
    for number in range(200, 204):
        yield f"person {number}", False, None, partial(hf.synthetic_person, number, SIZE)
    yield "glossy person", False, hf.Phong(25, 0.08), partial(hf.synthetic_person, 204, SIZE)
    for number in (205,) if quick else (205, 206, 207):
        yield f"person {number} with shadows", True, None, partial(hf.synthetic_person, number, SIZE)
    model, scan = DATA / "heads" / "ICT-FaceKit" / "FaceXModel", DATA / "heads" / "LeePerrySmith" / "LeePerrySmith.glb"
    if DATA.is_dir():
        heads = {
            "ICT 8": partial(hf.ict_person, model, 8, SIZE, albedo="uniform"),
            "ICT 11 turned": partial(hf.ict_person, model, 11, SIZE, rotation=(-30, 5, 0), albedo="uniform"),
            "LeePerrySmith turned": partial(hf.load_surface, scan, SIZE, rotation=(35, -8, 0)),
        }
        for name, make in heads.items():
            yield name, False, None, make
        if not quick:
            for name, make in heads.items():
                yield f"{name} with shadows", True, None, make


def pictured(name: str, shadows: bool, material: hf.Phong | None, surface: hf.Surface) -> Shape:
    """Return a shape with its exact pictures."""
    towards = directions()[0]
    if not shadows and material is None:
        normals = surface.pixel_normals.astype(np.float64)
        return Shape(name, surface, shadows, material, np.maximum(normals @ towards.T, 0))
    if surface.scene is not None and shadows:
        return Shape(name, surface, shadows, material, shadowed(surface, towards))
    columns = [
        hf.render(surface, hf.lights.directional(each), shadows=shadows, material=material)[surface.mask]
        for each in towards
    ]
    return Shape(name, surface, shadows, material, np.stack(columns, axis=1).astype(np.float64))


def shadowed(surface: hf.Surface, towards: Array) -> Array:
    """Return white pictures of a mesh under lamps, each pixel a mean over its samples: `render`, all lamps at once."""
    samples = surface.scene.samples(surface.mask)
    blocker = MeshBlocker(surface.scene.caster, samples)
    pictures = np.zeros((samples.pixels, len(towards)))
    for lamp, toward in enumerate(towards):
        cosine = samples.normals @ toward
        facing = np.flatnonzero((cosine > 0) & (samples.geometric @ toward > 0))
        lit = facing[~blocker.blocked_toward(facing, toward)]
        pictures[:, lamp] = samples.means(np.bincount(lit, cosine[lit], len(cosine)))
    return pictures


@lru_cache
def probes() -> tuple[hf.EnvironmentMap, ...]:
    """Return the measured environments as small grey maps, where there are any."""
    if not DATA.is_dir():
        return ()
    loaded = (hf.EnvironmentMap.load(DATA / "probes" / path, layout).grey() for path, layout in PROBES)
    return tuple(one.converted("latlong", 2 * ROWS) for one in loaded)


@lru_cache
def natural_lamps() -> Array:
    """Return natural lights as lamps, (n, draws)."""
    angles = directions()[1]
    draws = [hf.lights.natural(seed, ROWS).radiance.ravel() for seed in range(1_000_000, 1_000_000 + DRAWS)]
    return np.stack(draws, axis=1) * angles[:, None]


def lighting(rng: np.random.Generator) -> Lighting:
    """Draw a distribution of lights."""
    towards, angles = directions()
    kinds = ("natural", "sphere", "frontal", "some natural", "lamps", *(["probes"] * 2 if probes() else []))
    kind = kinds[rng.integers(len(kinds))]
    if kind == "natural":
        return Lighting(kind, kind, natural_lamps(), np.ones(DRAWS))
    if kind in ("sphere", "frontal"):
        lit = np.flatnonzero(towards[:, 2] > (-2 if kind == "sphere" else 0))
        return Lighting(kind, kind, np.eye(len(towards))[:, lit], angles[lit])
    count = int(rng.integers(3, 21))
    if kind == "lamps":
        lamps = np.zeros((len(towards), count))
        for draw in lamps.T:
            some = rng.choice(len(towards), rng.integers(1, 5), replace=False)
            draw[some] = rng.uniform(0.2, 1, len(some))
            draw += rng.uniform(0, 0.3) * angles / np.pi
        return Lighting(kind, [DirectionalLights(towards, draw) for draw in lamps.T], lamps, np.ones(count))
    if kind == "some natural":
        maps = [hf.lights.natural(rng, ROWS) for _ in range(count)]
    else:
        chosen = rng.integers(len(probes()), size=min(count, 8))
        maps = [probes()[i].rotated(_about_y(rng.uniform(0, 360))).converted("latlong", ROWS) for i in chosen]
        maps = [one * (4 / float((one.radiance * one.solid_angles).sum())) for one in maps]
    lamps = np.stack([one.radiance.ravel() * angles for one in maps], axis=1)
    return Lighting(kind, maps, lamps, np.ones(len(maps)))


def _about_y(degrees: float) -> Array:
    """Return a rotation about the vertical."""
    turn = np.radians(degrees)
    return np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])


def coloured(shape: Shape, rng: np.random.Generator) -> tuple[hf.Surface, Array]:
    """Return a surface with some albedo, perhaps a part of it, and its pictures."""
    surface, pictures = shape.surface, shape.pictures
    albedo = np.ones(surface.shape)
    if shape.material is None and rng.uniform() < 0.8:
        texture = gaussian_filter(rng.normal(size=surface.shape), rng.uniform(0.5, 6))
        albedo = np.exp(np.clip(rng.uniform(0, 1) * texture / texture.std(), -2, 2)) / np.e**2
    kept = surface.mask
    if not shape.shadows and rng.uniform() < 0.4:  # with shadows a part would lose what shades it
        height, width = rng.integers(12, SIZE, 2)
        top, left = rng.integers(0, SIZE - height + 1), rng.integers(0, SIZE - width + 1)
        window = np.zeros_like(kept)
        window[top : top + height, left : left + width] = True
        if (window & kept).sum() >= 60:
            kept = window & kept
    coat = albedo[kept][:, None] * pictures[kept[surface.mask]]
    known = () if kept is not surface.mask else surface.transports.values()
    return replace(surface, albedo=albedo.astype(np.float32), mask=kept, transports=known), coat


def measured(choice: ModelChoice, surface: hf.Surface, pictures: Array, light: Lighting, noise: float, rng) -> dict:
    """Return the error of each candidate's fit to noisy exact pictures."""
    exact = pictures @ light.lamps
    share = light.weights / light.weights.sum()
    energy = float((exact**2).sum(axis=0) @ share)
    spread = noise * np.sqrt(energy / len(exact))
    noisy = exact + spread * rng.standard_normal(exact.shape)
    found = {}
    for row in choice.table:
        rows = hf.Subspace.of(row.candidate.pictures(surface)).rows.astype(np.float64)
        wrong = rows.T @ (rows @ noisy) - exact
        found[row.name] = float(np.sqrt((wrong**2).sum(axis=0) @ share / energy))
    return found


def scenes(count: int, quick: bool, watch: Stopwatch) -> Iterator[Scene]:
    """Ask about random scenes and measure the answers."""
    rng = np.random.default_rng(SEED)
    known = [pictured(name, cast, coat, white(make())) for name, cast, coat, make in shapes(quick)]
    print(f"{len(known)} surfaces", file=sys.stderr, flush=True)
    for _ in range(count):
        shape, light = known[rng.integers(len(known))], lighting(rng)
        surface, pictures = coloured(shape, rng)
        noise = 0.0 if rng.uniform() < 0.4 else float(10 ** rng.uniform(-2.5, -1))
        tolerance = float(10 ** rng.uniform(-2.2, -0.7))
        ask = partial(choose_model, surface, light.told, tolerance, noise)
        choice = watch.run(partial(ask, shadows=shape.shadows, material=shape.material))
        found = measured(choice, surface, pictures, light, noise, rng)
        if shape.shadows:
            shape.surface.transports.update(surface.transports)
        yield Scene(f"{shape.name}, {light.name}", choice, found)


def agreement(pairs: Sequence[tuple[float, float]]) -> tuple[float, float, float]:
    """Return the log-log slope of measured against predicted, and the ratio of both, larger to smaller median, 95 %."""
    predicted, found = np.log(np.array(pairs)).T
    ratio = np.exp(np.abs(found - predicted))
    return float(np.polyfit(predicted, found, 1)[0]), float(np.median(ratio)), float(np.percentile(ratio, 95))


def choice_records(found: Sequence[Scene], watch: Stopwatch) -> Iterator[Record]:
    """Yield the agreement of predictions, and how often the choice is right."""
    made = partial(record, size=f"{len(found)} scenes", ours=watch.timing(), question="")
    for name, chosen in (("predicted error of the chosen model", True), ("predicted error of all candidates", False)):
        pairs = [
            (row.error.total, scene.measured[row.name])
            for scene in found
            for row in scene.choice.table
            if not chosen or row.name == scene.choice.name
        ]
        slope, ratio, worst = agreement(pairs)
        note = f"slope of the logarithms {slope:.3f}; ratio, larger to smaller, {ratio:.3f} at the median, "
        note += f"{worst:.3f} at 95 %"
        yield made(name, error=ratio - 1, unit="median ratio of measured and predicted, less 1", note=note)
    met = [scene for scene in found if scene.choice.meets]
    refused = [scene for scene in found if not scene.choice.meets]
    wrong, waste = 1 - np.mean([scene.right for scene in met]), np.mean([scene.wasteful for scene in found])
    note = f"of {len(met)} in which a model is said to meet the tolerance, {100 * (1 - wrong):.1f} % do"
    note += f"; of {len(refused)} in which none is, {sum(scene.right for scene in refused)} have none"
    yield made("the chosen model meets the tolerance", error=float(wrong), unit="share of scenes", note=note)
    note = f"in {100 * waste:.1f} % a model with fewer rows would have done"
    yield made("no cheaper model meets it", error=float(waste), unit="share of scenes", note=note)


def gallery_records(count: int) -> Iterator[Record]:
    """Yield time, memory and errors of galleries that keep more or less of each person, under natural light."""
    people = list(hf.synthetic_people(count, 64, SEED))
    rng = np.random.default_rng(SEED)
    asked = [(number, hf.lights.natural(rng)) for number in range(count) for _ in range(2)]
    photos = [hf.photograph(hf.render(people[number], light), rng, noise=0.01) for number, light in asked]
    known: dict[str, tuple[float, Timing, float]] = {}
    for model in ("harmonic9", "auto", "pca_auto", "pca5", "pca3", "ambient4", "linear3"):
        gallery, watch, wrong = hf.Gallery(model=model), Stopwatch(hf.Gallery.match, about=model), 0
        for number, person in enumerate(people):
            gallery.enroll(str(number), person)
        for (number, _), photo in zip(asked, photos, strict=True):
            match = watch.run(partial(gallery.match, photo, top=1))
            wrong += match.candidates[0].name != str(number)
        known[model] = 100 * wrong / len(asked), watch.timing(), gallery.bytes_per_person
        errors, timing, size = known[model]
        nine = known["harmonic9"]
        yield record(
            f"{model}: who is it, natural light",
            f"{count} people 64x64",
            timing,
            None if model == "harmonic9" else nine[1],
            error=errors,
            unit="% given to the wrong person",
            peer_error=None if model == "harmonic9" else nine[0],
            bytes=int(size),
            question="who is it, natural light",
            note=f"{100 * size / nine[2]:.0f} % of the nine images' memory, "
            f"{100 * timing.seconds / nine[1].seconds:.0f} % of their time",
        )


def records(quick: bool) -> Iterator[Record]:
    """Yield all records."""
    watch = Stopwatch(choose_model)
    yield from choice_records(list(scenes(QUICK if quick else SCENES, quick, watch)), watch)
    yield from gallery_records(60 if quick else 500)


if __name__ == "__main__":
    run_benchmark(__doc__, records, f"{QUICK} scenes, shadows of a depth map only", seed=SEED)
