"""Which function answers for a method under comparison: it is seen to be called when the method is timed."""

from __future__ import annotations

import cv2
from sklearn.metrics.pairwise import additive_chi2_kernel

from harmonicface.bench.contenders import Contender, GalleryContender, PhotographContender
from harmonicface.bench.timing import Stopwatch
from harmonicface.bench.watching import Function
from harmonicface.bench.yale_contenders import ClassifierContender
from harmonicface.gallery.gallery import Gallery
from harmonicface.recognition.baselines import Baseline
from harmonicface.recognition.estimators.local_patterns import LocalBinaryPatterns
from harmonicface.recognition.opencv import Eigenfaces, Fisherfaces
from harmonicface.recognition.opencv import LocalBinaryPatterns as OpenCVPatterns

OPENCV = (Eigenfaces, Fisherfaces, OpenCVPatterns)


def called_by(contender: Contender) -> tuple[Function, ...]:
    """Return the functions that a method cannot do without when it is asked.

    Examples
    --------
    >>> from harmonicface.bench.contenders import contender
    >>> [function.__qualname__ for function in called_by(contender("lbph"))]
    ['FaceRecognizer.predict']
    """
    if isinstance(contender, GalleryContender):
        return (Gallery.match,)
    if isinstance(contender, PhotographContender) and _asks_opencv(contender.baseline):
        return (cv2.face.FaceRecognizer.predict,)
    if isinstance(contender, ClassifierContender) and contender.kind is LocalBinaryPatterns:
        return (cv2.face.LBPHFaceRecognizer.getHistograms, additive_chi2_kernel)
    return (type(contender).nearest,)


def stopwatch_of(name: str, contender: Contender) -> Stopwatch:
    """Return a stopwatch for asking a method, with its name beside that of the function."""
    return Stopwatch(*called_by(contender), about=name)


def _asks_opencv(baseline: Baseline) -> bool:
    """Say whether OpenCV itself answers: eigenfaces without the first ones compare by themselves."""
    return isinstance(baseline, OPENCV) and not getattr(baseline, "_drop_first", 0)
