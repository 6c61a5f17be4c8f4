"""All classifiers by the names that tables use."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import FaceClassifier
from harmonicface.recognition.estimators.correlation import Correlation
from harmonicface.recognition.estimators.eigenfaces import Eigenfaces
from harmonicface.recognition.estimators.exemplar import Exemplar
from harmonicface.recognition.estimators.fisherfaces import Fisherfaces
from harmonicface.recognition.estimators.gradient_angle import GradientAngle
from harmonicface.recognition.estimators.harmonic import Harmonic9, HarmonicShadowed
from harmonicface.recognition.estimators.illumination_cone import ConeAttached, ConeCast
from harmonicface.recognition.estimators.linear import Ambient4, Linear3
from harmonicface.recognition.estimators.local_patterns import LocalBinaryPatterns
from harmonicface.recognition.estimators.nine_points import NinePointsReal, NinePointsSimulated
from harmonicface.recognition.estimators.nonnegative_light import HarmonicNonnegative
from harmonicface.recognition.estimators.principal import Pca3, Pca5, PcaAuto
from harmonicface.recognition.estimators.tan_triggs import TanTriggs

FROM_PHOTOGRAPHS: dict[str, Callable[..., FaceClassifier]] = {
    "correlation": Correlation,
    "eigenfaces": Eigenfaces,
    "eigenfaces_minus3": partial(Eigenfaces, drop_first=3),
    "fisherfaces": Fisherfaces,
    "lbph": LocalBinaryPatterns,
    "tan_triggs": TanTriggs,
    "gradient_angle": GradientAngle,
    "nine_points_real": NinePointsReal,
    "exemplar": Exemplar,
}
FROM_SURFACES: dict[str, Callable[..., FaceClassifier]] = {
    "linear3": Linear3,
    "ambient4": Ambient4,
    "harmonic9": Harmonic9,
    "pca3": Pca3,
    "pca5": Pca5,
    "pca_auto": PcaAuto,
    "harmonic9_nonnegative": HarmonicNonnegative,
    "harmonic_shadowed": HarmonicShadowed,
    "cone_attached": ConeAttached,
    "cone_cast": ConeCast,
    "nine_points_simulated": NinePointsSimulated,
}
ESTIMATORS = {**FROM_PHOTOGRAPHS, **FROM_SURFACES}


def estimator(name: str, image_shape: tuple[int, int] | None = None, **parameters: Any) -> FaceClassifier:
    """Return a new classifier of that name.

    Parameters
    ----------
    name
        One of `ESTIMATORS`.
    image_shape
        (h, w) of the photographs, for methods that need to know.
    parameters
        Those of the class.

    Raises
    ------
    HarmonicFaceError
        There is no method of that name.

    Examples
    --------
    >>> estimator("eigenfaces_minus3", (96, 84))
    Eigenfaces(drop_first=3)
    """
    if name not in ESTIMATORS:
        raise HarmonicFaceError(f"method: expected one of {', '.join(ESTIMATORS)}, got {name!r}")
    make = ESTIMATORS[name]
    classifier = make(**parameters)
    if "image_shape" in classifier.get_params():
        classifier.set_params(image_shape=image_shape)
    return classifier
