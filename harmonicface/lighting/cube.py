"""The cube layout: six faces, as graphics hardware names and turns them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.layout import Layout, Shape, bilinear

FACES = ("px", "nx", "py", "ny", "pz", "nz")
# Per face: the axis through its centre, to the right of its picture, and down it (OpenGL's faces).
FRAMES = np.array(
    [
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, -1, 0], [1, 0, 0], [0, 0, -1]],
        [[0, 0, 1], [1, 0, 0], [0, -1, 0]],
        [[0, 0, -1], [-1, 0, 0], [0, -1, 0]],
    ],
    dtype=np.float64,
)
# Where each face is in a cross of 3 x 4 squares or 4 x 3 (row, column); the last one of a high cross hangs upside down.
WIDE_CROSS = {"px": (1, 2), "nx": (1, 0), "py": (0, 1), "ny": (2, 1), "pz": (1, 1), "nz": (1, 3)}
HIGH_CROSS = {"px": (1, 2), "nx": (1, 0), "py": (0, 1), "ny": (2, 1), "pz": (1, 1), "nz": (3, 1)}


class CubeLayout(Layout):
    """Six square faces in the order px nx py ny pz nz, stacked: (6, n, n) or (6, n, n, 3).

    Each is named by the axis through its centre. The four sides stand upright (+y is up); pz has +x to its right,
    and px, nz, nx follow it to the right; py joins the top of pz, ny its bottom. That is how OpenGL orders and turns
    its faces: seen from inside, the picture is a mirror image.
    """

    name = "cube"

    def shape(self, size: int) -> Shape:
        return 6, size, size

    def check(self, radiance: Floats) -> None:
        shape = radiance.shape
        square = len(shape) in (3, 4) and shape[0] == 6 and shape[1] == shape[2]
        if not square or shape[3:] not in ((), (3,)) or radiance.size == 0:
            raise HarmonicFaceError(
                f"radiance: expected six square faces, (6, n, n) or (6, n, n, 3), got {_validate.describe(radiance)}"
            )

    def _directions(self, shape: Shape, across: float, down: float) -> NDArray[np.float64]:
        right, below = _points(shape[-1], across, down)
        return np.stack([_toward(face, right, below) for face in range(6)])

    def area_element(self, shape: Shape, across: float = 0.5, down: float = 0.5) -> NDArray[np.float64]:
        right, below = _points(shape[-1], across, down)
        return np.broadcast_to((1 + right**2 + below**2) ** -1.5, shape)

    def solid_angles(self, shape: Shape) -> NDArray[np.float64]:
        """Return the solid angles of the squares, by the closed form of a rectangle seen from above its corner."""
        edges = np.linspace(-1.0, 1.0, shape[-1] + 1)
        x, y = edges[None, :], edges[:, None]
        corner = np.arctan2(x * y, np.sqrt(x * x + y * y + 1))
        return np.broadcast_to(np.diff(np.diff(corner, axis=0), axis=1), shape).copy()

    def fold(self, values: Floats) -> tuple[Floats, Floats] | None:
        opposite = [values[1][::-1], values[3][:, ::-1], values[5][::-1]]  # as the opposite face shows it
        return values[::2], np.stack(opposite)

    def sample(self, radiance: Floats, directions: NDArray[np.float64]) -> Floats:
        flat = directions.reshape(-1, 3)
        result = np.empty((len(flat), *radiance.shape[3:]), radiance.dtype)
        face, row, column = _place(flat, radiance.shape[1])
        for index in range(6):
            here = face == index
            if here.any():
                result[here] = bilinear(_bordered(radiance, index), row[here] + 1, column[here] + 1)
        return result.reshape(directions.shape[:-1] + radiance.shape[3:])


def faces_of_cross(picture: Floats) -> Floats:
    """Cut a picture of an unfolded cube into its faces, (6, n, n) or (6, n, n, 3).

    A wide cross has px, pz, nz, nx in its middle row and py, ny above and below pz; in a high cross nz hangs below
    ny, upside down.

    Raises
    ------
    HarmonicFaceError
        A picture that is neither 4 squares wide and 3 high, nor 3 wide and 4 high.
    """
    height, width = picture.shape[:2]
    wide = 3 * width == 4 * height
    size = width // 4 if wide else width // 3
    if size == 0 or (height, width) not in ((3 * size, 4 * size), (4 * size, 3 * size)):
        raise HarmonicFaceError(f"expected a cross of 4 x 3 or 3 x 4 squares, got {width} x {height} pixels")
    faces = []
    for name in FACES:
        row, column = (WIDE_CROSS if wide else HIGH_CROSS)[name]
        face = picture[row * size : (row + 1) * size, column * size : (column + 1) * size]
        faces.append(face[::-1, ::-1] if name == "nz" and not wide else face)
    return np.stack(faces)


def cross_of_faces(faces: Floats) -> Floats:
    """Return six faces as a wide cross, (3 n, 4 n) or (3 n, 4 n, 3), black where there is none."""
    size = faces.shape[1]
    cross = np.zeros((3 * size, 4 * size, *faces.shape[3:]), faces.dtype)
    for face, name in zip(faces, FACES, strict=True):
        row, column = WIDE_CROSS[name]
        cross[row * size : (row + 1) * size, column * size : (column + 1) * size] = face
    return cross


def _points(size: int, across: float, down: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a point in each pixel of a face, from -1 to 1: (1, n) to the right and (n, 1) down."""
    steps = np.arange(size)
    return ((steps + across) / size * 2 - 1)[None, :], ((steps + down) / size * 2 - 1)[:, None]


def _toward(face: int, right: NDArray[np.float64], below: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit directions through points of a face, whose borders are at -1 and 1."""
    centre, rightward, downward = FRAMES[face]
    vectors = centre + right[..., None] * rightward + below[..., None] * downward
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _place(flat: NDArray[np.float64], size: int) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """Return the face, row and column (0 at the first pixel's centre) of directions (n, 3)."""
    face = np.argmax(flat @ FRAMES[:, 0].T, axis=1)
    centre, right, below = np.moveaxis(np.einsum("nfj,nj->nf", FRAMES[face], flat), 1, 0)
    return face, (below / centre + 1) / 2 * size - 0.5, (right / centre + 1) / 2 * size - 0.5


def _bordered(radiance: Floats, face: int) -> Floats:
    """Return a face with a border of one pixel, taken from its neighbours."""
    size = radiance.shape[1]
    step = (np.arange(-1, size + 1) + 0.5) / size * 2 - 1
    result = np.zeros((size + 2, size + 2, *radiance.shape[3:]), radiance.dtype)
    result[1:-1, 1:-1] = radiance[face]
    border = np.ones((size + 2, size + 2), bool)
    border[1:-1, 1:-1] = False
    rows, columns = np.nonzero(border)
    neighbour, row, column = _place(_toward(face, step[columns], step[rows]), size)
    for index in range(6):
        here = neighbour == index
        if here.any():
            result[rows[here], columns[here]] = bilinear(radiance[index], row[here], column[here])
    return result
