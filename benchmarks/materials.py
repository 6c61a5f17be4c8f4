"""Tell how exact the filters of materials are, and how surely a reflection shows how shiny or rough a surface is.

python benchmarks/materials.py [--quick] [--json FILE]
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import least_squares
from scipy.special import eval_legendre, gammaln, gammasgn

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, best, record
from harmonicface.harmonics.quadrature import project, sphere_grid
from harmonicface.reflectance.lobe_fit import LobeFit, fit_roughness, fit_shininess
from harmonicface.reflectance.microfacet import microfacet_filter, microfacet_gaussian
from harmonicface.reflectance.phong import phong_filter, phong_gaussian
from harmonicface.reflectance.spectra import apply_filter, directional_spectrum

Array = NDArray[np.float64]
FIT_ORDER = 12
NOISE = 0.01  # of the reflection's degree 0, in each coefficient


def filter_records(quick: bool) -> Iterator[Record]:
    """Compare filters with exact arithmetic, with adaptive quadrature and with Gaussians in their place."""
    yield _phong(1000)
    yield _microfacet(60 if quick else 200)
    for shininess in (10, 50, 200):
        yield from _gaussians(f"Phong {shininess}", shininess, phong_filter, phong_gaussian)
    for roughness in (0.1, 0.2, 0.3):
        yield from _gaussians(f"microfacet {roughness}", roughness, microfacet_filter, microfacet_gaussian)


def _phong(order: int) -> Record:
    exponent = Fraction(101, 2)
    exact = [Fraction(1), (exponent + 1) / (exponent + 2)]
    for degree in range(2, order + 1):
        exact.append(exact[-2] * (exponent - degree + 2) / (exponent + degree + 1))
    truth = np.array([float(value) for value in exact])
    degree, s = np.arange(order + 1), float(exponent)

    def closed() -> Array:
        first = 1 + (s - degree) / 2
        logarithm = gammaln(1 + s) - gammaln(first) - gammaln((degree + s + 3) / 2) - (s + 1) * np.log(2)
        return np.asarray((s + 1) * np.sqrt(np.pi) * gammasgn(first) * np.exp(logarithm))

    def worst(values: Array) -> float:
        return float(np.abs(values / truth - 1).max())

    return record(
        "Phong filter of a broken exponent",
        f"s = {s}, degrees 0 to {order}",
        best(partial(phong_filter, s, order)),
        best(Call(closed, about="in which scipy's logarithms of gamma functions are added up")),
        error=worst(phong_filter(s, order)),
        peer_error=worst(closed()),
        unit="relative to exact fractions, the largest",
        question="Phong filter of a broken exponent",
    )


def _microfacet(order: int) -> Record:
    sigma = 0.3

    def adaptive() -> Array:
        def integrand(angle: float, degree: int) -> float:
            return float(np.exp(-(angle**2) / (4 * sigma**2)) * eval_legendre(degree, np.cos(angle)) * np.sin(angle))

        values = [quad(integrand, 0, np.pi / 2, (d,), epsabs=1e-13, limit=500)[0] for d in range(order + 1)]
        return np.array(values) / (2 * sigma**2)

    return record(
        "microfacet filter",
        f"sigma = {sigma}, degrees 0 to {order}",
        best(partial(microfacet_filter, sigma, order)),
        best(Call(adaptive, quad, about="degree by degree"), 1),
        error=float(np.abs(microfacet_filter(sigma, order) - adaptive()).max()),
        peer_error=1e-13,
        unit="of a filter that begins at 1, the largest",
        question="microfacet filter",
        note="error: the largest difference from the peer, whose own bound is 1e-13",
    )


def _gaussians(
    name: str, width: float, exact: Callable[[float, int], Array], gaussian: Callable[..., Array]
) -> Iterator[Record]:
    truth = exact(width, 100)
    for form in ("paper", "linear", "matched"):
        yield record(
            f"{form} Gaussian for {name}",
            "degrees 0 to 100",
            best(partial(gaussian, width, 100, form)),
            best(Call(partial(exact, width, 100), about="the exact filter")),
            error=float(np.abs(gaussian(width, 100, form) - truth).max()),
            peer_error=0.0,
            unit="of a filter that begins at 1, the largest",
            question="Gaussians in place of filters",
        )


def fit_records(quick: bool) -> Iterator[Record]:
    """Recover shininess and roughness under a lamp and under a cloudy sky of the same brightness."""
    runs = 40 if quick else 200
    lights = {"one lamp": directional_spectrum([1, 2, 2], FIT_ORDER), "a cloudy sky": cloudy_sky(FIT_ORDER)}
    for where, light in lights.items():
        yield _fits(f"shininess under {where}", fit_shininess, phong_filter, 50.0, light, runs)
        yield _fits(f"roughness under {where}", fit_roughness, microfacet_filter, 0.1, light, runs)


def cloudy_sky(order: int) -> Array:
    """Return the standard overcast sky, (1 + 2 cos) / 3 above the horizon, of the total of a unit lamp."""
    fine = sphere_grid(400)  # the horizon is a jump: a fine grid keeps what aliases below the noise
    light = project(lambda n: np.where(n[:, 2] > 0, (1 + 2 * n[:, 2]) / 3, 0), order, fine)
    return light / light[0] / np.sqrt(4 * np.pi)


def _fits(
    name: str,
    fit: Callable[[Array, Array, float], LobeFit],
    filter_: Callable[[float, int], Array],
    width: float,
    light: Array,
    runs: int,
) -> Record:
    rng = np.random.default_rng(0)
    exact = apply_filter(filter_(width, FIT_ORDER), light)
    noise = NOISE * exact[0]
    seen = [exact + noise * rng.normal(size=exact.shape) for _ in range(runs)]

    def peer(reflected: Array) -> float:
        start = np.log(width * 2)  # twice the right answer: nearer than anyone could know

        def rest(logarithm: Array) -> Array:
            return apply_filter(filter_(float(np.exp(logarithm[0])), FIT_ORDER), light) - reflected

        return float(np.exp(least_squares(rest, [start], x_scale=0.1).x[0]))

    answers = [fit(reflected, light, noise) for reflected in seen]
    errors = [abs(answer.value / width - 1) for answer in answers]
    theirs = [abs(peer(reflected) / width - 1) for reflected in seen]
    covered = np.mean([answer.low <= width <= answer.high for answer in answers])
    reported = 100 * np.median([answer.std / answer.value for answer in answers])
    return record(
        name,
        f"{width:g}, order {FIT_ORDER}, noise {100 * NOISE:g} % of degree 0",
        best(partial(fit, seen[0], light, noise)),
        best(Call(partial(peer, seen[0]), least_squares, about="from twice the answer, which gives no interval")),
        error=100 * float(np.median(errors)),
        peer_error=100 * float(np.median(theirs)),
        unit="% of the width, the median",
        question="widths of lobes",
        note=(
            f"of {runs} noisy reflections 95 of 100 below {100 * np.quantile(errors, 0.95):.3g} %; "
            f"reported deviation {reported:.3g} %, 95 % interval covers {100 * covered:.1f} %, noise amplified "
            f"{np.median([answer.gain for answer in answers]):.3g} times"
        ),
    )


def records(quick: bool) -> Iterator[Record]:
    """Yield filters, then fits."""
    yield from filter_records(quick)
    yield from fit_records(quick)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "fewer degrees and fewer noisy reflections", seed=0)
