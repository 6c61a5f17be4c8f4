"""The plan of photographs: known and unknown lights by difficulty, written down before any row was run."""

from __future__ import annotations

from harmonicface.bench.stability.row import SCALES, planned

HARMLESS_PHOTOGRAPHS = (
    "nothing hard", "all lamps on a cone", "one lamp for half of the photographs", "every photograph twice",
    "no shadows at all", "half the pixels in cast shadow", "saturated highlights", "broad saturated highlights",
    "black patches, with noise", "black patches, without noise", "NaN outside the mask", "16 bits", "8 bits",
    "8 bits, a twentieth of the range", *SCALES, "float32", "lamps of 1 : 100, told", "lamps of 1 : 100, not told",
    "one image of another scene", "not registered by up to 1 pixel", "one image moved by 1 pixel", "skies",
    "skies: one image of another scene",
)  # fmt: skip
HOPELESS_PHOTOGRAPHS = (
    "two images only", "all lamps in a plane with the camera", "one lamp for all photographs", "NaN inside the mask",
    "constant images", "black images", "nothing but noise", "skies: two images only",
    "skies: one for all photographs",
)  # fmt: skip
EQUAL_LAMPS = ("equal lamps, told", "one image of another scene, equal lamps told")
SKIES = ("skies", "skies: one image of another scene", "skies: two images only", "skies: one for all photographs")
WITH_INTENSITIES = ("lamps of 1 : 100, told", "lamps of 1 : 100, said to be equal")
HARD_PHOTOGRAPHS = (
    "three images", "four images", "all lamps within a degree of a plane", "a planar object", "a mask of 9 pixels",
    "one black image", "lamps of 1 : 100, said to be equal",
)  # fmt: skip
ALL_PHOTOGRAPHS = (*HARMLESS_PHOTOGRAPHS, *HARD_PHOTOGRAPHS, *HOPELESS_PHOTOGRAPHS, "lamps within 5 degrees")

# Matte photographs under unknown lights are those of a whole family of surfaces (Belhumeur, Kriegman & Yuille, The
# Bas-Relief Ambiguity, 1999): no unique answer, so that none of these rows is well-posed. This was corrected after the
# first run: the plan had called the harmless ones well-posed, of which "one lamp for half of the photographs" and "half
# the pixels in cast shadow" were refused. What is asked of their answers has not changed.
PHOTOGRAPHS = (
    *planned(
        "photometric_stereo, lights known",
        (*HARMLESS_PHOTOGRAPHS, *HARD_PHOTOGRAPHS, "one direction wrong", "skies: four images"),
        (*HOPELESS_PHOTOGRAPHS, "lamps within 5 degrees", "left and right confused in all"),
    ),
    *planned(
        "photometric_stereo, lamps unknown",
        ill=[*(case for case in ALL_PHOTOGRAPHS if case not in SKIES), *EQUAL_LAMPS],
        slow=True,
    ),
    *planned(
        "photometric_stereo, any light unknown",
        ill=[case for case in ALL_PHOTOGRAPHS if case not in WITH_INTENSITIES],
        slow=True,
    ),
)
