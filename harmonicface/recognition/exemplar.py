"""Harmonic exemplars: a person's nine harmonic images from one photograph under unknown light, by a prior of faces."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import nnls

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.nonnegative_light import fibonacci_sphere
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting.light import HarmonicLight
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.recognition.face_placement import checked_photo, filled, place_face
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.stereo.motion import Matrix, checked_motion
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

ROUNDS = 8  # light and images in turn; later ones change the images by less than a hundredth
LAMPS = 200  # directions of light that cannot be negative
CORRELATED = 50.0  # pixels that err together: what nine images leave of a photograph is smooth
LEAST_NOISE = 0.01  # of the photograph's root mean square
FAINT = 0.5  # of the mean brightness: where less light arrives, texture is taken from the prior
FEWEST = 36  # pixels of the face that the photograph has to show
LEAST_ALBEDO = 0.02  # of the mean
GRAZING = 0.05  # smallest z of a normal


@dataclass(frozen=True, eq=False)
class Exemplar:
    """What one photograph tells of a person.

    Parameters
    ----------
    surface
        Normals and albedo on the photograph's pixels; the mask is where the prior's face is. The mean albedo is that
        of the prior's people, which no photograph tells.
    light
        In the photograph's units for that albedo: `light.coefficients(2) @ harmonic_images(surface)` is nearly the
        photograph.
    noise
        Standard deviation of what the prior's face under that light leaves of the photograph, in its units.
    coefficients
        (m,) of the prior's modes; 0 is the mean face, 1 a standard deviation from it.
    motion
        (2, 3), from the prior's pixel coordinates to the photograph's.
    """

    surface: Surface
    light: HarmonicLight
    noise: float
    coefficients: Array
    motion: Matrix

    @property
    def images(self) -> Floats:
        """The nine harmonic images at all pixels of the photograph, (9, h * w) float32, 0 outside the face."""
        placed = np.zeros((9, self.surface.mask.size), np.float32)
        placed[:, self.surface.mask.ravel()] = harmonic_images(self.surface)
        return placed


def exemplar_images(photo: ArrayLike, prior: FacePrior | None = None, mask: ArrayLike | None = None) -> Floats:
    """Return a person's nine harmonic images from one photograph, (9, h * w) float32, 0 outside the face.

    They are `exemplar(photo, prior, mask).images`, as rows of a `Subspace`.

    Raises
    ------
    HarmonicFaceError
        As of `exemplar`.

    Examples
    --------
    >>> from harmonicface.people.prior import synthetic_prior
    >>> from harmonicface.people.synthetic import synthetic_person
    >>> exemplar_images(synthetic_person(5, 48).albedo, synthetic_prior((48, 42), 20)).shape
    (9, 2304)
    """
    return exemplar(photo, prior, mask).images


def exemplar(
    photo: ArrayLike,
    prior: FacePrior | None = None,
    mask: ArrayLike | None = None,
    motion: ArrayLike | None = None,
) -> Exemplar:
    r"""Recover a person's normals, albedo and light from one photograph, the most probable ones by a prior of faces.

    With the prior's mean images, modes u and light l, in turn until they agree,

    .. math:: \min_{c,\; l = \sum_j s_j Y(w_j),\; s \ge 0} \frac{1}{\sigma^2}
       \big| I - l \cdot (\bar b + \textstyle\sum_i c_i u_i) \big|^2 + |c|^2

    where sigma is the median of what is left (Zhang & Samaras, Face recognition from a single training image under
    arbitrary unknown lighting using spherical harmonics, 2006: there each pixel for itself, here all together). The
    nine images are then made those of one normal and one albedo at each pixel, and what the photograph has beyond them,
    its texture, is given to the albedo. Nothing is said of depth or cast shadows. Light and albedo have a common scale
    that one photograph does not tell.

    Of 60 synthetic people outside the prior, photographed once under natural light at 96 x 84, normals come out 6.7
    degrees off (those of the mean face are 8.6), a picture under another natural light 14 %, and 1.7 % of their next
    photographs under other natural light, 5 % of those under a lamp, are nearest to somebody else's images (none to
    their own geometry's; 83 and 88 % to somebody else's photograph). It takes 0.2 seconds.

    Parameters
    ----------
    photo
        (h, w) linear intensities of a face seen from the front, in any unit, h and w at least 16.
    prior
        By default the built-in one, `synthetic_prior()`, which takes seconds to make once.
    mask
        (h, w) booleans, false where the photograph is bad: there the prior alone decides.
    motion
        (2, 3), where the prior's face is in the photograph; by default it is searched for (`place_face`).

    Returns
    -------
    Exemplar

    Raises
    ------
    HarmonicFaceError
        Another shape, too few pixels, NaN, no contrast, no light in the face, a motion that leads out of the picture.

    Examples
    --------
    >>> import harmonicface as hf
    >>> from harmonicface.people.prior import synthetic_prior
    >>> photo = hf.render(hf.synthetic_person(5, 48), hf.lights.natural(3))
    >>> found = exemplar(photo, synthetic_prior((48, 42), 20))
    >>> found.surface.shape, found.light.coefficients(2).shape
    ((48, 48), (9,))
    """
    pixels = checked_photo(photo)
    unit = float(np.abs(np.asarray(photo)).max())
    shape = (pixels.shape[0], pixels.shape[1])
    good = np.ones(shape, np.bool_) if mask is None else _validate.mask(mask, "mask", shape)
    known = prior or synthetic_prior()
    where = place_face(pixels, known).motion if motion is None else checked_motion(motion)
    seen, shown = _in_prior(pixels, good, where, known)
    if shown.sum() < FEWEST:
        raise HarmonicFaceError(f"photo: expected at least {FEWEST} good pixels of a face, got {shown.sum()}")
    if not seen[shown].max() > 0:
        raise HarmonicFaceError("photo: expected some light in the face, got none")
    coefficients, light, noise = _most_probable(seen[shown], known, shown[known.mask])
    normals, albedo = _normals_and_albedo(known.images(coefficients))
    surface = _on_photograph(normals, albedo, where, known, shape)
    textured = surface.albedo * _texture(pixels, good, surface, light)
    surface = Surface(surface.normals, (known.tone * textured).astype(np.float32), surface.mask)
    return Exemplar(surface, HarmonicLight(unit * light / known.tone), unit * noise, coefficients, where)


def _in_prior(
    photo: NDArray[np.float32], good: NDArray[np.bool_], motion: Matrix, prior: FacePrior
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the photograph in the prior's frame, (h, w), and where it shows the prior's pixels."""
    finer = float(np.sqrt(abs(np.linalg.det(motion[:, :2]))))  # pixels of the photograph a pixel of the prior
    smooth = cv2.GaussianBlur(photo, (0, 0), 0.4 * finer) if finer > 1.2 else photo
    size = prior.shape[::-1]
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    seen = cv2.warpAffine(smooth, motion, size, flags=how, borderMode=cv2.BORDER_REPLICATE)
    cover = cv2.warpAffine(good.astype(np.float32), motion, size, flags=how, borderValue=0)
    return np.asarray(seen, np.float64), np.asarray(prior.mask & (cover > 0.99))


def _most_probable(photo: Array, prior: FacePrior, shown: NDArray[np.bool_]) -> tuple[Array, Array, float]:
    """Return coefficients of the modes, light and noise, for the pixels of the prior that a photograph shows."""
    mean = prior.mean[:, shown].astype(np.float64)
    modes = np.ascontiguousarray(prior.modes[:, :, shown])  # an index leaves the pixels far apart in memory
    directions = np.asarray(real_harmonics(fibonacci_sphere(LAMPS), 2), np.float64)
    unit = float(np.sqrt((photo**2).mean()))
    target = photo / unit
    coefficients, images = np.zeros(len(modes)), mean
    for _ in range(ROUNDS):
        light = _light(images, target, directions)
        noise = max(1.4826 * float(np.median(np.abs(target - light @ images))), LEAST_NOISE)
        lit = np.matmul(light.astype(np.float32), modes)  # (m, p)
        precision = 1 / (noise**2 * CORRELATED)
        normal = precision * (lit @ lit.T).astype(np.float64) + np.eye(len(modes))
        coefficients = np.linalg.solve(normal, precision * (lit @ (target - light @ mean)))
        images = mean + np.tensordot(coefficients.astype(np.float32), modes, 1)
    light = _light(images, target, directions)
    return coefficients, unit * light, unit * noise


def _light(images: Array, photo: Array, directions: Array) -> Array:
    """Return the harmonics of lamps of no negative strength that explain a photograph best by its nine images."""
    gram = images @ images.T
    factor = np.linalg.cholesky(gram + 1e-9 * np.trace(gram) * np.eye(len(gram)))
    strengths, _ = nnls(factor.T @ directions, np.linalg.solve(factor, images @ photo), maxiter=50 * LAMPS)
    return np.asarray(directions @ strengths)


def _normals_and_albedo(images: Array) -> tuple[Array, Array]:
    """Return the normals (p, 3) and albedos (p,) whose harmonic images of order 1 these are."""
    constants = lambertian_filter(1) * np.sqrt([1 / (4 * np.pi), 3 / (4 * np.pi)])
    y, z, x = images[1:4] / constants[1]
    normals = np.column_stack([x, y, z])
    normals[:, 2] = np.maximum(normals[:, 2], GRAZING * np.maximum(np.linalg.norm(normals, axis=1), 1e-6))
    albedo = np.maximum(images[0] / constants[0], LEAST_ALBEDO)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), albedo


def _on_photograph(normals: Array, albedo: Array, motion: Matrix, prior: FacePrior, shape: tuple[int, int]) -> Surface:
    """Return what the prior's frame holds as seen from the photograph's pixels."""
    held = np.zeros((*prior.shape, 4), np.float32)
    held[prior.mask, :3], held[prior.mask, 3] = normals, albedo
    size = shape[::-1]
    finer = float(np.sqrt(abs(np.linalg.det(motion[:, :2]))))
    held = filled(held, prior.mask)
    if finer < 0.8:
        held = np.asarray(cv2.GaussianBlur(held, (0, 0), 0.4 / finer), np.float32)
    seen = cv2.warpAffine(held, motion, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    cover = cv2.warpAffine(prior.mask.astype(np.float32), motion, size, flags=cv2.INTER_LINEAR, borderValue=0)
    mask = cover > 0.99
    if not mask.any():
        raise HarmonicFaceError("motion: expected a face inside the photograph, got one that is all outside")
    turn = np.asarray(
        motion[:, :2] / np.sqrt(abs(np.linalg.det(motion[:, :2])))
    )  # y goes down in pixels, up in normals
    turned = seen[..., :3].astype(np.float64)
    x, y = turned[..., 0].copy(), -turned[..., 1]
    turned[..., 0], turned[..., 1] = turn[0, 0] * x + turn[0, 1] * y, -(turn[1, 0] * x + turn[1, 1] * y)
    turned[mask] /= np.linalg.norm(turned[mask], axis=1, keepdims=True)
    return Surface(turned.astype(np.float32), seen[..., 3], mask)


def _texture(photo: NDArray[np.float32], good: NDArray[np.bool_], surface: Surface, light: Array) -> Array:
    """Return by what to multiply the albedo so that the picture becomes the photograph where light arrives, (h, w)."""
    picture = np.zeros(surface.shape)
    picture[surface.mask] = np.maximum(light @ harmonic_images(surface), 0)
    faint = (FAINT * picture[surface.mask].mean()) ** 2
    ratio = (np.maximum(photo, 0) * picture + faint) / (picture**2 + faint)
    return np.asarray(np.where(good, ratio, 1.0))
