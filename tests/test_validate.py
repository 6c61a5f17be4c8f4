"""Each check lets the right array through as it is and refuses the wrong one in one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

WRONG: dict[str, tuple[Callable[[], Any], str]] = {
    "text": (lambda: _validate.floats("red", "a"), "a: expected an array of real numbers, got str 'red'"),
    "ragged": (lambda: _validate.floats([[1], [1, 2]], "a"), "a: expected an array of real numbers, got list"),
    "complex": (lambda: _validate.floats([1j], "a"), "a: expected an array of real numbers"),
    "objects": (lambda: _validate.floats([None, np.ones((9, 9))], "a"), "a: expected an array of real numbers"),
    "nan": (lambda: _validate.finite([1, np.nan, np.inf], "a"), r"a: expected finite numbers, got 2 NaN .* of 3"),
    "no vectors": (lambda: _validate.vectors([[1, 2]], "a"), r"a: expected vectors of shape \(\.\.\., 3\), got an"),
    "a number": (lambda: _validate.vectors(1, "a"), r"a: expected vectors of shape \(\.\.\., 3\), got an"),
    "no direction": (lambda: _validate.directions([[1, 0, 0], [0, 0, 0]], "a"), "a: expected directions, got a vector"),
    "not unit": (
        lambda: _validate.unit_normals([[0, 0, 1], [0, 3, 4]], "a"),
        "a: expected unit .* got one of length 5",
    ),
    "huge": (lambda: _validate.unit_normals([[1e200, 0, 0]], "a"), "a: expected unit vectors, got one of length inf"),
    "four channels": (lambda: _validate.image(np.ones((2, 2, 4)), "a"), r"a: expected an image of shape .*\(2, 2, 4\)"),
    "a row": (
        lambda: _validate.image(np.ones(3), "a"),
        r"a: expected an image of shape .* got an array of shape \(3,\)",
    ),
    "no pixels": (lambda: _validate.image(np.ones((0, 4)), "a"), r"a: expected an image of shape .*\(0, 4\)"),
    "mask of numbers": (lambda: _validate.mask(np.ones((2, 2)), "a", (2, 2)), "a: expected a boolean mask .* float64"),
    "another mask": (
        lambda: _validate.mask(np.ones((2, 3), bool), "a", (2, 2)),
        r"a: .* shape \(2, 2\), got .*\(2, 3\)",
    ),
    "empty mask": (lambda: _validate.mask(np.zeros((2, 2), bool), "a", (2, 2)), "a: expected at least one pixel"),
    "positive text": (lambda: _validate.positive("3", "a"), "a: expected a number above 0, got str '3'"),  # type: ignore[arg-type]
    "positive bool": (lambda: _validate.positive(True, "a"), "a: expected a number above 0, got bool True"),
    "zero": (lambda: _validate.positive(0, "a"), "a: expected a finite number above 0, got 0"),
    "infinite": (lambda: _validate.positive(np.inf, "a"), "a: expected a finite number above 0, got inf"),
    "beyond floats": (lambda: _validate.positive(10**400, "a"), "a: expected a finite number above 0, got inf"),
    "fraction text": (lambda: _validate.fraction("x", "a"), "a: expected a number from 0 to 1, got str 'x'"),  # type: ignore[arg-type]
    "fraction bool": (lambda: _validate.fraction(False, "a"), "a: expected a number from 0 to 1, got bool False"),
    "above one": (lambda: _validate.fraction(1.5, "a"), "a: expected a number from 0 to 1, got 1.5"),
    "fraction nan": (lambda: _validate.fraction(np.nan, "a"), "a: expected a number from 0 to 1, got nan"),
    "float count": (lambda: _validate.at_least(2.0, 1, "a"), "a: expected an integer of at least 1, got float 2.0"),  # type: ignore[arg-type]
    "bool count": (lambda: _validate.at_least(True, 1, "a"), "a: expected an integer of at least 1, got bool True"),
    "too few": (lambda: _validate.at_least(1, 2, "a"), "a: expected an integer of at least 2, got int 1"),
    "negative seed": (lambda: _validate.generator(-1, "a"), "a: expected an integer of at least 0, got int -1"),
    "seed of text": (lambda: _validate.generator("x", "a"), "a: expected an integer of at least 0, got str 'x'"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("call", "message"), WRONG.values(), ids=WRONG)
def test_the_wrong_thing_is_refused_in_one_line(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_floats_stay_as_they_are(dtype: type) -> None:
    array = np.arange(3, dtype=dtype)
    assert _validate.floats(array, "a") is array


@pytest.mark.parametrize("dtype", [np.uint8, np.int64, np.bool_, np.float16])
def test_other_numbers_become_double(dtype: type) -> None:
    made = _validate.floats(np.array([0, 1], dtype), "a")
    assert made.dtype == np.float64
    assert made.tolist() == [0.0, 1.0]


def test_what_came_is_told_in_one_short_line() -> None:
    assert _validate.describe([np.eye(3), "x"]).startswith("list [array([[1., 0., 0.], [0., 1., 0.]")
    assert len(_validate.describe("x" * 1000)) == 120


@settings(deadline=None, max_examples=50)
@given(
    hnp.arrays(np.float64, (3,), elements=st.floats(-1e3, 1e3)).filter(lambda v: np.abs(v).max() > 1e-3),
    st.integers(-300, 300),
)
def test_directions_have_unit_length_at_any_scale(vector: np.ndarray, exponent: int) -> None:
    unit = _validate.directions(vector * 10.0**exponent, "a")
    np.testing.assert_allclose(unit, vector / np.linalg.norm(vector), atol=1e-12)


def test_numbers_come_back() -> None:
    assert _validate.positive(np.float32(0.5), "a") == 0.5
    assert _validate.fraction(1, "a") == 1.0
    assert _validate.at_least(np.int16(3), 3, "a") == 3
    assert _validate.vectors([[0, 1, 2]], "a").shape == (1, 3)
    assert _validate.image(np.ones((2, 3, 3)), "a").shape == (2, 3, 3)
    assert _validate.mask(np.eye(2, dtype=bool), "a", (2, 2)).tolist() == [[True, False], [False, True]]
    assert _validate.unit_normals(np.zeros((0, 3)), "a").shape == (0, 3)


def test_a_generator_stays_itself_and_a_number_seeds_one() -> None:
    generator = np.random.default_rng(3)
    assert _validate.generator(generator, "a") is generator
    assert _validate.generator(3, "a").random() == np.random.default_rng(3).random()
