"""How fast and how wrong is reflected light from coefficients? Beside the integral over the half sphere of lights.

    python benchmarks/brdf.py [--quick] [--json FILE]

The light is a lamp of 12 degrees, a window and a sky: three decades of radiance. Errors are relative L2 of
B cos(theta_o) over normals in all directions and outgoing angles up to 70 degrees, against an integral on a finer grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, best, record
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.brdf import Microfacet, Phong, Ward
from harmonicface.reflectance.brdf_coefficients import anisotropic_coefficients, isotropic_coefficients
from harmonicface.reflectance.evaluation import evaluate, evaluate_under_lamp
from harmonicface.reflectance.factorization import factor_light_field
from harmonicface.reflectance.lightfield import light_field

STEEPEST = math.radians(70)
TURN = 0.4  # of the tangent of the anisotropic material
TARGET = 1e-2  # what is asked of either side
UNIT = "relative L2 to 70 degrees"
GRIDS = (6, 8, 10, 12, 16, 20, 24, 32)  # polar angles of the integral
FINEST = 72
ORDERS = (4, 6, 8, 10, 12, 16, 20, 24, 32)
MATERIALS = {
    "Phong 20": (Phong(20), ORDERS),
    "microfacet 0.3": (Microfacet(0.3), ORDERS),
    "Ward 0.3 x 0.6": (Ward(0.3, 0.6), ORDERS[:8]),
}


def radiance(points: np.ndarray) -> np.ndarray:
    """Return the radiance of lamp, window and sky."""
    lamp, window = np.array([0.6, 0.3, math.sqrt(0.55)]), np.array([-0.48, -0.6, 0.64])
    return 20 * np.exp(45 * (points @ lamp - 1)) + 2 * np.exp(6 * (points @ window - 1)) + 0.1


def sphere(nodes: int, lowest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return directions and weights of Gauss nodes in z from the lowest to 1 and even azimuths."""
    at, weights = np.polynomial.legendre.leggauss(nodes)
    z, weights = lowest + (1 - lowest) / 2 * (at + 1), (1 - lowest) / 2 * weights
    z, phi = np.meshgrid(z, np.arange(2 * nodes) * math.pi / nodes, indexing="ij")
    points = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1)
    return points.reshape(-1, 3), np.repeat(weights * math.pi / nodes, 2 * nodes)


def integral(brdf: Callable, normals: np.ndarray, outgoing: np.ndarray, nodes: int) -> np.ndarray:
    """Integrate at every normal for all outgoing directions: one table of the BRDF, one matrix product."""
    incoming, weights = sphere(nodes, 0.0)
    kernel = brdf(incoming[:, None], outgoing) * (weights * incoming[:, 2])[:, None] * outgoing[:, 2]
    alpha, beta = np.arccos(normals[:, 2]), np.arctan2(normals[:, 1], normals[:, 0])
    frames = Rotation.from_euler("ZYZ", np.stack([beta, alpha, np.full_like(alpha, TURN)], axis=-1)).as_matrix()
    return np.stack([radiance(incoming @ frame.T) for frame in frames]) @ kernel


def scene(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return normals in all directions and as many outgoing ones up to 70 degrees."""
    rng = np.random.default_rng(0)

    def random(lowest: float) -> np.ndarray:
        z, phi = rng.uniform(lowest, 1, count), rng.uniform(0, 2 * math.pi, count)
        return np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1)

    return random(-1.0), random(math.cos(STEEPEST))


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    """Return the relative L2 error."""
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def materials(count: int) -> list[Record]:
    """Evaluate each material to each order at `count` normals times `count` directions."""
    normals, outgoing = scene(count)
    top = max(ORDERS)
    points, weights = sphere(top + 40, -1.0)
    light = (real_harmonics(points, top) * weights) @ radiance(points)
    found = []
    for name, (brdf, orders) in MATERIALS.items():
        expand = anisotropic_coefficients if isinstance(brdf, Ward) else isotropic_coefficients
        table = expand(brdf, max(orders))
        expanding = best(partial(expand, brdf, 12), 1).seconds
        expected = integral(brdf, normals, outgoing, FINEST)
        errors = {nodes: relative(integral(brdf, normals, outgoing, nodes), expected) for nodes in GRIDS}
        nodes = next(nodes for nodes in GRIDS if errors[nodes] <= TARGET)
        about = f"over {nodes} x {2 * nodes} incoming directions as one matrix product"
        peer = best(Call(partial(integral, brdf, normals, outgoing, nodes), about=about), 3)
        for order in orders:
            kept = (order + 1) ** 2
            part = table[:kept, :kept] if table.ndim == 2 else table[: order + 1, : order + 1, : order + 1]

            def run(part=part, kept=kept, extension="zero") -> np.ndarray:
                return evaluate(light[:kept], part, normals[:, None], outgoing[None], TURN, extension)

            even = relative(run(extension="even"), expected)
            found.append(
                record(
                    f"reflected light, {name}, order {order}",
                    f"{count} normals x {count} directions",
                    best(Call(run, evaluate), 3),
                    peer,
                    error=relative(run(), expected),
                    peer_error=errors[nodes],
                    unit=UNIT,
                    bytes=part.nbytes,
                    question=f"reflected light, {name}",
                    note=f"{even:.2g} if continued evenly below the horizon; the peer is the coarsest under {TARGET}; "
                    f"coefficients to order 12 take {expanding:.2f} s once",
                )
            )
    return found


def lamps(count: int) -> list[Record]:
    """Evaluate each material under a lamp without size, where no coefficient of the light decays."""
    normals, outgoing = scene(count)
    lamp = np.array([0.48, 0.64, 0.6])
    alpha, beta = np.arccos(normals[:, 2]), np.arctan2(normals[:, 1], normals[:, 0])
    frames = Rotation.from_euler("ZYZ", np.stack([beta, alpha, np.full_like(alpha, TURN)], axis=-1)).as_matrix()
    incoming = np.einsum("nji,j->ni", frames, lamp)[:, None]
    found = []
    for name, (brdf, orders) in MATERIALS.items():
        order = min(max(orders), 24)
        table = (anisotropic_coefficients if isinstance(brdf, Ward) else isotropic_coefficients)(brdf, order)
        light = real_harmonics(lamp, order)

        def exact(brdf=brdf) -> np.ndarray:
            return brdf(incoming, outgoing) * np.maximum(incoming[..., 2], 0) * outgoing[:, 2]

        def run(table=table, extension="even") -> np.ndarray:
            return evaluate_under_lamp(lamp, table, normals[:, None], outgoing[None], TURN, extension)

        expected = exact()
        plain = relative(evaluate(light, table, normals[:, None], outgoing[None], TURN), expected)
        odd = relative(run(extension="odd"), expected)
        found.append(
            record(
                f"light of a lamp, {name}",
                f"order {order}, {count} normals x {count} directions",
                best(Call(run, evaluate_under_lamp), 3),
                best(Call(exact, brdf.__call__, about="in closed form"), 3),
                error=relative(run(), expected),
                peer_error=0.0,
                unit=UNIT,
                bytes=table.nbytes,
                question="light of a lamp",
                note=f"{odd:.2g} if continued oddly, {plain:.2g} by the lamp's coefficients",
            )
        )
    return found


def factorizations() -> list[Record]:
    """Factor light fields of known light and BRDF."""
    found = []
    for order in (8, 16, 24):
        rng = np.random.default_rng(order)
        light = rng.normal(size=(order + 1) ** 2) / (1 + degrees(order))
        light[0] = 3.0
        table = isotropic_coefficients(Microfacet(0.3), order)
        field = light_field(light, table)
        result = factor_light_field(field)
        scale = light[0] / result.light[0]
        worst = max(relative(scale * result.light, light), relative(result.brdf / scale, table))
        found.append(
            record(
                "factor a light field into light and BRDF",
                f"order {order}",
                best(partial(factor_light_field, field), 3),
                best(Call(partial(light_field, light, table), about="making what is factored"), 3),
                error=worst,
                unit="relative L2 of light or BRDF, the larger",
                bytes=field.nbytes,
                seed=order,
                question="factor a light field",
                note="after one common scale",
            )
        )
    return found


def records(quick: bool) -> Iterator[Record]:
    """Yield materials, lamps, factorizations."""
    count = 200 if quick else 600
    yield from materials(count)
    yield from lamps(count)
    yield from factorizations()


if __name__ == "__main__":
    run_benchmark(__doc__, records, "200 x 200 instead of 600 x 600", seed=0)
