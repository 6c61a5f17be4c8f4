"""Hard cases for photometric stereo: photographs of a shape that is known, each with one difficulty."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, shift

from harmonicface._validate import Floats
from harmonicface.bench.stability.hard_surfaces import nine_images

SIDE = 40
COUNT = 20
NOISE = 0.003  # of full scale
WIDEST = 50.0  # degrees from the camera's axis
DUSK = 0.02  # of full scale: what is thrown back into shadows

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class HardCase:
    """Photographs with a difficulty, and what is true of them.

    Parameters
    ----------
    name
        The difficulty.
    images
        (n, h, w) linear intensities.
    lights
        (n, 3) unit directions to the lamps, or (n, 9) harmonic coefficients.
    normals
        (p, 3) of the masked pixels; NaN where the photographs tell none.
    mask
        (h, w) booleans.
    known
        Options of `photometric_stereo` where the lights are told; None: that is not asked.
    unknown
        Options where they are not; None: that is not asked.
    quick
        Whether unknown lamps are asked for in a quick table too.
    """

    name: str
    images: Floats
    lights: Floats
    normals: Floats
    mask: Mask
    known: dict[str, Any] | None = field(default_factory=dict)
    unknown: dict[str, Any] | None = field(default_factory=dict)
    quick: bool = True


def lamps(count: int = COUNT, widest: float = WIDEST, seed: int = 0) -> Floats:
    """Return unit directions within so many degrees of the camera's axis, (n, 3).

    Examples
    --------
    >>> bool((lamps(9, 30)[:, 2] >= np.cos(np.radians(30))).all())
    True
    """
    random = np.random.default_rng(seed)
    heights = random.uniform(np.cos(np.radians(widest)), 1, count)
    around = random.uniform(0, 2 * np.pi, count)
    aside = np.sqrt(1 - heights**2)
    return np.stack([aside * np.cos(around), aside * np.sin(around), heights], axis=1)


def bumpy_ball(side: int = SIDE, seed: int = 0) -> tuple[Floats, Mask]:
    """Return the normals (p, 3) of a cap of a ball with bumps, and where it is, (side, side).

    Examples
    --------
    >>> normals, inside = bumpy_ball(20)
    >>> normals.shape == (inside.sum(), 3)
    True
    """
    y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : side * 1j]
    inside = x**2 + y**2 < 0.9**2
    bumps = gaussian_filter(np.random.default_rng(seed).normal(size=(side, side)), side / 14)
    depth = np.sqrt(np.maximum(1.05 - x**2 - y**2, 0.01)) + 0.03 * bumps / bumps.std()
    down, right = np.gradient(depth, 2 / (side - 1))
    normals = np.stack([-right, down, np.ones_like(depth)], axis=2)[inside]
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), inside


def hard_cases(side: int = SIDE) -> list[HardCase]:
    """Return all cases.

    Parameters
    ----------
    side
        Of the photographs, in pixels.

    Examples
    --------
    >>> cases = hard_cases(24)
    >>> cases[0].name, cases[0].images.shape
    ('nothing hard', (20, 24, 24))
    """
    usual = photographed(*bumpy_ball(side))
    groups = (_of_lamps, _of_shade, _of_shape, _of_numbers, _of_brightness, _of_strangers, _of_skies)
    return [usual, *(case for group in groups for case in group(usual))]


def photographed(
    normals: Floats, mask: Mask, lights: Floats | None = None, name: str = "nothing hard", noise: float = NOISE
) -> HardCase:
    """Return photographs of a matte thing of two greys under distant lamps of brightness 1, with noise."""
    lights = lamps() if lights is None else lights
    seen = _greys(mask)[mask] * np.maximum(lights @ normals.T, 0)
    seen += noise * np.random.default_rng(1).normal(size=seen.shape)
    return HardCase(name, _on_grid(np.clip(seen, 0, None), mask), lights, normals, mask)


def _greys(mask: Mask) -> Floats:
    rows, columns = np.indices(mask.shape) / len(mask)
    return np.asarray(np.where((rows + columns) % 0.5 < 0.25, 0.75, 0.55))


def _on_grid(seen: Floats, mask: Mask) -> Floats:
    images = np.zeros((len(seen), *mask.shape))
    images[:, mask] = seen
    return images


def _of_lamps(usual: HardCase) -> Iterator[HardCase]:
    """Yield too few lamps, and lamps that do not span space, or hardly."""
    shape = usual.normals, usual.mask
    yield replace(usual, name="two images only", images=usual.images[:2], lights=usual.lights[:2])
    yield replace(usual, name="three images", images=usual.images[:3], lights=usual.lights[:3])
    yield replace(usual, name="four images", images=usual.images[:4], lights=usual.lights[:4])
    across = np.radians(np.linspace(-WIDEST, WIDEST, COUNT))
    row = np.stack([np.sin(across), 0 * across, np.cos(across)], axis=1)
    yield photographed(*shape, row, "all lamps in a plane with the camera")
    wobbly = row + 0.01 * np.random.default_rng(2).normal(size=row.shape)
    wobbly /= np.linalg.norm(wobbly, axis=1, keepdims=True)
    yield photographed(*shape, wobbly, "all lamps within a degree of a plane")
    around = np.linspace(0, 2 * np.pi, COUNT, endpoint=False)
    cone = np.stack([0.6 * np.cos(around), 0.6 * np.sin(around), np.full(COUNT, 0.8)], axis=1)
    yield photographed(*shape, cone, "all lamps on a cone")
    yield photographed(*shape, np.repeat(usual.lights[:1], COUNT, axis=0), "one lamp for all photographs")
    often = usual.lights.copy()
    often[10:] = often[0]
    yield photographed(*shape, often, "one lamp for half of the photographs")
    yield photographed(*shape, lamps(widest=5), "lamps within 5 degrees")
    twice = np.arange(COUNT) // 2
    yield replace(
        usual, name="every photograph twice", images=usual.images[twice], lights=usual.lights[twice], quick=False
    )


def _of_shade(usual: HardCase) -> Iterator[HardCase]:
    """Yield shadows and highlights."""
    normals, mask = usual.normals, usual.mask
    yield photographed(normals, mask, lamps(widest=25), "no shadows at all")
    rows, columns = np.indices(mask.shape) / len(mask) - 0.5
    random = np.random.default_rng(3)
    angles = random.uniform(0, 2 * np.pi, COUNT)[:, None, None]
    hidden = np.cos(angles) * rows + np.sin(angles) * columns > random.uniform(-0.05, 0.05, COUNT)[:, None, None]
    dusk = DUSK + NOISE * random.normal(size=usual.images.shape)
    yield replace(
        usual, name="half the pixels in cast shadow", images=np.where(hidden, np.clip(dusk, 0, None), usual.images)
    )
    halves = usual.lights + np.array([0, 0, 1])
    halves /= np.linalg.norm(halves, axis=1, keepdims=True)
    for sharp, name in ((60, "saturated highlights"), (10, "broad saturated highlights")):
        gloss = 1.5 * np.maximum(halves @ normals.T, 0) ** sharp * (usual.lights @ normals.T > 0)
        yield replace(usual, name=name, images=np.minimum(usual.images + _on_grid(gloss, mask), 1))


def _of_shape(usual: HardCase) -> Iterator[HardCase]:
    """Yield a plane, few pixels, black pixels, and what is outside."""
    normals, mask = usual.normals, usual.mask
    flat = np.array([0.3, 0.2, 0.9]) / np.linalg.norm([0.3, 0.2, 0.9])
    yield photographed(np.tile(flat, (len(normals), 1)), mask, name="a planar object")
    few = np.zeros_like(mask)
    few[len(mask) // 2 - 1 : len(mask) // 2 + 2, len(mask) // 2 - 1 : len(mask) // 2 + 2] = True
    yield replace(usual, name="a mask of 9 pixels", mask=few, normals=normals[few[mask]])
    rows = np.indices(mask.shape)[0]
    columns = np.indices(mask.shape)[1]
    patch = max(len(mask) // 6, 1)
    black = (rows // patch % 2 == 0) & (columns // patch % 2 == 0)
    dust = np.abs(NOISE * np.random.default_rng(4).normal(size=usual.images.shape))
    clean = np.where(black, dust, usual.images)
    lit = ~black[mask]
    yield replace(
        usual, name="black patches, with noise", images=clean, normals=np.where(lit[:, None], normals, np.nan)
    )
    exact = np.where(black, 0.0, usual.images)
    yield replace(
        usual, name="black patches, without noise", images=exact, normals=np.where(lit[:, None], normals, np.nan)
    )
    yield replace(usual, name="NaN outside the mask", images=np.where(mask, usual.images, np.nan), quick=False)
    hole = np.where(rows == len(mask) // 2, np.nan, usual.images)
    yield replace(usual, name="NaN inside the mask", images=hole)


def _of_numbers(usual: HardCase) -> Iterator[HardCase]:
    """Yield other scales and types."""
    for bits in (16, 8):
        levels = 2**bits - 1
        yield replace(usual, name=f"{bits} bits", images=np.round(usual.images * levels) / levels, quick=False)
    dark = np.round(usual.images / 20 * 255) / 255
    yield replace(usual, name="8 bits, a twentieth of the range", images=dark)
    free = {"saturation": np.inf}
    for factor in (1e-12, 1e12):
        yield replace(
            usual, name=f"times {factor:g}", images=factor * usual.images, known=free, unknown=free, quick=False
        )
    yield replace(usual, name="float32", images=usual.images.astype(np.float32))
    same = np.full_like(usual.images, 0.5)
    nowhere = np.full_like(usual.normals, np.nan)
    yield replace(usual, name="constant images", images=same, normals=nowhere)
    yield replace(usual, name="black images", images=0 * same, normals=nowhere)
    noise = np.random.default_rng(5).uniform(0, 1, same.shape)
    yield replace(usual, name="nothing but noise", images=noise, normals=nowhere)
    yield replace(usual, name="one black image", images=np.where(np.arange(COUNT)[:, None, None] == 4, 0, usual.images))


def _of_brightness(usual: HardCase) -> Iterator[HardCase]:
    """Yield lamps as unlike as 1 : 100."""
    brightness = np.exp(np.random.default_rng(6).permutation(np.linspace(np.log(0.01), 0, COUNT)))
    exact = photographed(usual.normals, usual.mask, noise=0).images * brightness[:, None, None]
    noise = 0.1 * NOISE * np.random.default_rng(7).normal(size=exact.shape)
    images = np.clip(exact + noise, 0, None) * usual.mask
    name = "lamps of 1 : 100"
    told = {"intensities": brightness}
    yield replace(usual, name=f"{name}, told", images=images, known=told, unknown=told)
    yield replace(usual, name=f"{name}, not told", images=images, known={"intensities": "unknown"})
    yield replace(usual, name=f"{name}, said to be equal", images=images, unknown={"intensities": np.ones(COUNT)})
    one = {"intensities": np.ones(COUNT)}
    yield replace(usual, name="equal lamps, told", known=None, unknown=one)


def _of_strangers(usual: HardCase) -> Iterator[HardCase]:
    """Yield photographs that do not belong, or are not where they should be."""
    normals, mask = bumpy_ball(len(usual.mask), seed=8)
    other = photographed(normals[::-1] * [1, -1, 1], mask).images
    foreign = usual.images.copy()
    foreign[7] = np.roll(other[3], 5, axis=1)
    one = {"intensities": np.ones(COUNT)}
    yield replace(usual, name="one image of another scene", images=foreign)
    yield replace(usual, name="one image of another scene, equal lamps told", images=foreign, known=None, unknown=one)
    random = np.random.default_rng(9)
    larger = np.pad(usual.images, ((0, 0), (4, 4), (4, 4)), mode="edge")
    moved = np.stack([shift(image, random.uniform(-1, 1, 2), order=1) for image in larger])[:, 4:-4, 4:-4]
    yield replace(usual, name="not registered by up to 1 pixel", images=moved)
    one_off = usual.images.copy()
    one_off[5] = np.roll(one_off[5], 1, axis=1)
    yield replace(usual, name="one image moved by 1 pixel", images=one_off, quick=False)
    wrong = usual.lights.copy()
    wrong[3] = wrong[3] * [-1, -1, 1]
    yield replace(usual, name="one direction wrong", lights=wrong, unknown=None)
    yield replace(usual, name="left and right confused in all", lights=usual.lights * [-1, 1, 1], unknown=None)


def _of_skies(usual: HardCase) -> Iterator[HardCase]:
    """Yield light from everywhere, told as nine harmonic coefficients."""
    random = np.random.default_rng(10)
    lights = np.hstack([np.ones((COUNT, 1)), 0.35 * random.normal(size=(COUNT, 8)) / np.repeat([1, 2], [3, 5])])
    lights[:, 2] += 0.4
    seen = 0.3 * lights @ nine_images(usual.normals) * _greys(usual.mask)[usual.mask]
    images = _on_grid(np.clip(seen + NOISE * random.normal(size=seen.shape), 0, None), usual.mask)
    sky = replace(usual, lights=lights, images=images, unknown={"model": "harmonic9"})
    yield replace(sky, name="skies")
    yield replace(sky, name="skies: two images only", images=images[:2], lights=lights[:2])
    yield replace(sky, name="skies: four images", images=images[:4], lights=lights[:4], unknown=None)
    yield replace(
        sky,
        name="skies: one for all photographs",
        images=images[:1].repeat(COUNT, 0),
        lights=lights[:1].repeat(COUNT, 0),
    )
    foreign = images.copy()
    foreign[7] = usual.images[3]
    yield replace(sky, name="skies: one image of another scene", images=foreign)
