"""A gallery as one file: what is in it, and what it must be to be believed."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.enrolment import SOURCES
from harmonicface.gallery.enrolled.rows import StackedRows
from harmonicface.gallery.names import checked_name
from harmonicface.recognition.grid import grid
from harmonicface.recognition.models import SUBSPACE_MODELS
from harmonicface.recognition.patterns import SCALES, Template
from harmonicface.store.archive import read_about, read_arrays, write_arrays

FORMAT = "harmonicface gallery"
VERSIONS = ("1", "2", "3")  # the first knew neither templates nor the default model
OTHER_TEMPLATES = "2"  # its templates are of patterns that were not whitened: compared with today's they tell little
DEFAULT_MODEL = "default"
DEFAULT_SHORTLIST = 50  # also of files that do not say


@dataclass(frozen=True, eq=False)
class Contents:
    """What a gallery file holds; templates only for the default model."""

    model: str
    threshold: float
    margin: float
    shortlist: int
    mask: NDArray[np.bool_]
    rows: StackedRows
    sources: dict[str, str]
    templates: list[Template]


def write(path: str | os.PathLike[str], contents: Contents) -> None:
    """Write a gallery, replacing the file whole."""
    matrices = contents.rows.to_coefficients
    arrays: dict[str, NDArray[Any]] = {
        "mask": contents.mask,
        "rows": contents.rows.array,
        "to_coefficients": np.concatenate([matrix.ravel() for matrix in matrices]),
        "shapes": np.array([matrix.shape for matrix in matrices], np.int64),
    }
    if contents.templates:
        arrays["templates"] = np.stack([template.values for template in contents.templates])
    about = {
        "model": contents.model,
        "threshold": contents.threshold,
        "margin": contents.margin,
        "shortlist": contents.shortlist,
        "people": list(contents.sources.items()),
    }
    write_arrays(path, arrays, {"format": FORMAT, "version": VERSIONS[-1], "about": json.dumps(about)})


def check_kind(path: str | os.PathLike[str]) -> None:
    """Refuse to take a file's place that is no gallery.

    Raises
    ------
    HarmonicFaceError
        It is none, as far as its header tells.
    """
    if read_about(path).get("format") != FORMAT:
        raise HarmonicFaceError(f"save: expected a new path or a gallery's, got {path!s:.300}, a file of another kind")


def read(path: str | os.PathLike[str]) -> Contents:
    """Read a gallery.

    Raises
    ------
    HarmonicFaceError
        The file is missing, damaged, of another kind, of another version, or contradicts itself.
    """
    arrays, header = read_arrays(path)
    if header.get("format") != FORMAT:
        raise HarmonicFaceError(f"{path}: expected a {FORMAT}, got a file of {header.get('format', 'another kind')!r}")
    if header.get("version") not in VERSIONS:
        got = header.get("version")
        raise HarmonicFaceError(f"{path}: expected version {', '.join(VERSIONS)} of the gallery format, got {got}")
    try:
        contents = _contents(arrays, json.loads(header["about"]))
    except HarmonicFaceError as error:  # a name, which earlier versions let be
        raise HarmonicFaceError(f"{path}: {error}") from None
    except (KeyError, TypeError, ValueError, IndexError, RecursionError):
        raise HarmonicFaceError(f"{path}: expected a gallery that agrees with itself, got one that does not") from None
    if contents.templates and header["version"] == OTHER_TEMPLATES:
        expected = f"templates of version {VERSIONS[-1]} of the gallery format"
        raise HarmonicFaceError(f"{path}: expected {expected}, got those of {OTHER_TEMPLATES}: enrol everybody again")
    return contents


def _contents(arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Contents:
    """Put the parts together; any contradiction between them raises ValueError."""
    about = {"shortlist": DEFAULT_SHORTLIST, **about}
    mask, rows, shapes = arrays["mask"], arrays["rows"], arrays["shapes"]
    sources = {str(name): str(source) for name, source in about["people"]}
    sizes = shapes[:, 0] * shapes[:, 1]
    matrices = np.split(arrays["to_coefficients"], np.cumsum(sizes)[:-1])
    agrees = (
        mask.ndim == 2
        and mask.dtype == np.bool_
        and rows.dtype == np.float32
        and rows.shape == (shapes[:, 0].sum(), mask.sum())
        and shapes.min() >= 1
        and len(sources) == len(about["people"]) == len(shapes)
        and all(checked_name(name) for name in sources)
        and set(sources.values()) <= set(SOURCES)
        and about["model"] in (DEFAULT_MODEL, *SUBSPACE_MODELS)
        and 0 <= about["threshold"] < np.inf
        and (about["model"] == DEFAULT_MODEL or about["threshold"] <= 1)
        and about["margin"] >= 1
        and type(about["shortlist"]) is int
        and about["shortlist"] >= 2
        and bool(np.isfinite(arrays["to_coefficients"]).all())
        and bool(np.abs(np.einsum("np,np->n", rows, rows) - 1).max() < 1e-3)  # NaN fails too
    )
    if not agrees:
        raise ValueError("the parts of the gallery contradict each other")
    people = [matrix.reshape(shape) for matrix, shape in zip(matrices, shapes, strict=True)]
    templates = _templates(arrays, mask.shape, len(people)) if about["model"] == DEFAULT_MODEL else []
    stacked = StackedRows(rows, people)
    return Contents(
        about["model"], about["threshold"], about["margin"], about["shortlist"], mask, stacked, sources, templates
    )


def _templates(arrays: dict[str, NDArray[Any]], shape: tuple[int, ...], count: int) -> list[Template]:
    """Return everybody's template; ValueError if they cannot be."""
    values = arrays["templates"]
    if values.dtype != np.float16 or values.shape != (count, *grid((shape[0], shape[1]))):
        raise ValueError("the templates do not fit the gallery")
    if not (np.abs(values) <= len(SCALES)).all():  # NaN fails too
        raise ValueError("the templates hold what patterns cannot be")
    return [Template(one) for one in values]
