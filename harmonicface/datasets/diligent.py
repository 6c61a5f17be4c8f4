"""DiLiGenT: an object under 96 known lamps with its measured normals, from the user's disk."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image

LUMINANCE = np.array([0.2989, 0.5870, 0.1140])  # how the published figures turn colours to grey (ITU-R BT.601)
NOT_UNIT = 1e-2  # a measured normal whose length is off by more was not measured
SATURATION = 0.995  # of the sensor's range: what its last grey levels mean is uncertain


@dataclass(frozen=True, eq=False)
class DiligentObject:
    """One object of DiLiGenT: what the camera recorded in the object's mask, the lamps and the measured normals.

    Parameters
    ----------
    name
        The folder's, as "ballPNG".
    pixels
        (n, p, 3) float32, linear, 0 to 1, as recorded: the mask's pixels in row-major order, red first.
    directions
        (n, 3) unit directions to the lamps: x right, y up, z toward the camera.
    intensities
        (n, 3) how bright each lamp is in each colour.
    mask
        (h, w) booleans, the object.
    normals
        (p, 3) measured unit normals in the mask; zeros where none was measured.
    files
        The n files.
    """

    name: str
    pixels: NDArray[np.float32]
    directions: NDArray[np.float64]
    intensities: NDArray[np.float64]
    mask: NDArray[np.bool_]
    normals: NDArray[np.float64]
    files: tuple[Path, ...]

    def grey(self, *, divided: bool = True, luminance: bool = False) -> NDArray[np.float32]:
        """Return the grey level of each pixel: the mean of its three colours, as of other photographs in stereo.

        Parameters
        ----------
        divided
            By the brightness of the lamp, colour by colour, as where it is known; False leaves it in.
        luminance
            Weigh colours as the published figures do.

        Returns
        -------
        array
            (n, p) float32, of at least 0.
        """
        share = LUMINANCE if luminance else np.full(3, 1 / 3)
        weights = share / self.intensities if divided else np.tile(share, (len(self.pixels), 1))
        return np.stack([image @ weight for image, weight in zip(self.pixels, weights.astype(np.float32), strict=True)])

    def saturated(self) -> NDArray[np.bool_]:
        """Return (n, p) booleans, true where a colour has reached the top of the sensor's range."""
        return np.asarray((self.pixels >= SATURATION).any(axis=2))


def load_diligent(folder: str | os.PathLike[str]) -> DiligentObject:
    """Read one object of DiLiGenT (Shi et al., A Benchmark Dataset for Non-Lambertian Photometric Stereo, 2016).

    The 16-bit grey levels are proportional to the light; nothing is decoded, and nothing is divided by the lamps'
    brightness yet. Only the mask's pixels are kept: a seventh of the memory of whole pictures and less.

    Parameters
    ----------
    folder
        The object's: `001.png` ..., `light_directions.txt`, `light_intensities.txt`, `mask.png`, `Normal_gt.mat`;
        `filenames.txt` names the pictures if there is one, otherwise they are the PNG files with a number for a name.

    Returns
    -------
    DiligentObject

    Raises
    ------
    HarmonicFaceError
        No such folder, a file that is missing or corrupt, lists of unlike lengths, pictures of unlike sizes, a lamp
        without direction or brightness, an empty mask, no measured normal in it.

    Examples
    --------
    With the data set in the folder DiLiGenT::

        ball = load_diligent("DiLiGenT/pmsData/ballPNG")
        grey = ball.grey()  # (96, p)
    """
    root = Path(folder)
    if not root.is_dir():
        raise HarmonicFaceError(f"expected the folder of an object of DiLiGenT, got no folder {root}")
    files = _files(root)
    directions = _table(root / "light_directions.txt", len(files))
    intensities = _table(root / "light_intensities.txt", len(files))
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    if not (lengths > 0).all() or not (intensities > 0).all():
        raise HarmonicFaceError(f"{root}: expected lamps with a direction and a brightness above 0, got one without")
    mask = _mask(root / "mask.png")
    normals = _normals(root / "Normal_gt.mat", mask)
    pixels = np.stack([_pixels(path, mask) for path in files])
    return DiligentObject(root.resolve().name, pixels, directions / lengths, intensities, mask, normals, files)


def _files(root: Path) -> tuple[Path, ...]:
    """Return the pictures in the order of the lamps."""
    names = root / "filenames.txt"
    if names.is_file():
        files = tuple(root / name for name in names.read_text(encoding="utf-8", errors="replace").split())
    else:
        files = tuple(sorted((path for path in root.glob("*.png") if path.stem.isdigit()), key=lambda p: int(p.stem)))
    if not files:
        raise HarmonicFaceError(f"expected pictures 001.png, 002.png, ... in {root}, got none")
    return files


def _table(path: Path, count: int) -> NDArray[np.float64]:
    """Return three numbers a picture."""
    try:
        table = np.loadtxt(path, ndmin=2)
    except (OSError, ValueError) as error:
        raise HarmonicFaceError(f"{path}: expected three numbers in each line: {error}") from None
    if table.shape != (count, 3) or not np.isfinite(table).all():
        raise HarmonicFaceError(
            f"{path}: expected three finite numbers for each of {count} pictures, got {table.shape}"
        )
    return table


def _mask(path: Path) -> NDArray[np.bool_]:
    """Return where the object is: whatever is not black."""
    picture = read_image(path)
    mask = picture > 0 if picture.ndim == 2 else (picture > 0).any(axis=2)
    if not mask.any():
        raise HarmonicFaceError(f"{path}: expected an object in the mask, got nothing but black")
    return np.asarray(mask)


def _normals(path: Path, mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the measured normals in the mask, zeros where none was measured."""
    field = _matrix(path)
    if field.shape != (*mask.shape, 3) or field.dtype.kind != "f":
        raise HarmonicFaceError(
            f"{path}: expected normals of shape {(*mask.shape, 3)}, got {field.shape} of type {field.dtype}"
        )
    normals = field[mask].astype(np.float64)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    measured = np.abs(length - 1) < NOT_UNIT  # False for NaN
    if not measured.any():
        raise HarmonicFaceError(f"{path}: expected unit normals in the mask, got none")
    return np.asarray(np.divide(normals, length, out=np.zeros_like(normals), where=measured))


def _matrix(path: Path) -> NDArray[Any]:
    """Return the one matrix of a MATLAB file."""
    try:
        found = loadmat(path, variable_names=["Normal_gt"])
        return np.asarray(found["Normal_gt"])
    except KeyError:
        raise HarmonicFaceError(f"{path}: expected a matrix Normal_gt, got none") from None
    except Exception as error:  # the reader raises whatever it likes on bad files
        raise HarmonicFaceError(f"{path}: expected a MATLAB file with the normals: {error}") from None


def _pixels(path: Path, mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return a picture's pixels in the mask."""
    picture = read_image(path, transfer="linear")
    if picture.shape != (*mask.shape, 3):
        raise HarmonicFaceError(f"{path}: expected a colour picture of shape {(*mask.shape, 3)}, got {picture.shape}")
    return picture[mask]
