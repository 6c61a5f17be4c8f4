"""Inverse lighting: the light's harmonic coefficients from one photograph of a known Surface, and what it hides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance._inverse_problem import BRIGHTEST, Solution, photographed, reduced, shown, solved
from harmonicface.appearance.light_modes import DROPPED, HIDDEN, NOISE, ODD, LightMode, simple_basis
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count
from harmonicface.lighting.light import HarmonicLight
from harmonicface.surfaces.surface import Surface


@dataclass(frozen=True, eq=False)
class LightEstimate:
    """The light of a photograph, how far each number is to be trusted, and which modes it does not tell.

    Of a colour photograph every array has a last axis of three channels.

    Parameters
    ----------
    coefficients
        ((order + 1)^2,) radiance coefficients L_lm; 0 for odd degrees above 1. Along the other modes in
        `unrecoverable` they are hardly a measurement: where the photograph tells nothing, and without a ridge where
        the error would exceed twice the ambient light, they are those of the smoothest light that explains the
        photograph, the least sum of (A_0 / |A_l|) L_lm^2 over l > 0.
    std
        Standard deviation of each coefficient that the photograph's noise causes; infinite where `recoverable` is
        false.
    systematic
        Root mean square error that light above the order and what the normals hide cause, if each mode of it is as
        strong as the ambient one: a scale, not a bound. On twelve faces without noise the errors' root mean square was
        0.25 of it under lamps and 0.13 under natural light, and at most 0.70; without a ridge 0.29 and 0.73, and 6 %
        of the coefficients under natural light exceeded it, up to 4.7 times.
    recoverable
        True where noise and systematic error together stay below half of the ambient light.
    singular_values
        Singular values of the normal equations, `B @ B.T` of the harmonic images of degrees 0, 1, 2, 4, 6 ... over
        the visible pixels, largest first.
    condition
        Largest over smallest of them (the worst channel); infinite if the visible normals do not span all modes.
    residual
        Root mean square of photograph minus fit over the pixels used.
    noise
        Standard deviation of a pixel: as given, or what the residual tells.
    unrecoverable
        The modes, single or combined, that the photograph does not tell to half of the ambient light, worst first
        (after the odd degrees), each with its reason.
    determined
        The modes that it does, best known first.
    pixels
        How many pixels were used.
    dropped
        With the model "auto", the modes that are not told from noise, of which there is nothing in the coefficients.
    """

    coefficients: Floats
    std: Floats
    systematic: Floats
    recoverable: NDArray[np.bool_]
    singular_values: Floats
    condition: float
    residual: Floats
    noise: Floats
    unrecoverable: tuple[LightMode, ...]
    determined: tuple[LightMode, ...]
    pixels: int
    dropped: tuple[LightMode, ...] = ()

    @property
    def light(self) -> HarmonicLight:
        """The estimate as a light."""
        return HarmonicLight(self.coefficients)


def estimate_light(
    photo: ArrayLike,
    surface: Surface,
    order: int = 2,
    *,
    mask: ArrayLike | None = None,
    noise: float | None = None,
    ridge: float | Literal["decay"] = "decay",
    saturation: float = np.inf,
    model: Literal["full", "auto"] = "full",
) -> LightEstimate:
    r"""Estimate the distant light of a photograph of a matte convex Surface.

    .. math:: \min_L \sum_x \Big( I(x) - \rho(x) \sum_{lm} A_l L_{lm} Y_{lm}(n(x)) \Big)^2
              + \lambda \sum_{0 < l \le order} \Big| \frac{A_0}{A_l} \Big| L_{lm}^2
              + \mu \sum_{l > order} L_{lm}^2

    (Ramamoorthi & Hanrahan, On the relationship between radiance and irradiance, 2001, equations 26 and 27, as least
    squares over the normals that are seen.) Degrees up to six above the order are fitted along, as strong as natural
    light makes them likely, and thrown away: on a half sphere harmonics are not orthogonal, and what is left out of
    the fit would pass for light of the order, which there costs several times more than the noise. Degrees 3, 5, 7
    ... have A_l = 0 and are named, not solved for; so are the modes that noise or the light above the order make
    useless, as light from behind a face. The paper says that E_4m is approximately 4 % of E_00, as it is: A_4 / A_0 is
    4.2 %; the "about 1 %" of the later chapter (Ramamoorthi, Modeling Illumination Variation with Spherical
    Harmonics, 2005) understates the filter.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities. Only pixels of both masks are read.
    surface
        Its normals and albedo. Cast shadows and interreflections are not modelled.
    order
        The highest degree l to estimate.
    mask
        (h, w) booleans, the pixels to use; all of the Surface by default.
    noise
        Standard deviation of a pixel, in the photograph's units. By default it is taken from what no light, up to six
        degrees above the order, explains.
    ridge
        "decay": lambda from the noise, as if the variance of L_lm were |A_l| / A_0 of the ambient light's square,
        which is close to what rooms and streets have. Relative errors of twelve faces under natural light, at the
        median: 0.12 without noise and 0.13 with 1 % (0.28 and 0.16 without a ridge); under a lamp 0.63 and 0.24 (0.38
        and 0.29). Where all normals are seen it changes nothing. 0: none. A positive number: lambda as a fraction of
        the ambient image's energy, heavier where the filter passes less. The modes without a trustworthy number are
        named all the same.
    saturation
        Pixels at or above it, in any channel, are left out.
    model
        "full": all modes of the order. "auto": those that an F-test tells from noise (see `determined_modes`), nothing
        of the rest. Median errors on six faces with 10 % noise, 60 pixels: under a lamp 0.39 instead of 0.49, without a
        ridge 0.43 instead of 0.59; under natural light 0.33 instead of 0.31, there the ridge knows better.

    Returns
    -------
    LightEstimate
        Coefficients, their errors and what cannot be told.

    Raises
    ------
    HarmonicFaceError
        A photo of another shape, NaN in the mask, no pixel left, no albedo, a bad setting, or as few pixels as
        modes without a `noise`.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (8, 8, 1)), np.ones((8, 8)))
    >>> estimate = estimate_light(np.ones((8, 8)), wall, order=1)
    >>> estimate.determined[0].name, [mode.name for mode in estimate.unrecoverable]
    ('0.65 L(0,0) + 0.76 L(1,0)', ['L(1,-1)', 'L(1,1)', '0.76 L(0,0) - 0.65 L(1,0)'])
    """
    size = count(order)
    strength = _checked_ridge(ridge)
    if model not in ("full", "auto"):
        raise HarmonicFaceError(f"model: expected 'full' or 'auto', got {_validate.describe(model)}")
    if noise is not None and not (_is_number(noise) and np.isfinite(noise) and noise >= 0):
        raise HarmonicFaceError(f"noise: expected a finite number of at least 0, got {_validate.describe(noise)}")
    pixels = photographed(photo, surface, mask, saturation, np.inf)
    unit = _power_of_two(pixels.intensities)
    # a coloured albedo: each channel its own equations
    parts = np.hsplit(pixels.intensities / unit, len(pixels.albedos))
    factors = [
        each
        for albedo, part in zip(pixels.albedos, parts, strict=True)
        for each in reduced(pixels.normals, albedo, part, order)
    ]
    spread = None if noise is None else noise / unit
    solutions = [solved(each, spread, strength, model == "auto") for each in factors]
    estimates = [_spread(solution, order, size) for solution in solutions]
    coefficients, std, systematic, recoverable = zip(*estimates, strict=True)
    return LightEstimate(
        coefficients=unit * _channels(coefficients),
        std=unit * _channels(std),
        systematic=unit * _channels(systematic),
        recoverable=_channels(recoverable),
        singular_values=_channels([each.singular_values for each in solutions]),
        condition=max(each.condition for each in solutions),
        residual=unit * _channels([each.residual for each in solutions]),
        noise=unit * _channels([each.noise for each in solutions]),
        unrecoverable=_lost(solutions, order, size),
        determined=_known(solutions, order, size),
        pixels=len(pixels.normals),
        dropped=tuple(_named([each.dropped for each in solutions], DROPPED, order, size)) if model == "auto" else (),
    )


def _channels(values: Sequence[ArrayLike]) -> NDArray[Any]:
    """Stack the channels along a last axis; of one channel there is none."""
    stacked = np.stack([np.asarray(value) for value in values], axis=-1)
    return stacked if len(values) > 1 else np.asarray(stacked[..., 0])


def _power_of_two(intensities: Floats) -> float:
    """Return what brings very bright photographs into a range whose squares are numbers; 1 for all others."""
    brightest = float(np.abs(intensities).max())
    return 2.0 ** np.floor(np.log2(brightest)) if brightest > BRIGHTEST else 1.0


def _spread(solution: Solution, order: int, size: int) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Put what was solved at its places among all coefficients."""
    places = shown(order)
    coefficients, recoverable = np.zeros(size), np.zeros(size, bool)
    std, systematic = np.full(size, np.inf), np.full(size, np.inf)
    coefficients[places], recoverable[places] = solution.values, solution.recoverable
    std[places] = np.where(solution.recoverable, solution.std, np.inf)
    systematic[places] = solution.systematic
    return coefficients, std, systematic, recoverable


def _lost(solutions: list[Solution], order: int, size: int) -> tuple[LightMode, ...]:
    """Name the odd degrees, and what the normals hide or the noise drowns."""
    odd = np.setdiff1d(np.arange(size), shown(order))
    modes = [LightMode(np.eye(size)[i], ODD) for i in odd]
    for directions, reason in (("hidden", HIDDEN), ("drowned", NOISE)):
        modes += _named([getattr(each, directions) for each in solutions], reason, order, size)
    return tuple(modes)


def _known(solutions: list[Solution], order: int, size: int) -> tuple[LightMode, ...]:
    """Name what the photograph determines."""
    return tuple(_named([each.kept for each in solutions], "determined", order, size))


def _named(spaces: list[NDArray[np.float64]], reason: str, order: int, size: int) -> list[LightMode]:
    """Name a space of each channel, once if it is the same in all."""
    same = all(np.allclose(space.T @ space, spaces[0].T @ spaces[0]) for space in spaces)
    places, modes = shown(order), []
    for channel, space in enumerate(spaces[:1] if same else spaces):
        for row in simple_basis(space):
            direction = np.zeros(size)
            direction[places] = row
            modes.append(LightMode(direction, reason, None if same else channel))
    return modes


def _checked_ridge(ridge: float | str) -> float | None:
    """Return the ridge's strength; None lets the noise choose it."""
    if isinstance(ridge, str) and ridge == "decay":
        return None
    if isinstance(ridge, str) or not (_is_number(ridge) and np.isfinite(ridge) and ridge >= 0):
        raise HarmonicFaceError(f"ridge: expected 'decay' or a finite number of at least 0, got {ridge!r}")
    return float(ridge)


def _is_number(value: object) -> bool:
    """Tell a real number from everything else."""
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
