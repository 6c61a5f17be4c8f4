"""The mean face: its relief by a small table, and where it lies in photographs, whatever their light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import map_coordinates
from scipy.optimize import minimize

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

STEP = 7.0  # mm between the numbers of the table
TOP, LEFT = 56.0, -77.0  # mm: its first row and column, the eyes at (+-31, -1), the mouth at (0, -70)
RELIEF = """
-629 -460 -288 -155  -55   21   81  124  154  172  182  185
-585 -378 -224  -99   -8   62  116  155  181  197  205  207
-532 -330 -184  -62   26   92  143  180  205  220  227  229
-495 -305 -160  -36   52  118  169  206  231  244  250  252
-482 -292 -143  -13   81  148  196  231  253  265  269  270
-484 -285 -127   15  115  174  210  238  259  271  276  277
-492 -280 -112   36  126  168  190  208  228  249  265  271
-500 -276 -106   28  101  145  166  168  171  197  240  265
-500 -269 -111   -2   64  113  139  139  131  160  232  280
-492 -253 -106  -15   50  110  142  146  141  175  270  328
-483 -232  -83    6   65  112  140  152  165  224  329  381
-488 -219  -58   35   91  126  149  167  197  271  388  434
-516 -227  -50   51  108  142  166  189  222  317  447  484
-568 -265  -62   48  112  154  182  205  237  371  462  496
   . -333  -90   33  106  158  192  212  238  324  371  439
   . -417 -129   11   94  154  193  219  250  295  344  364
   .    . -183  -15   78  145  192  233  276  322  359  366
   .    . -244  -46   57  133  192  242  291  339  370  381
   .    .    .  -85   34  120  184  226  261  310  341  351
   .    .    . -139    5  100  165  208  259  318  352  359
   .    .    .    .  -38   70  143  197  248  291  314  319
   .    .    .    . -113   28  115  178  230  268  290  298
   .    .    .    .    .  -49   75  159  223  268  296  304
   .    .    .    .    .    .  -10  116  201  256  284  291
   .    .    .    .    .    .    .    .  113  187  223  233
"""  # tenths of mm toward the camera, from the right side of the face to its middle; a dot is outside

FITTING = 0.25  # of the mean face's shading that the photographs' factors may leave: a ball leaves more
LEAST_SEEN = 0.3  # of the photographs' pixels on the face

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]
Integers = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class FacePlace:
    """Where the mean face lies in a picture.

    Parameters
    ----------
    scale
        Millimetres a pixel.
    column, row
        The pixel of the face's origin, between the eyes.
    misfit
        Share of the mean face's shading that no light on the photographed surface gives, 0 to 1.
    """

    scale: float
    column: float
    row: float
    misfit: float


def mean_face_normals(mask: Mask, place: FacePlace) -> tuple[Doubles, Mask]:
    """Return the normals of the mean face at the masked pixels, and which of them it covers.

    Parameters
    ----------
    mask
        (h, w) booleans.
    place
        Where the face lies.

    Returns
    -------
    normals
        (p, 3) unit vectors; (0, 0, 1) where the face does not reach.
    known
        (p,) booleans.
    """
    rows, columns = np.nonzero(mask)
    return _normals(rows, columns, place.scale, place.column, place.row)


def place_mean_face(right: Floats, tone: Floats, mask: Mask) -> FacePlace:
    r"""Find scale and place of the mean face in photographs of a face from the front, whatever their light.

    The shadings of the mean face, x, y and z of its normals times how bright the photographs are at a pixel, should lie
    in the space of the photographs' factors. What of them lies outside is least at the right place; it depends on
    the lights as little as the space does (a canonical correlation, as Jacobs, Belhumeur & Basri 1998 compare images).

    Parameters
    ----------
    right
        (k, p) factors of the photographs, k of at least 4.
    tone
        (p,) mean of the photographs, the stand-in for albedo.
    mask
        (h, w) booleans with p pixels.

    Raises
    ------
    HarmonicFaceError
        Nothing there that resembles a face.
    """
    rows, columns = np.nonzero(mask)
    thin = max(1, round(np.sqrt(len(rows) / 600)))
    some = (rows % thin == 0) & (columns % thin == 0)
    rows, columns, factors, light = rows[some], columns[some], right[:, some].astype(np.float64).T, tone[some]
    height, width = np.ptp(rows) + 1, np.ptp(columns) + 1

    def misfit(values: Doubles) -> float:
        return _misfit(factors, light, *_normals(rows, columns, np.exp(values[0]), values[1], values[2]))

    starts = np.stack(
        np.meshgrid(
            np.log(np.geomspace(0.5, 3.5, 12) * 100 / width),
            columns.min() + np.linspace(0.3, 0.7, 5) * width,
            rows.min() + np.linspace(0.1, 0.6, 11) * height,
            indexing="ij",
        ),
        axis=-1,
    ).reshape(-1, 3)
    best = min(starts, key=misfit)
    simplex = best + np.vstack([np.zeros(3), np.diag([0.1, 0.04 * width, 0.04 * height])])
    found = minimize(misfit, best, method="Nelder-Mead", options={"initial_simplex": simplex, "xatol": 1e-3})
    if found.fun > FITTING:
        raise HarmonicFaceError(
            f"photographs: expected a face from the front, got shading of which the mean face's has"
            f" {found.fun:.0%} outside at the best place (at most {FITTING:.0%}); face=False takes anything"
        )
    return FacePlace(float(np.exp(found.x[0])), float(found.x[1]), float(found.x[2]), float(found.fun))


def _misfit(factors: Doubles, light: Doubles, normals: Doubles, known: Mask) -> float:
    """Return the share of the mean face's three shadings outside the space of the factors."""
    if known.mean() < LEAST_SEEN:
        return 1.0
    shading = (light[:, None] * normals)[known]
    even = light[known] / np.linalg.norm(light[known])
    shading = shading - np.outer(even, even @ shading)  # what a dim light from all sides gives tells nothing
    inside = np.linalg.qr(factors[known])[0].T @ shading
    return float(1 - (inside**2).sum() / (shading**2).sum())


def _table() -> tuple[Doubles, Mask]:
    """Return the relief in mm, mirrored, continued straight on where there is none; and where there is."""
    rows, known = [], []
    for line in RELIEF.strip().splitlines():
        numbers = line.split()
        outside = numbers.count(".")
        heights = [float(number) / 10 for number in numbers[outside:]]
        for _ in range(outside):
            heights.insert(0, 2 * heights[0] - heights[1])
        inside = [False] * outside + [True] * (len(numbers) - outside)
        rows.append(heights + heights[-2::-1])
        known.append(inside + inside[-2::-1])
    return np.array(rows), np.array(known)


def _finer() -> tuple[Doubles, Doubles, Doubles]:
    """Return the relief's slopes to the right and up, and 1 where it is known, at a quarter of the table's step."""
    relief, known = _table()
    rows, columns = (np.arange(4 * size - 3) / 4 for size in relief.shape)
    spline = RectBivariateSpline(*(np.arange(size) for size in relief.shape), relief)
    right, up = spline(rows, columns, dy=1) / STEP, -spline(rows, columns, dx=1) / STEP
    covered = map_coordinates(known.astype(np.float64), np.meshgrid(rows, columns, indexing="ij"), order=1)
    return right, up, covered


SLOPES = _finer()


def _normals(rows: Integers, columns: Integers, scale: float, column: float, row: float) -> tuple[Doubles, Mask]:
    """Return the mean face's normals at pixels, and where it is known."""
    across, up = (columns - column) * scale, (row - rows) * scale
    places = np.stack([(TOP - up) / STEP, (across - LEFT) / STEP]) * 4
    right, upward, known = (map_coordinates(field, places, order=1, cval=0.0) for field in SLOPES)
    normals = np.stack([-right, -upward, np.ones_like(right)], axis=1)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), known > 0.99
