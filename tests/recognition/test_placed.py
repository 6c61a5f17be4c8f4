"""Whom a photograph shows displaced, turned and grown, and where."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.ndimage import affine_transform

import harmonicface as hf
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.recognition.patterns import Template, patterns
from harmonicface.recognition.placed import LEADERS, placed, placed_nearby
from harmonicface.recognition.placement import Placement

SHAPE = (96, 84)


def skin(seed: int, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    """Return a picture with detail of all sizes above a pixel."""
    rng = np.random.default_rng(seed)
    noise = sum(scale * cv2.GaussianBlur(rng.normal(size=shape), (0, 0), scale) for scale in (0.8, 1.5, 4.0))
    return np.exp(0.4 * noise / noise.std())


def shown(face: np.ndarray, placement: Placement) -> np.ndarray:
    """Return a photograph that shows a face there, by splines, under a light that grows to the right and below."""
    (a, b, right), (c, d, down) = placement.motion(face.shape)
    matrix = np.linalg.inv([[d, c, down], [b, a, right], [0, 0, 1]])  # rows first
    down, right = np.mgrid[0 : face.shape[0], 0 : face.shape[1]] / 100
    return affine_transform(face, matrix, order=3, mode="nearest") * (0.1 + right) * (0.3 + down**2)


@pytest.mark.parametrize(
    "placement",
    [
        Placement(),
        Placement(6, -5),
        Placement(-9, 4),
        Placement(0.5, 0.25),
        Placement(0, 0, 8),
        Placement(0, 0, -5),
        Placement(0, 0, 0, 0.08),
        Placement(0, 0, 0, -0.05),
        Placement(-3, 2, 3, -0.03),
        Placement(4, 4, -4, 0.04),
    ],
    ids=str,
)
def test_people_are_found_where_they_are(placement: Placement) -> None:
    found = placed(patterns(shown(skin(1), placement)), [Template.of([patterns(skin(seed))]) for seed in range(3)])
    assert found.index == 1
    assert_allclose([found.placement.right, found.placement.down], [placement.right, placement.down], atol=0.2)
    assert_allclose(
        [found.placement.turn, 100 * found.placement.growth], [placement.turn, 100 * placement.growth], atol=0.4
    )
    tried = (
        abs(placement.turn) + 100 * abs(placement.growth) < 1 and max(abs(placement.right), abs(placement.down)) <= 4
    )
    assert (found.gain > 0) == (not tried)


@settings(max_examples=8)
@given(*(st.floats(-8, 8) for _ in range(2)), st.floats(-8, 8), st.floats(-0.08, 0.08), st.integers(0, 99))
def test_any_placement(right: float, down: float, turn: float, growth: float, seed: int) -> None:
    placement = Placement(right, down, turn, growth)
    found = placed(patterns(shown(skin(seed), placement)), [Template.of([patterns(skin(seed))])]).placement
    assert_allclose(found.motion(SHAPE) @ [42, 48, 1], placement.motion(SHAPE) @ [42, 48, 1], atol=0.3)
    assert_allclose([found.turn, 100 * found.growth], [turn, 100 * growth], atol=0.6)


def test_of_many_people_too() -> None:
    templates = [Template.of([patterns(skin(seed))]) for seed in range(3 * LEADERS)]
    found = placed(patterns(shown(skin(2 * LEADERS + 1), Placement(5, -3, 4, 0.03))), templates)
    assert found.index == 2 * LEADERS + 1
    assert_allclose([found.placement.turn, found.placement.growth], [4, 0.03], atol=0.4)


def test_known_to_be_near_a_shift() -> None:
    template = Template.of([patterns(skin(1))])
    for placement, shift in ((Placement(0.5, 0.25, 1, 0.01), (0, 0)), (Placement(-3.3, 7.4, -2), (-3, 7))):
        found = placed_nearby(patterns(shown(skin(1), placement)), template, shift)
        assert_allclose([found.right, found.down], [placement.right, placement.down], atol=0.2)
        assert_allclose([found.turn, 100 * found.growth], [placement.turn, 100 * placement.growth], atol=0.3)


def test_other_grids_and_hidden_parts() -> None:
    """Of 64 x 64 there are five blocks a side and two pixels left over on all sides."""
    face = skin(5, (64, 64))
    mask = np.ones((64, 64), bool)
    mask[:, :20] = False
    template = Template.of([patterns(face)])
    found = placed(patterns(shown(face, Placement(-6, 3, 4)), mask), [template])
    assert_allclose([found.placement.right, found.placement.down, found.placement.turn], [-6, 3, 4], atol=0.4)


def test_without_detail_everybody_stays() -> None:
    template = Template.of([patterns(skin(1))])
    for photo in (np.zeros(SHAPE), np.ones(SHAPE)):
        found = placed(patterns(photo), [template])
        assert (found.placement, found.votes, found.gain) == (Placement(), 0, 0)
        assert placed_nearby(patterns(photo), template) == Placement()


def test_whom_nobody_can_find() -> None:
    query, small = patterns(skin(1)), Template.of([patterns(skin(1, (64, 64)))])
    with pytest.raises(hf.HarmonicFaceError, match="templates: expected at least one, got none"):
        placed(query, [])
    for find in (lambda: placed(query, [small]), lambda: placed_nearby(query, small)):
        with pytest.raises(
            hf.HarmonicFaceError, match=r"templates: expected the query's shape \(96, 84\), got \(64, 64\)"
        ):
            find()


@pytest.mark.data
@pytest.mark.parametrize("subset", [3, 4, 5])
def test_real_people_under_lamps_far_to_the_side(data_dir: Path, subset: int) -> None:
    """Turned by 5 degrees and grown by 4 % beyond how they stood, which the photograph as it is tells."""
    people = load_yale_b(data_dir / "yaleb", [6, 7])
    templates = [Template.of([patterns(face) for face in one.photographs[one.subsets == 1]]) for one in people]
    photo = people[0].photographs[people[0].subsets == subset][3]
    rest = placed_nearby(patterns(photo), templates[0])
    about = cv2.getRotationMatrix2D((83.5, 95.5), -5, 1.04)
    moved = cv2.warpAffine(photo, about, photo.shape[::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    found = placed(patterns(np.maximum(moved, 0)), templates)
    assert (found.index, found.gain > 0.03) == (0, True)
    assert_allclose(found.placement.turn - rest.turn, 5, atol=0.8)
    assert_allclose(100 * (found.placement.growth - rest.growth), 4, atol=0.8)
