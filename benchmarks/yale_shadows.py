"""Yale B with cast shadows: what each ingredient contributes to recognizing people in extreme light.

Trained on the seven photographs of subset 1, matched by plain projection: no filtering, no normalization. Settings were
chosen on people 1-5; people 6-11 had no say in them.

python benchmarks/yale_shadows.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.optimize import nnls

from harmonicface.appearance.basis import harmonic_images
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Stopwatch, record
from harmonicface.datasets.yale_b import YalePerson, load_yale_b
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.grid import sphere_grid
from harmonicface.recognition.alignment import align, pyramid_of, reduced
from harmonicface.recognition.displaced import ShiftSearch
from harmonicface.recognition.subspace import Subspace
from harmonicface.stereo.depth.integration import integrate_normals
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.stereo.known.least_squares import scaled_normals
from harmonicface.stereo.motion import STILL, resample
from harmonicface.stereo.registration import register
from harmonicface.surfaces.surface import Surface

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
GROUPS = {"1-5": range(1, 6), "6-11": range(6, 12), "1-10": range(1, 11), "1-11": range(1, 12)}
DISPLACED = 5.0  # pixels, at most, to either side
SHORTLIST = 3  # people that are aligned more finely

Matcher = Callable[[NDArray[np.float32]], NDArray[np.float64]]  # a photograph -> the distance to everybody
Stereo = Callable[[NDArray[np.float32], NDArray[np.float64]], Surface]


@dataclass(frozen=True, eq=False)
class Questions:
    """All photographs, who is in them, and their subsets."""

    photographs: NDArray[np.float32]
    people: NDArray[np.int64]
    subsets: NDArray[np.int64]

    @classmethod
    def of(cls, faces: Sequence[YalePerson]) -> Questions:
        """Gather the photographs of everybody."""
        return cls(
            np.concatenate([face.photographs for face in faces]),
            np.concatenate([np.full(len(face.subsets), face.number) for face in faces]),
            np.concatenate([face.subsets for face in faces]),
        )

    def displaced(self) -> Questions:
        """Return the same photographs, each shifted by an amount of its own, fractions of a pixel among them."""
        shifts = np.random.default_rng(0).uniform(-DISPLACED, DISPLACED, (len(self.photographs), 2))
        motions = [np.column_stack([np.eye(2), shift]) for shift in shifts]
        seen = [resample(photo, motion)[0] for photo, motion in zip(self.photographs, motions, strict=True)]
        return Questions(np.stack(seen), self.people, self.subsets)


def surfaces(faces: Sequence[YalePerson], registered: bool, stereo: Stereo) -> list[Surface]:
    """Return everybody's Surface with depth from the photographs of subset 1."""
    found = []
    for face in faces:
        chosen = face.subsets == 1
        photographs = face.photographs[chosen]
        surface = stereo(register(photographs).photographs if registered else photographs, face.lights[chosen])
        depth = integrate_normals(surface.normals).astype(np.float32)
        found.append(Surface(surface.normals, surface.albedo, surface.mask, depth))
    return found


def shadows_left_out(photographs: NDArray[np.float32], lights: NDArray[np.float64]) -> Surface:
    """Return what the package's stereo finds."""
    return calibrated_stereo(photographs, lights).surface


def reweighted(photographs: NDArray[np.float32], lights: NDArray[np.float64]) -> Surface:
    """Return stereo by ten rounds of reweighting with a Cauchy loss of 2 % of white."""
    seen = photographs.reshape(len(photographs), -1).astype(np.float64)
    trusted = (seen > 0.03) & (seen < 0.99)
    scaled, _ = scaled_normals(seen, lights, trusted + 1e-3)
    for _ in range(10):
        predicted = lights @ scaled.T
        weights = trusted * (predicted > 0.02) / (1 + ((seen - predicted) / 0.02) ** 2)
        scaled, _ = scaled_normals(seen, lights, weights + 1e-4)
    return _surface(scaled.reshape(*photographs.shape[1:], 3))


def smoothed(photographs: NDArray[np.float32], lights: NDArray[np.float64]) -> Surface:
    """Return what the package's stereo finds, its normals smoothed by a Gaussian of a pixel."""
    found = calibrated_stereo(photographs, lights).surface
    normals = gaussian_filter(found.normals.astype(np.float64), (1, 1, 0))
    return _surface(normals / np.linalg.norm(normals, axis=2, keepdims=True) * found.albedo[..., None])


def _surface(scaled: NDArray[np.float64]) -> Surface:
    """Take albedo times normal apart."""
    albedo = np.linalg.norm(scaled, axis=2)
    normals = np.where(albedo[..., None] > 0, scaled / np.maximum(albedo, 1e-12)[..., None], [0.0, 0.0, 1.0])
    return Surface(normals.astype(np.float32), albedo.astype(np.float32), np.ones(albedo.shape, bool))


def pictures(people: Sequence[Surface], order: int, shadows: bool) -> list[NDArray[np.floating]]:
    """Return the harmonic images of everybody, (k, h, w)."""
    return [harmonic_images(one, order, shadows=shadows).reshape(-1, *one.shape) for one in people]


def projection(images: Sequence[NDArray[np.floating]], most: int | None = None) -> Matcher:
    """Return plain projection at full size, onto the strongest rows if so many are given."""
    rows = [Subspace.of(one.reshape(len(one), -1), most).rows for one in images]
    stack, starts = np.concatenate(rows), np.cumsum([0, *(len(one) for one in rows[:-1])])

    def match(photo: NDArray[np.float32]) -> NDArray[np.float64]:
        unit = photo.ravel() / np.linalg.norm(photo)
        return 1 - np.add.reduceat(np.square(stack @ unit), starts).astype(np.float64)

    return match


def shifted(images: Sequence[NDArray[np.floating]], **settings: float) -> Matcher:
    """Return projection at half the size after a search over shifts."""
    search = ShiftSearch(**settings)  # type: ignore[arg-type]
    for one in images:
        search.enroll(one)
    return lambda photo: search.match(photo).scores


def aligned(images: Sequence[NDArray[np.floating]]) -> Matcher:
    """Return the same, and then rotation, scale and parts of pixels for the best few."""
    search, small = ShiftSearch(), [pyramid_of(reduced(one, 2), (1,)) for one in images]
    for one in images:
        search.enroll(one)

    def match(photo: NDArray[np.float32]) -> NDArray[np.float64]:
        found = search.match(photo)
        scores, half = found.scores + 1.0, reduced(photo[None], 2)[0]  # those who are not aligned come last
        for index in np.argsort(found.scores)[:SHORTLIST]:
            start = STILL + np.pad(found.shifts[index][:, None] / 2, ((0, 0), (2, 0)))
            cost = found.scores[index] / max(found.distances[index], 1e-9)
            scores[index] = align(half, small[index], start).distance * cost
        return scores

    return match


def non_negative(images: Sequence[NDArray[np.floating]]) -> Matcher:
    """Return projection onto the cone of light that is nowhere negative, from a grid of directions."""
    grid = sphere_grid(9)
    towards = grid.directions[grid.directions[:, 2] > -0.7]
    cones = []
    for one in images:
        lights = real_harmonics(towards, int(np.sqrt(len(one))) - 1).T.astype(np.float64)
        flat = one.reshape(len(one), -1)
        rows = Subspace.of(flat).rows.astype(np.float64)
        cones.append((rows, (lights @ (flat.astype(np.float64) @ rows.T)).T))

    def match(photo: NDArray[np.float32]) -> NDArray[np.float64]:
        unit = photo.ravel().astype(np.float64) / np.linalg.norm(photo)
        squared = []
        for rows, rays in cones:
            inside = rows @ unit
            squared.append(1 - inside @ inside + nnls(rays, inside)[1] ** 2)
        return np.array(squared)

    return match


def judged(name: str, match: Matcher, asked: Questions) -> Record:
    """Ask for everybody in every photograph; errors within each group of people, the others neither asked nor there."""
    numbers = np.unique(asked.people)
    chosen = np.flatnonzero(asked.subsets >= 2)
    watch = Stopwatch(match, about=name)
    distances = [watch.run(partial(match, asked.photographs[index])) for index in chosen]
    table, parts, of_all = np.array(distances), [], float("nan")
    for group, members in GROUPS.items():
        there = np.isin(numbers, members)
        mine = np.isin(asked.people[chosen], members)
        wrong = numbers[there][table[mine][:, there].argmin(axis=1)] != asked.people[chosen][mine]
        subsets = asked.subsets[chosen][mine]
        by_subset = [100 * float(wrong[subsets == subset].mean()) for subset in (2, 3, 4, 5)]
        parts.append(f"people {group}: " + " / ".join(f"{value:.2f}" for value in by_subset))
        of_all = by_subset[3] if group == "1-10" else of_all
    return record(
        name,
        f"{len(numbers)} people 168x192",
        watch.timing(),
        error=of_all,
        unit="% of subset 5 given to the wrong person, people 1-10",
        question="extreme light",
        note="subsets 2 / 3 / 4 / 5, " + "; ".join(parts),
    )


def records(quick: bool) -> Iterator[Record]:
    """Add one ingredient after the other."""
    faces = load_yale_b(DATA, range(1, 12))
    asked = Questions.of(faces)
    plain = surfaces(faces, False, shadows_left_out)
    yield judged("nine images, photographs as they are", projection(pictures(plain, 2, False)), asked)
    yield judged("25 images, photographs as they are", projection(pictures(plain, 4, False)), asked)
    if not quick:
        yield judged("with shadows, order 2, photographs as they are", projection(pictures(plain, 2, True)), asked)
        yield judged("with shadows, order 4, photographs as they are", projection(pictures(plain, 4, True)), asked)
    people = surfaces(faces, True, shadows_left_out)
    yield judged("nine images, registered", projection(pictures(people, 2, False)), asked)
    orders = (4,) if quick else (8, 6, 4, 2)  # the highest first: lower ones are its first rows
    shadowed = {order: pictures(people, order, True) for order in orders}
    for order in reversed(orders):
        name = f"with shadows, order {order} ({(order + 1) ** 2} images), registered"
        yield judged(name, projection(shadowed[order]), asked)
    for order, rows in ((4, 9), (4, 15)) if quick else ((4, 9), (4, 15), (8, 25)):
        yield judged(f"the same, order {order}, {rows} strongest rows", projection(shadowed[order], rows), asked)
    best = shadowed[4]
    yield judged("the same, order 4, at half the size", shifted(best, reach=0), asked)
    yield judged("order 4, half the size, shifts to 6 pixels", shifted(best), asked)
    moved = asked.displaced()
    yield judged(f"order 4, half the size, photographs displaced by up to {DISPLACED:g}", shifted(best, reach=0), moved)
    yield judged("the same, shifts to 6 pixels", shifted(best), moved)
    if quick:
        return
    yield judged("order 4, half the size, shifts that cost nothing", shifted(best, reluctance=0.0), asked)
    yield judged(f"order 4, half the size, shifts, {SHORTLIST} people aligned", aligned(best), asked)
    yield judged("the same, photographs displaced", aligned(best), moved)
    yield judged("order 4, non-negative light (a cone, not a subspace)", non_negative(best), asked)
    for name, stereo in (("reweighted stereo", reweighted), ("smoothed normals", smoothed)):
        other = surfaces(faces, True, stereo)
        yield judged(f"with shadows, order 4, registered, {name}", projection(pictures(other, 4, True)), asked)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "order 4 alone, and fewer ingredients", needs=DATA, seed=0)
