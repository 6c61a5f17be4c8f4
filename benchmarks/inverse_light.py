"""How well, and how fast, does a photograph tell its light? Beside scipy, and beside a mirror ball.

python benchmarks/inverse_light.py [--quick] [--json FILE]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.optimize import linear_sum_assignment, nnls
from scipy.spatial.transform import Rotation

import harmonicface as hf
from harmonicface.appearance.inverse import estimate_light
from harmonicface.appearance.nonnegative_light import fibonacci_sphere, nonnegative_light
from harmonicface.appearance.sparse_light import sparse_light
from harmonicface.appearance.sphere_views import combine_sphere_views, relative_errors
from harmonicface.appearance.texture_separation import separate_texture
from harmonicface.appearance.uniqueness import light_uniqueness
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.console import print_table
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, Stopwatch, best, record
from harmonicface.harmonics.indexing import degrees

Array = NDArray[np.float64]

NOISE = 0.01
MEDIAN = "relative L2 of orders 0-2, the median"
VIEWS = Rotation.concatenate(
    [Rotation.from_euler("y", angle, degrees=True) for angle in (0, 90, 180, 270)]
    + [Rotation.from_euler("x", angle, degrees=True) for angle in (90, -90)]
)


def whole_sphere(size: int) -> hf.Surface:
    """Return a white surface with evenly spread normals."""
    normals = fibonacci_sphere(size**2).reshape(size, size, 3)
    return hf.Surface(normals, np.ones((size, size)))


def half_sphere(size: int) -> hf.Surface:
    """Return a white ball as a camera sees it."""
    x, y, inside = _disc(size)
    normals = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))], axis=-1) * inside[..., None]
    return hf.Surface(normals, inside * 1.0, inside)


def estimation(surface: hf.Surface, name: str, order: int, ridge: float | str, seeds: int) -> Record:
    """Estimate natural light from noisy photographs; the peer is scipy's least squares on the same images."""
    errors, peers = [], []
    images = hf.harmonic_images(surface, order).astype(np.float64)
    shown = np.abs(images).max(axis=1) > 0
    for seed in range(seeds):
        light = hf.lights.natural(seed)
        photo = _noisy(hf.render(surface, light), seed)
        truth = light.coefficients(2)
        found = estimate_light(photo, surface, order, ridge=ridge)  # type: ignore[arg-type]
        plain = np.zeros(len(images))
        plain[shown] = lstsq(images[shown].T, photo[surface.mask])[0]
        low = min(9, len(plain))
        errors.append(np.linalg.norm(found.coefficients[:low] - truth[:low]) / np.linalg.norm(truth))
        peers.append(np.linalg.norm(plain[:low] - truth[:low]) / np.linalg.norm(truth))
    lost = [mode.name for mode in found.unrecoverable if "odd" not in mode.reason]
    return record(
        f"estimate_light, order {order}, ridge {ridge}",
        f"{name}, {int(surface.mask.sum())} pixels",
        best(partial(estimate_light, photo, surface, order, ridge=ridge)),
        best(
            Call(
                lambda: lstsq(hf.harmonic_images(surface, order).astype(np.float64)[shown].T, photo[surface.mask]),
                lstsq,
                about=f"on the images of order {order}, made anew",
            )
        ),
        error=float(np.median(errors)),
        peer_error=float(np.median(peers)),
        unit=MEDIAN,
        seed=f"0 to {seeds - 1}",
        question=f"light of a {name}",
        note=(
            f"{seeds} natural lights, 1 % noise; condition {found.condition:.3g}; {int(found.recoverable.sum())} of"
            f" {len(plain)} coefficients recoverable; {len(lost)} even modes hidden or drowned: {lost[:1]}"
        ),
    )


def honesty(surface: hf.Surface, name: str, order: int, draws: int) -> Record:
    """Compare the standard deviations that are told with those of drawn noise."""
    photo = np.asarray(hf.render(surface, hf.lights.natural(0)), np.float64)
    rng = np.random.default_rng(0)
    noisy = (photo + rng.normal(0, NOISE, photo.shape) for _ in range(draws))
    watch = Stopwatch(estimate_light)
    found = [watch.run(partial(estimate_light, one, surface, order, noise=NOISE)) for one in noisy]
    sure = found[0].recoverable
    ratio = np.std([each.coefficients for each in found], axis=0)[sure] / found[0].std[sure]
    return record(
        f"standard deviations, order {order}",
        f"{name}, {draws} draws",
        watch.timing(),
        error=float(np.abs(ratio - 1).max()),
        unit="|drawn / told - 1|, the worst",
        seed=0,
        question="standard deviations",
        note=f"of {int(sure.sum())} coefficients; root mean square {np.sqrt(np.mean((ratio - 1) ** 2)):.3f}",
    )


def nonnegative(seeds: int) -> Record:
    """Fit non-negative lamps to faces; the peer is scipy's nnls on all pixels."""
    face = hf.synthetic_person(3, 48)
    grid = fibonacci_sphere(250)
    pictures = face.pixel_albedo[:, None] * np.maximum(face.pixel_normals.astype(np.float64) @ grid.T, 0)
    errors, free = [], []
    for seed in range(seeds):
        light = hf.lights.natural(seed)
        photo = _noisy(hf.render(face, light), seed)
        truth = light.coefficients(2)
        errors.append(_relative(nonnegative_light(photo, face, 250).light.coefficients(2), truth))
        free.append(_relative(estimate_light(photo, face).coefficients, truth))
    return record(
        "nonnegative_light",
        f"face, {int(face.mask.sum())} pixels, 250 directions",
        best(partial(nonnegative_light, photo, face, 250), 3),
        best(Call(partial(nnls, pictures, photo[face.mask], maxiter=10000), about="on all pixels"), 1),
        error=float(np.median(errors)),
        unit=MEDIAN,
        seed=f"0 to {seeds - 1}",
        note=f"estimate_light: {np.median(free):.4f}",
    )


def lamps(count: int, noise: float, seeds: int) -> Record:
    """Find lamps on a face."""
    face = hf.synthetic_person(3, 48)
    normals = face.normals.astype(np.float64)
    normals[face.mask] /= np.linalg.norm(normals[face.mask], axis=1, keepdims=True)
    face = hf.Surface(normals, face.albedo.astype(np.float64), face.mask)
    off, told, right, watch = [], [], 0, Stopwatch(sparse_light)
    for seed in range(seeds):
        directions, strengths = _apart(np.random.default_rng(seed), count)
        photo = face.albedo * (np.maximum(face.normals @ directions.T, 0) @ strengths)
        photo = photo + np.random.default_rng(seed).normal(0, noise, photo.shape) * face.mask
        found = watch.run(partial(sparse_light, photo, face))
        if len(found.light.directions) == count:
            right += 1
            towards = found.light.directions
            angles = np.arctan2(
                np.linalg.norm(np.cross(directions[:, None], towards[None]), axis=2), directions @ towards.T
            )
            off.append(np.degrees(angles[linear_sum_assignment(angles)]))
            told.append(found.std_degrees)
    return record(
        f"sparse_light, {count} lamps, noise {noise}",
        f"face, {int(face.mask.sum())} pixels, {seeds} lights",
        watch.timing(),
        error=float(np.sqrt(np.mean(np.square(off)))),
        unit="degrees, root mean square",
        seed=f"0 to {seeds - 1}",
        question="sparse_light",
        note=f"worst {np.max(off):.3g}, told {np.sqrt(np.mean(np.square(told))):.3g};"
        f" the number of lamps, not given, right in {right} of {seeds}",
    )


LIMBS: dict[str, Callable[[Array], Array]] = {
    "linear": lambda cosine: cosine - 1,
    "logarithmic": lambda cosine: np.log(np.maximum(cosine, 0.05)),
}
BIAS = 0.02  # root mean square departure of B from a scaled matte ball's


def experiment(seeds: int, size: int) -> list[Record]:
    """Compare matte balls with mirror balls: with noise, and beside it with 2 % of bias in B or in each photograph."""
    fourth: dict[str, list[float]] = {}
    low: dict[str, list[float]] = {}
    third: dict[str, list[float]] = {}
    for seed in range(seeds):
        light = hf.lights.natural(seed, 16)
        real = light.converted("mirrorball", 256).coefficients(4)
        for name, photos in _ball_photos(light, size, seed).items():
            views = combine_sphere_views(photos, VIEWS, highlight=np.inf)
            found, irradiance = views.light(4).values, views.coefficients(4)
            fourth.setdefault(name, []).append(float(relative_errors(found, real)[4]))
            low.setdefault(name, []).append(_scaled(found[:9], real[:9]))
            share = np.linalg.norm(irradiance[degrees(4) == 3]) / np.linalg.norm(irradiance)
            third.setdefault(name, []).append(float(share))
            if seed == 0 and name == "bias 2 % after averaging, linear limb":
                print_table("one light of the experiment", *_table(irradiance, found, real))
    timing = best(Call(lambda: combine_sphere_views(photos, VIEWS).light(4), combine_sphere_views), 3)
    return [
        record(
            f"matte ball against mirror ball, noise 1 %, {name}",
            f"{seeds} natural lights, six photos {size} x {size}",
            timing,
            error=float(np.median(errors)),
            unit="relative L2 of order 4, the median",
            seed=f"0 to {seeds - 1}",
            question="matte ball against mirror ball, noise 1 %",
            note=f"from {min(errors):.3f} to {max(errors):.3f}; of orders 0-2"
            f" {np.median(low[name]):.4f}, at most {max(low[name]):.4f}; order-3 irradiance at most"
            f" {max(third[name]):.5f} of all",
        )
        for name, errors in fourth.items()
    ]


def _ball_photos(light: hf.EnvironmentMap, size: int, seed: int) -> dict[str, list[Array]]:
    """Photograph a matte ball from six sides by exact sums of clamped cosines, without and with limb darkening."""
    rng = np.random.default_rng(seed)
    x, y, inside = _disc(size)
    normals = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))], axis=-1)[inside]
    bare = np.stack([light.irradiance(normals @ turn.T).astype(np.float64) for turn in VIEWS.as_matrix()])
    noisy = bare + rng.normal(0, NOISE * bare.mean(axis=1, keepdims=True), bare.shape)

    def pictures(values: Array) -> list[Array]:
        made = np.zeros((len(values), size, size))
        made[:, inside] = values
        return list(made)

    photos = {"no bias": pictures(noisy)}
    matte = combine_sphere_views(pictures(bare), VIEWS, highlight=np.inf)
    for law, limb in LIMBS.items():
        darker = 0.05 * limb(normals[:, 2]) * bare
        full = combine_sphere_views(pictures(bare + darker), VIEWS, highlight=np.inf)
        after = _departure(full.values, matte.values, matte.solid_angles)
        each = [_departure(a + b, a, np.ones(len(a))) for a, b in zip(bare, darker, strict=True)]
        single = float(np.sqrt(np.mean(np.square(each))))
        photos[f"bias 2 % after averaging, {law} limb"] = pictures(noisy + BIAS / after * darker)
        photos[f"bias 2 % per photograph, {law} limb"] = pictures(noisy + BIAS / single * darker)
    return photos


def _departure(full: Array, bare: Array, areas: Array) -> float:
    """Return how far a radiosity departs from another one, scaled to it by least squares."""
    scale = (areas * full) @ bare / (areas @ bare**2)
    return float(np.sqrt(areas @ (full - scale * bare) ** 2 / (areas @ bare**2)))


def _table(irradiance: Array, found: Array, real: Array) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of the experiment: E_lm, the filter, recovered and real light after one scale."""
    scale = (found[:9] @ real[:9]) / (found[:9] @ found[:9])
    filters = (np.pi, 2 * np.pi / 3, np.pi / 4, 0.0, -np.pi / 24)
    rows = []
    for i, degree in enumerate(degrees(4)):
        recovered = [f"{scale * found[i]:.3f}", f"{real[i]:.3f}"] if degree != 3 else ["", ""]
        mode = i - degree * (degree + 1)
        rows.append([f"({degree},{mode:2d})", f"{scale * irradiance[i]:.4f}", f"{filters[degree]:.3f}", *recovered])
    return ["(l, m)", "E_lm", "A_l", "recovered", "real"], rows


def texture(seeds: int) -> Record:
    """Separate texture from light on faces; beside it the photograph itself, taken for texture."""
    ours, raw = [], []
    for seed in range(seeds):
        face = hf.synthetic_person(seed, 48)
        photo = np.asarray(hf.render(face, hf.lights.natural(seed)), np.float64)
        truth = face.albedo[face.mask].astype(np.float64)
        split = separate_texture(photo, face, mean_albedo=float(truth.mean()))
        inside = split.told[face.mask]
        ours.append(_relative(split.texture[face.mask][inside], truth[inside]))
        raw.append(_relative(photo[face.mask] * truth.mean() / photo[face.mask].mean(), truth))
    return record(
        "separate_texture",
        f"{seeds} faces 48 x 48 under natural light",
        best(partial(separate_texture, photo, face), 3),
        error=float(np.median(ours)),
        unit="relative L2 of the albedo, the median",
        seed=f"0 to {seeds - 1}",
        note=f"the photograph's own, scaled: {np.median(raw):.3f}",
    )


def uniqueness() -> list[Record]:
    """Ask how much of a light may be elsewhere without any matte surface showing it."""
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    four = sum((hf.lights.directional(c) for c in corners[1:]), start=hf.lights.directional(corners[0]))
    records = []
    for name, light in (("four lamps, a tetrahedron", four), ("natural light 32 x 64", hf.lights.natural(0))):
        report = light_uniqueness(light)
        assert report.alternative is not None
        normals = fibonacci_sphere(1000)
        exact = light.irradiance(normals)
        records.append(
            record(
                "light_uniqueness",
                name,
                best(partial(light_uniqueness, light), 3),
                error=float(np.abs(report.alternative.irradiance(normals) - exact).max() / exact.max()),
                unit="of the irradiance, the largest",
                note=f"another light, which differs in {100 * report.share:.2f} % (bound {100 * report.bound:.2f} %)",
            )
        )
    return records


def _noisy(picture: object, seed: int) -> Array:
    """Add white noise of 1 % of full scale."""
    photo = np.asarray(picture, np.float64)
    return photo + np.random.default_rng(seed).normal(0, NOISE, photo.shape)


def _relative(found: Array, truth: Array) -> float:
    return float(np.linalg.norm(found - truth) / np.linalg.norm(truth))


def _scaled(found: Array, truth: Array) -> float:
    return _relative(found * (found @ truth) / (found @ found), truth)


def _disc(size: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return coordinates of pixel centres, and which are on the ball."""
    centre = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(centre, -centre)
    return x, y, x**2 + y**2 < 0.9999


def _apart(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Return lamps in front, at least 25 degrees apart."""
    while True:
        directions = rng.normal(size=(count, 3))
        directions[:, 2] = np.abs(directions[:, 2])
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        if (directions @ directions.T - 2 * np.eye(count)).max() < np.cos(np.radians(25)):
            return directions, rng.uniform(0.3, 1.0, count)


def records(quick: bool) -> list[Record]:
    """Return all measurements."""
    seeds, draws, size = (4, 200, 48) if quick else (16, 400, 96)
    face = hf.synthetic_person(3, 64)
    found = [
        estimation(surface, name, order, ridge, seeds)
        for name, surface in (("whole sphere", whole_sphere(64)), ("half sphere", half_sphere(64)), ("face", face))
        for order, ridge in ((2, "decay"), (2, 0.0), (4, "decay"), (8, "decay"))
    ]
    found += [honesty(whole_sphere(32), "whole sphere", 2, draws), honesty(half_sphere(32), "half sphere", 4, draws)]
    found += [nonnegative(seeds)]
    found += [lamps(count, noise, seeds) for count in (1, 2, 3) for noise in (0.0, NOISE)]
    found += experiment(16, size)
    return [*found, texture(seeds), *uniqueness()]


if __name__ == "__main__":
    run_benchmark(__doc__, records, "fewer lights and smaller pictures")
