"""Do analytic principal components tell what rendering would, and how much sooner? Beside what has been published.

python benchmarks/principal.py [--quick] [--json FILE]

Rendered pictures are exact, under lamps on a quadrature grid; heads have uniform albedo where nothing else is said.
Lamps are of strength 1, and the mean picture is taken out, where nothing else is said.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, svd

import harmonicface as hf
from harmonicface.appearance.principal import analytic_pca
from harmonicface.appearance.principal_components import PrincipalComponents
from harmonicface.appearance.principal_empirical import empirical_pca, lamp_grid
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, best, once, record
from harmonicface.datasets.yale_b import load_yale_b

BESIDE_THE_PROJECT = Path(__file__).parents[2] / "shared" / "data"
DATA = Path(os.environ.get("HARMONICFACE_DATA", BESIDE_THE_PROJECT))
HEAD = (-2.1, -0.2, 2.1, 4.05)  # chin to crown of the scan, in its own units
ORDERS = (4, 2)
WHERE = {"sphere": "all around", "frontal": "in front"}
PUBLISHED = (
    "published (Ramamoorthi 2002, another scanned face): .42 .33 .16 .035 .021, 91 % in 3 and 97 % in 5; "
    "photographed (Epstein et al. 1995): 90 % and 94 %"
)
DIMENSIONS = (3, 4, 5, 9)
WORST = "relative, the largest of the first five variances"
Array = NDArray[np.float64]


def surfaces(size: int) -> dict[str, hf.Surface]:
    """Return what is seen: a ball, a synthetic face, and heads if there is real data."""
    found = {"sphere": ball(size), "synthetic face with its albedo": hf.synthetic_person(0, size)}
    if DATA.is_dir():
        scan = hf.load_surface(DATA / "heads" / "LeePerrySmith" / "LeePerrySmith.glb", size, frame=HEAD)
        found["LeePerrySmith"] = hf.Surface(scan.normals, scan.mask.astype(np.float32), scan.mask)
        model = DATA / "heads" / "ICT-FaceKit" / "FaceXModel"
        found["ICT 0"] = hf.ict_person(model, 0, size, albedo="uniform")
        found["ICT 0 with its albedo"] = hf.ict_person(model, 0, size)
    return found


def ball(size: int) -> hf.Surface:
    """Return a white ball that fills the picture."""
    across = (2 * np.arange(size, dtype=np.float32) + 1) / size - 1
    x, y = np.meshgrid(across, -across)
    mask = x**2 + y**2 < 1
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    return hf.Surface(np.stack([x, y, z], axis=-1) * mask[..., None], mask.astype(np.float32), mask)


def records(quick: bool) -> Iterator[Record]:
    """Compare variances, then times, then with photographs."""
    size, pictures = (48, 400) if quick else (128, 1000)
    seen = surfaces(size)
    for name, surface in seen.items():
        for lights in ("sphere", "frontal"):
            yield from variances(name, surface, lights, pictures)
    yield from routes(seen["synthetic face with its albedo"], pictures)
    if (DATA / "yaleb").is_dir():
        yield yale_b(range(1, 3) if quick else range(1, 12))


def variances(name: str, surface: hf.Surface, lights: str, pictures: int) -> Iterator[Record]:
    """Compare the analytic variances of each order with those of rendered pictures."""
    size = f"{name} {surface.shape[0]} x {surface.shape[1]}, lamps {WHERE[lights]}"
    ways = [partial(analytic_pca, surface, order=order, lights=lights) for order in ORDERS]
    ours = [best(way) for way in ways]  # first: threads of large products are awake for a while after them
    theirs, rendered = once(partial(empirical_pca, surface, lights=lights, pictures=pictures))
    for order, way, mine in zip(ORDERS, ways, ours, strict=True):
        found = way()
        known = (lights, name, order) == ("sphere", "LeePerrySmith", 4)
        yield record(
            f"first five variances, order {order}",
            size,
            mine,
            theirs,
            error=float(np.abs(found.variances / rendered.variances - 1).max()),
            unit=WORST,
            peer_error=0.0,
            question=f"first five variances, {size}",
            note=f"{shares(found)}; rendered {shares(rendered)}{'; ' + PUBLISHED if known else ''}",
        )


def shares(found: PrincipalComponents) -> str:
    """Return the shares of the total in words."""
    each = " ".join(f"{share:.3f}".lstrip("0") for share in found.explained)
    return f"{each}, {found.explained[:3].sum():.1%} in 3 and {found.explained.sum():.1%} in 5"


def routes(surface: hf.Surface, pictures: int) -> Iterator[Record]:
    """Compare the time with that of decomposing pictures that are rendered already, by the cheapest way and plainly."""
    ours = partial(analytic_pca, surface)
    found, mine = ours(), best(ours, 20)
    rendered = weighted_pictures(surface, pictures)
    whole, _ = once(partial(empirical_pca, surface, pictures=pictures))
    gram, svd_alone = partial(by_gram, rendered), partial(by_svd, rendered)
    ways = (
        ("the smaller Gram matrix", gram, best(Call(gram, by_gram), 3)),
        ("plain SVD", svd_alone, once(svd_alone)[0]),
    )
    exact = np.linalg.eigvalsh(rendered.astype(np.float64) @ rendered.T.astype(np.float64))[:-6:-1]
    told = (
        f"order 4; the peer's pictures are rendered before; rendering them and the first way take {whole.seconds:.2f} s"
    )
    for name, way, theirs in ways:
        yield record(
            f"five components, beside {name}",
            f"{len(rendered)} pictures {surface.shape[0]} x {surface.shape[1]}, {surface.mask.sum()} pixels",
            mine,
            theirs,
            error=float(np.abs(found.variances / exact - 1).max()),
            unit=WORST,
            peer_error=float(np.abs(way()[0] / exact - 1).max()) if way is gram else 0.0,
            bytes=25 * int(surface.mask.sum()) * 4,
            question="five components",
            note=told,
        )


def weighted_pictures(surface: hf.Surface, pictures: int) -> NDArray[np.float32]:
    """Return pictures under lamps all around, less their mean, times the roots of the quadrature weights, (n, p)."""
    lamps, weights = lamp_grid("sphere", pictures)
    seen = np.maximum(lamps.astype(np.float32) @ surface.pixel_normals.T, 0) * surface.pixel_albedo
    return np.asarray((seen - weights @ seen) * np.sqrt(weights)[:, None], np.float32)


def by_gram(rendered: NDArray[np.float32]) -> tuple[Array, Array]:
    """Return five variances and components by the products of all pictures with each other."""
    last = len(rendered) - 1
    values, vectors = eigh(rendered @ rendered.T, subset_by_index=(last - 4, last), check_finite=False)
    return values[::-1], (vectors[:, ::-1] / np.sqrt(values[::-1])).T @ rendered


def by_svd(rendered: NDArray[np.float32]) -> tuple[Array, Array]:
    """Return five variances and components by the singular value decomposition of all pictures."""
    _, values, rows = svd(rendered, full_matrices=False, check_finite=False)
    return values[:5] ** 2, rows[:5]


def yale_b(people: range) -> Record:
    """Tell how much of the energy of the photographs of a person so many dimensions hold, about 0."""
    spans = [explained_energy(person.photographs) for person in load_yale_b(DATA / "yaleb", people)]
    mean = np.mean(spans, axis=0)
    worst = np.min(spans, axis=0)
    means, least = (", ".join(f"{100 * part:.1f}" for part in parts) for parts in (mean, worst))
    call = partial(explained_energy, load_yale_b(DATA / "yaleb", people[:1])[0].photographs)
    return record(
        "photographed people, principal components about 0",
        f"Yale B, {len(spans)} people of 64 photographs 192 x 168",
        best(call, 3),
        error=float(1 - mean[-1]),
        unit="share of the energy outside of nine dimensions",
        note=f"% of the energy in {', '.join(map(str, DIMENSIONS))} dimensions: {means} on average, {least} at least",
    )


def explained_energy(photographs: NDArray[np.float32]) -> Array:
    """Return the share of the energy of photographs that their first dimensions hold."""
    rows = photographs.reshape(len(photographs), -1).astype(np.float64)
    values = np.linalg.eigvalsh(rows @ rows.T)[::-1]
    return np.asarray((values.cumsum() / values.sum())[np.array(DIMENSIONS) - 1])


if __name__ == "__main__":
    run_benchmark(__doc__, records, "pictures of 48 x 48, 400 lamps, two people", seed=0)
