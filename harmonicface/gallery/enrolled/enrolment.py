"""What stands for a person: the span of the pictures that her Surface or her photographs give, and a template."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.portrait import photographed_template, rendered_template
from harmonicface.gallery.frame import Frame
from harmonicface.io.colour import luminance
from harmonicface.recognition.exemplar import exemplar
from harmonicface.recognition.grid import ROWS
from harmonicface.recognition.patterns import Template
from harmonicface.recognition.subspace import Subspace
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.stereo.motion import STILL
from harmonicface.stereo.reconstruction import reconstruct
from harmonicface.stereo.registration import register
from harmonicface.surfaces.surface import Surface

FEWEST_PHOTOGRAPHS = 3  # fewer do not span the pictures of even a surface without shadows
MOST_ROWS = 9
# Pixels of the grid, in the mean over the corners, by which photographs under unknown lights are apart: on the first
# five people of Yale B, all that registration gains where they are moved stays, and nothing is lost where they are not.
APART = 2.5
SURFACE, LIT, PHOTOGRAPHS, PHOTOGRAPH = SOURCES = ("surface", "lit photographs", "photographs", "photograph")
WITH_GEOMETRY = (SURFACE, LIT)


@dataclass(frozen=True, eq=False)
class Model:
    """What a gallery makes of people.

    Parameters
    ----------
    pictures_of
        The pictures that span those of a Surface.
    fewest
        How many photographs under unknown lights it needs.
    templates
        Whether it keeps templates of local patterns.
    depth
        Whether the Surface that stereo finds must have depth.
    """

    pictures_of: Callable[[Surface], Floats]
    fewest: int = FEWEST_PHOTOGRAPHS
    templates: bool = False
    depth: bool = False


@dataclass(frozen=True, eq=False)
class Enrolment:
    """A person's subspace, the frame it is in, what it was made from (one of `SOURCES`), and a template."""

    subspace: Subspace
    frame: Frame
    source: str
    template: Template | None = None

    @property
    def nbytes(self) -> int:
        """Memory of rows and template."""
        return self.subspace.rows.nbytes + (0 if self.template is None else self.template.nbytes)


def enrolment_of(
    source: Surface | ArrayLike, frame: Frame | None, model: Model, lights: ArrayLike | None = None
) -> Enrolment:
    """Return what stands for a person.

    Parameters
    ----------
    source
        A Surface; (n, h, w) or (n, h, w, 3) photographs; or one, (h, w) or (h, w, 3). Photographs under unknown lights
        are registered to each other where templates are kept and they are far apart; the nine strongest directions of
        their span count. Of a single one without a template the most probable Surface is taken (`exemplar`).
    frame
        The gallery's; None for the first person, whose every pixel then becomes the frame.
    model
        What the gallery makes of people.
    lights
        (n, 3) directions to the lights of n >= 3 photographs, times their strengths: the photographs are registered to
        each other, and their stereo is the Surface, its normals integrated if the model needs depth.

    Raises
    ------
    HarmonicFaceError
        Another shape than the frame's, too few different photographs, negative ones, NaN, an empty overlap; lights
        of a Surface; what registration and stereo refuse.
    """
    if isinstance(source, Surface):
        if lights is not None:
            raise HarmonicFaceError("lights: expected them with photographs only, got them with a Surface")
        return _of_surface(source, frame, model, SURFACE)
    if lights is None and not (model.templates or model.depth) and np.ndim(source) == 2:
        return _of_surface(exemplar(source).surface, frame, model, PHOTOGRAPH)
    stack = _photographs(source, 1 if lights is not None else model.fewest)
    frame = frame or Frame(np.ones(stack.shape[1:3], np.bool_))
    pixels = np.stack([frame.take(photo, "photographs") for photo in stack])
    grey = stack if stack.ndim == 3 else np.stack([luminance(photo) for photo in stack])
    if lights is None:
        together = _together(grey) if model.templates else grey
        pixels = pixels if together is grey else np.stack([photo[frame.mask] for photo in together])
        return _of_photographs(pixels, frame, model)
    registered = register(grey).photographs
    if model.depth:
        surface = reconstruct(registered, lights, registered=True)
    else:
        surface = calibrated_stereo(registered, lights).surface
    return _of_surface(surface, frame, model, LIT, registered)


def _together(photographs: Floats) -> Floats:
    """Return photographs registered to each other if they show a person at different places, else as they are.

    Motions that are hardly larger than a query may have cost nothing and are left alone: resampling blurs fine detail.
    So are photographs that cannot be registered, in which light leaves too little in common.
    """
    if len(photographs) == 1:
        return photographs
    try:
        found = register(photographs, least=APART * max(1.0, photographs.shape[1] / ROWS))
    except HarmonicFaceError:
        return photographs
    return photographs if (found.motions == STILL).all() else found.photographs


def _of_surface(
    surface: Surface, frame: Frame | None, model: Model, source: str, photographs: Floats | None = None
) -> Enrolment:
    """Enrol by geometry; a template is made of photographs rather than of renderings if there are any."""
    frame = frame or Frame(np.ones(surface.shape, np.bool_))
    subspace = Subspace.of(frame.place(model.pictures_of(surface), surface.mask))
    if not model.templates:
        return Enrolment(subspace, frame, source)
    if photographs is None:
        return Enrolment(subspace, frame, source, rendered_template(surface, frame.mask))
    return Enrolment(subspace, frame, source, photographed_template(list(photographs), frame.mask))


def _of_photographs(pixels: Floats, frame: Frame, model: Model) -> Enrolment:
    """Enrol by the span of photographs under unknown lights, (n, p)."""
    subspace = Subspace.of(pixels, MOST_ROWS)
    if subspace.rank < model.fewest:
        expected = f"at least {model.fewest} photographs that differ, under different lights"
        raise HarmonicFaceError(f"source: expected {expected}, got {subspace.rank} different of {len(pixels)}")
    source = PHOTOGRAPH if len(pixels) == 1 else PHOTOGRAPHS
    if not model.templates:
        return Enrolment(subspace, frame, source)
    return Enrolment(
        subspace, frame, source, photographed_template([frame.picture(photo) for photo in pixels], frame.mask)
    )


def _photographs(source: ArrayLike, fewest: int) -> Floats:
    """Return photographs as a stack, (n, h, w) or (n, h, w, 3)."""
    stack: NDArray[np.floating] = _validate.floats(source, "photographs")
    if fewest == 1 and (stack.ndim == 2 or (stack.ndim == 3 and stack.shape[2] == 3)):
        stack = stack[None]
    if stack.ndim not in (3, 4) or len(stack) < fewest or stack.size == 0:
        photographs = "photographs of shape (n, h, w)" if fewest > 1 else "photograph of shape (h, w) or (n, h, w)"
        expected = f"a Surface, or at least {fewest} {photographs}"
        raise HarmonicFaceError(f"source: expected {expected}, got {_validate.describe(stack)}")
    return stack
