"""What answers for a method is what its contender calls."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.benchmark import BenchmarkResult
from harmonicface.bench.contenders import Contender, contender
from harmonicface.bench.peers import called_by, stopwatch_of
from harmonicface.bench.table import method_records
from harmonicface.bench.yale_contenders import yale_contender

NAMES = {
    "harmonic9": "harmonicface.Gallery.match, harmonic9",
    "lbph": "cv2.face.FaceRecognizer.predict, lbph",
    "eigenfaces": "cv2.face.FaceRecognizer.predict, eigenfaces",
    "eigenfaces_minus3": "harmonicface.bench.contenders.PhotographContender.nearest, eigenfaces_minus3",  # its own
    "correlation": "harmonicface.bench.contenders.PhotographContender.nearest, correlation",
}


def test_the_table_of_the_benchmark_says_what_was_called(small_run: BenchmarkResult) -> None:
    records = {record.name: record for record in method_records(small_run)}
    assert {name: records[name].call for name in NAMES} == NAMES
    assert records["lbph"].versions["opencv-contrib-python-headless"]
    assert all(record.seed == 0 for record in records.values())


def test_the_classifier_of_the_same_name_calls_something_else() -> None:
    """Its distance to every photograph is needed for ROC curves, which `predict` does not give."""
    found = stopwatch_of("lbph", yale_contender("lbph"))
    assert found.timing(len).name == (
        "cv2.face.LBPHFaceRecognizer.getHistograms + sklearn.metrics.pairwise.additive_chi2_kernel, lbph"
    )
    with pytest.raises(hf.HarmonicFaceError, match=r"getHistograms, .*additive_chi2_kernel, got none"):
        found.run(lambda: np.ones(2))


@pytest.mark.parametrize("made", [contender, yale_contender])
def test_every_contender_has_something_that_answers_for_it(made: object) -> None:
    one: Contender = made("correlation")  # type: ignore[operator]
    assert called_by(one) == (type(one).nearest,)
