"""All methods by name."""

from __future__ import annotations

import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.registry import ESTIMATORS, estimator


@pytest.mark.parametrize("name", ESTIMATORS)
def test_methods_are_fresh_and_told_the_shape(name: str) -> None:
    one, other = estimator(name, (96, 84)), estimator(name, (96, 84))
    assert one is not other and type(one) is type(other)
    assert one.get_params().get("image_shape", (96, 84)) == (96, 84)


def test_the_published_methods_are_all_there() -> None:
    published = "correlation eigenfaces eigenfaces_minus3 linear3 cone_attached harmonic9 nine_points_simulated"
    assert set(published.split()) | {"harmonic_shadowed", "gradient_angle", "nine_points_real", "exemplar"} <= set(
        ESTIMATORS
    )


def test_parameters_reach_the_method() -> None:
    assert estimator("eigenfaces_minus3").get_params()["drop_first"] == 3
    assert estimator("cone_attached", directions=12).get_params()["directions"] == 12


def test_another_name_is_refused() -> None:
    with pytest.raises(HarmonicFaceError, match=r"method: expected one of correlation, .*, got 'eyes'"):
        estimator("eyes")
