"""Lights in other axes are found by the curl that they leave; shapes that look the same in them are let be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from harmonicface.bench.stability.hard_photographs import bumpy_ball, lamps, photographed
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.known.handedness import check_axes
from harmonicface.stereo.photometric_stereo import photometric_stereo

NORMALS, MASK = bumpy_ball(30)
OTHERS = {
    "left and right": ([-1, 1, 1], [0, 1, 2]),
    r"left and right \(or up and down\)": ([1, -1, 1], [0, 1, 2]),
    "x and y are": ([1, 1, 1], [1, 0, 2]),
    "x and y, and one of their signs, are": ([-1, 1, 1], [1, 0, 2]),
}


def test_the_right_axes_pass() -> None:
    check_axes(NORMALS, MASK)


@pytest.mark.parametrize("name", OTHERS)
def test_other_axes_are_named(name: str) -> None:
    signs, order = OTHERS[name]
    with pytest.raises(HarmonicFaceError, match=f"x right, y up, z toward the camera.*{name}"):
        check_axes((NORMALS * np.array(signs))[:, order], MASK)


def test_the_mirror_image_in_depth_has_no_curl() -> None:
    check_axes(NORMALS * np.array([-1, -1, 1]), MASK)


@pytest.mark.parametrize("shape", ["plane", "ball", "noise", "few"])
def test_shapes_that_tell_nothing_pass(shape: str) -> None:
    random = np.random.default_rng(0)
    normals = {"plane": np.tile([0.2, 0.1, 0.9], (len(NORMALS), 1)), "noise": random.normal(size=NORMALS.shape)}
    y, x = np.mgrid[1:-1:30j, -1:1:30j]
    normals["ball"] = np.stack([x, y, np.sqrt(np.maximum(1.2 - x**2 - y**2, 0.01))], axis=2)[MASK]
    few = np.zeros_like(MASK)
    few[14:20, 14:20] = True
    if shape == "few":
        check_axes((NORMALS * np.array([-1, 1, 1]))[few[MASK]], few)
        return
    check_axes(normals[shape] + 1e-3 * random.normal(size=NORMALS.shape), MASK)


def test_photographs_with_the_sign_of_x_confused_are_refused() -> None:
    case = photographed(NORMALS, MASK, lamps(12, seed=1))
    with pytest.raises(HarmonicFaceError, match="left and right"):
        photometric_stereo(case.images, case.lights * np.array([-1, 1, 1]), MASK)


@pytest.mark.data
def test_a_real_face_under_lamps_upside_down(data_dir: Path) -> None:
    person = load_yale_b(data_dir / "yaleb", [5])[0]
    seen = person.angles < 52
    images, lights = np.asarray(person.photographs)[seen], np.asarray(person.lights)[seen]
    photometric_stereo(images, lights, method="matte", integration="none")
    with pytest.raises(HarmonicFaceError, match=r"left and right \(or up and down\)"):
        photometric_stereo(images, lights * np.array([1, -1, 1]), method="matte", integration="none")
