"""Choosing the model: the cheapest linear model of a Surface's pictures that is as exact as asked, by prediction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.choose_candidates import Candidate, Cost, candidates, padded
from harmonicface.appearance.choose_error import ErrorTheory, PredictedError
from harmonicface.appearance.choose_images import images_of
from harmonicface.appearance.choose_lights import light_power
from harmonicface.appearance.principal_lights import Lights, light_statistics
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.materials import Material
from harmonicface.surfaces.surface import Surface

RESERVE = 1.01  # by how much a prediction may be too low, whatever the light


@dataclass(frozen=True, eq=False)
class ModelRow:
    """One line of the table: a candidate, its predicted error, its cost, and whether it meets the tolerance."""

    candidate: Candidate
    error: PredictedError
    cost: Cost
    meets: bool

    @property
    def name(self) -> str:
        """The candidate's name."""
        return self.candidate.name

    def __str__(self) -> str:
        error, cost = self.error, self.cost
        return (
            f"{self.name:<18} {100 * error.total:8.3g} {100 * error.missing:8.3g} {100 * error.noise:8.3g} "
            f"{error.condition:9.3g} {cost.rows:5d} {cost.bytes:10d} {cost.flops:10d}  {'yes' if self.meets else 'no'}"
        )


@dataclass(frozen=True, eq=False)
class ModelChoice:
    """The model that a scene needs, and the table behind it; printed, it shows the table.

    Parameters
    ----------
    chosen
        The cheapest row that meets the tolerance; where none does, the row of the smallest error.
    meets
        Whether the tolerance is met.
    tolerance
        What was asked for.
    table
        All candidates, cheapest first.
    """

    chosen: ModelRow
    meets: bool
    tolerance: float
    table: tuple[ModelRow, ...]

    @property
    def name(self) -> str:
        """The model's name, such as "pca5"."""
        return self.chosen.name

    @property
    def predicted_error(self) -> float:
        """Relative root mean square error over pixels and lights; see `choose_model`."""
        return self.chosen.error.total

    @property
    def cost(self) -> Cost:
        """Bytes of a Surface, flops of a query."""
        return self.chosen.cost

    @property
    def lights(self) -> NDArray[np.float64]:
        """Harmonic coefficients of the light of each picture, (k, n): what a photograph's combination says of light."""
        return self.chosen.candidate.lights

    def pictures(self, surface: Surface) -> Floats:
        """Return the images that span the model's pictures of a Surface, (k, p), a contiguous row each.

        Raises
        ------
        HarmonicFaceError
            A model with shadows, of a Surface with neither depth nor scene.
        """
        return self.chosen.candidate.pictures(surface)

    def row(self, name: str) -> ModelRow:
        """Return a candidate's line by its name.

        Raises
        ------
        HarmonicFaceError
            There is no such candidate.
        """
        for row in self.table:
            if row.name == name:
                return row
        raise HarmonicFaceError(f"name: expected one of {', '.join(row.name for row in self.table)}, got {name!r}")

    def __str__(self) -> str:
        verdict = (
            f"{self.name}: the cheapest that meets {100 * self.tolerance:.3g} %"
            if self.meets
            else f"nothing meets {100 * self.tolerance:.3g} %; the best is {self.name}"
        )
        heading = (
            f"{'model':<18} {'error %':>8} {'missing':>8} {'noise':>8} {'condition':>9} {'rows':>5} "
            f"{'bytes':>10} {'flops':>10}  meets"
        )
        return "\n".join([f"{verdict} ({100 * self.predicted_error:.3g} %)", heading, *map(str, self.table)])


def choose_model(
    surface: Surface,
    lights: Lights = "natural",
    tolerance: float = 0.01,
    noise: float = 0.0,
    *,
    shadows: bool | None = None,
    material: Material | None = None,
) -> ModelChoice:
    r"""Choose the cheapest linear model of a Surface's pictures that meets a tolerance, without rendering any.

    The error of a model is that of its least squares fit to a photograph y = B + noise, against the exact picture B,

    .. math:: \epsilon = \sqrt{ \left. \Big\langle \sum_x (\hat y(x) - B(x))^2 \Big\rangle \right/
              \Big\langle \sum_x B(x)^2 \Big\rangle }

    with the means over the distribution of lights (and over the noise): relative to the pictures' brightness, root mean
    square over pixels and lights. A tolerance is of that; under a single hard light a model may be worse, under a soft
    one better. It is predicted from the light's second moments and the Surface's images up to order 12, see
    `ErrorTheory`; on combinations of faces and lights that nothing was chosen on, predicted and measured errors agreed
    to a few percent (benchmarks/choose.py).

    Compared are: `linear3` (no shadows at all), `ambient4`, `harmonic9` (order 2), `harmonic25` and `harmonic49`
    (orders 4 and 6), with cast shadows `shadowed9`, `16`, `25` and `49`, and `pca1` to `pca25`, the analytic principal
    components about 0 of order 6. The principal components are the best there is for this distribution of lights, and
    for no other: under lights that were not thought of, the harmonics do better.

    Parameters
    ----------
    surface
        What is seen; its albedo as luminance.
    lights
        "natural", "sphere" (a lamp anywhere), "frontal" (a lamp in front), a Light such as an `EnvironmentMap` or
        several, a density of lamps (k,), a covariance (k, k) of harmonic coefficients: see `light_statistics`.
    tolerance
        The largest error, above 0: 0.01 is 1 %.
    noise
        Standard deviation of a pixel's noise over the root mean square brightness of pictures.
    shadows
        Whether pictures have cast shadows. By default they do where the Surface can tell them: with depth or a scene.
    material
        The coat that the Surface has; with it, candidates have gloss or do without.

    Returns
    -------
    ModelChoice
        Printed, it is a table. Where nothing meets the tolerance, `meets` is false and the model of least error is
        named.

    Raises
    ------
    HarmonicFaceError
        No Surface, lights that are none of these or do not reach the Surface, a tolerance not above 0, negative noise,
        shadows of a Surface with neither depth nor scene.

    Examples
    --------
    >>> import harmonicface as hf
    >>> face = hf.synthetic_person(0, size=48)
    >>> choice = choose_model(face, tolerance=0.1, shadows=False)
    >>> choice.meets, choice.pictures(face).shape[0] == choice.cost.rows
    (True, True)
    """
    if not isinstance(surface, Surface):
        raise HarmonicFaceError(f"surface: expected a Surface, got {_validate.describe(surface)}")
    wanted, spread = _validate.positive(tolerance, "tolerance"), _checked_noise(noise)
    if shadows not in (None, True, False):
        raise HarmonicFaceError(f"shadows: expected True, False or None, got {_validate.describe(shadows)}")
    if not (material is None or isinstance(material, Material)):
        raise HarmonicFaceError(f"material: expected Phong or Microfacet, got {_validate.describe(material)}")
    casting = surface.depth is not None or surface.scene is not None if shadows is None else bool(shadows)
    statistics = light_statistics(lights)
    theory = ErrorTheory(images_of(surface, casting, material), statistics, light_power(lights, statistics))
    table = []
    for each in candidates(theory, casting, material):
        error = theory.of_images(each.kind, padded(each.lights), spread)
        table.append(ModelRow(each, error, each.cost(error.rank, theory.pixels), error.most * RESERVE <= wanted))
    table.sort(key=lambda row: row.cost.order)
    meeting = [row for row in table if row.meets]
    chosen = meeting[0] if meeting else min(table, key=lambda row: row.error.total)
    return ModelChoice(chosen, bool(meeting), wanted, tuple(table))


def _checked_noise(noise: float) -> float:
    """Return a finite number of at least 0."""
    number = isinstance(noise, (int, float, np.integer, np.floating)) and not isinstance(noise, bool)
    if not (number and np.isfinite(noise) and noise >= 0):
        raise HarmonicFaceError(f"noise: expected a finite number of at least 0, got {_validate.describe(noise)}")
    return float(noise)
