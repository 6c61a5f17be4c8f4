"""The plan: the matrix of solver by difficulty, written down before any row was run, and what is well-posed in it."""

from __future__ import annotations

from harmonicface.bench.stability.plan_of_photographs import PHOTOGRAPHS
from harmonicface.bench.stability.row import SCALES, Planned, planned


def plan() -> tuple[Planned, ...]:
    """Return all rows, family by family.

    Examples
    --------
    >>> rows = plan()
    >>> len(rows) >= 120, len(rows) == len({(row.solver, row.case) for row in rows})
    (True, True)
    """
    return tuple(row for rows in FAMILIES.values() for row in rows)


SPANS = (
    "independent pictures", "nearly dependent at 1e-04", "nearly dependent at 1e-06", "nearly dependent at 1e-08",
    "nearly dependent at 1e-10", "nearly dependent at 1e-12", "nearly dependent at 1e-14", "dependent pictures",
    "one picture nine times", "one picture 1e-12 of the others", *SCALES, "times 1e-300", "times 1e+300",
    "float32 pictures", "float32, nearly dependent at 1e-04", "float32, times 1e-40 (subnormal)", "one pixel",
)  # fmt: skip

# Of these no digit is left, by the condition that is reported and true. This was corrected after the first run: the
# plan had called them well-posed, and any answer would have been right. What is asked of them has not changed.
FAINT = ("nearly dependent at 1e-14",)
FAINTER = ("nearly dependent at 1e-12", *FAINT, "float32, nearly dependent at 1e-04")

HARMONICS = (
    *planned(
        "real_harmonics",
        (
            "order 2", "order 2, float32", "order 8, axes and poles", "order 8, 1e-04 from a pole",
            "order 8, 1e-08 from a pole", "order 8, 1e-14 from a pole", "order 8, a subnormal number from a pole",
            "order 8, one direction repeated", "order 64", "order 64, float32", "order 200", "no directions",
        ),
        ("vectors of 1e-12", "vectors of 1e+12", "vectors of 1e-310 (subnormal)", "NaN"),
    ),
    *planned(
        "harmonic_images",
        (
            "albedo times 1e-12", "albedo times 1e+12", "albedo times 1e-300", "albedo times 1e+300",
            "albedo of 1e-310 (subnormal)", "float32 albedo of 1e-40 (subnormal)", "float32", "one pixel",
            "every other pixel black",
        ),
        ("an empty mask",),
    ),
)  # fmt: skip

ROTATION = planned(
    "rotate",
    (
        "by nothing", "half a turn about x", "half a turn about y", "half a turn about z", "1e-04 about y",
        "1e-08 about y", "1e-14 about y", "1e-300 about y", "order 2", "order 64", "order 64, float32", *SCALES,
        "times 1e-300", "times 1e+300", "times 1e-310 (subnormal)", "black", "a matrix rounded to float32",
        "a matrix off by 1e-06",
    ),
    ("a matrix off by 1e-04", "a mirror", "a singular matrix", "no coefficients", "NaN"),
)  # fmt: skip

PROJECTION = (
    *planned(
        "Subspace.distance",
        (
            *(case for case in SPANS if case not in FAINT), "a photo in the span",
            "a photo 1e-05 off the span", "a photo of 1e-300", "a photo of 1e+300",
            "a photo of 1e-310 (subnormal)",
        ),
        (*FAINT, "pictures of 1e+12 and 1e-12", "black pictures", "a black photo", "NaN"),
    ),
    *planned(
        "Subspace.coefficients",
        [case for case in SPANS if case not in FAINTER],
        (*FAINTER, "pictures of 1e-310 (subnormal)"),
    ),
    *planned(
        "Subspace.restrict",
        ("half of the pixels", "as many pixels as pictures", "fewer pixels than pictures"),
        ("no pixel",),
    ),
)  # fmt: skip

INVERSE_LIGHT = (
    *planned(
        "estimate_light",
        (
            "all normals", "all normals, float32", "half of the sphere", *SCALES, "times 1e-100", "times 1e+100",
            "albedo times 1e-12", "albedo times 1e+12", "every other pixel black", "noise of 1 %", "a black photo",
            "every pixel twice",
        ),
        (
            "normals within 0.1", "normals within 1e-02", "normals within 1e-04", "normals within 1e-08", "a wall",
            "two normals", "one pixel, its noise told", "one pixel", "an empty mask", "all saturated", "NaN",
            "no albedo",
        ),
    ),
    *planned(
        "nonnegative_light",
        ("six lamps", "two lamps 1e-02 apart", "two lamps 1e-04 apart", *SCALES, "a black photo"),
        ("two lamps 1e-08 apart", "one lamp twice", "an empty mask"),
    ),
)  # fmt: skip

KNOWN_LIGHTS = (
    *planned(
        "scaled_normals",
        (
            "lamps along the axes", "any lamps", "lamps within 1e-02 of a plane", "lamps within 1e-04 of a plane",
            *SCALES, "times 1e-300", "times 1e-310 (subnormal)", "lamps times 1e-12", "lamps times 1e+12",
            "lamps times 1e-60", "lamps times 1e+60", "float32", "three of ten photos to be used",
        ),
        (
            "lamps within 1e-08 of a plane", "lamps in a plane", "one lamp for all photos", "one of three lamps 1e-12",
            "no photo to be used",
        ),
    ),
    *planned(
        "plain_least_squares",
        (
            "any lamps", "lamps within 1e-04 of a plane", "lamps within 1e-08 of a plane",
            "lamps within 1e-12 of a plane", *SCALES, "lamps times 1e-12", "lamps times 1e+12",
            "one of ten lamps 1e-12", "float32",
        ),
        ("lamps in a plane", "one lamp for all photos"),
    ),
    *planned(
        "calibrated_stereo",
        ("any lamps", *SCALES, "times 1e-30", "times 1e+30", "float32", "shadows", "one pixel"),
        ("lamps within 1e-04 of a plane", "lamps in a plane", "black photos", "an empty mask", "NaN"),
    ),
    *planned("general_light_normals", ("any lights", *SCALES), ("one light for all photos",)),
)  # fmt: skip

UNKNOWN_LIGHTS = planned(
    "linear_factors",
    ("any lamps", *SCALES, "times 1e-100", "times 1e+100", "float32", "every photo twice"),
    ("lamps within 1e-05 of a plane", "lamps in a plane", "one lamp for all photos", "black photos", "two photos"),
)

FACTORS = planned(
    "leading_factors",
    (
        "a third value of 1e-01", "a third value of 1e-02", "a third value of 1e-04", "a third value of 1e-06",
        "a third value of 1e-02, float32", "a third value of 1e-04, float32", "a third value of 1e-04, read once",
        *SCALES, "times 1e-200", "times 1e+200", "float32, times 1e-30", "float32, times 1e+30", "every photo twice",
        "one pixel", "two of three factors",
    ),
    (
        "a third value of 1e-08", "a third value of 1e-10", "a third value of 1e-14", "a third value of 0",
        "black photos", "no pixels", "NaN",
    ),
)  # fmt: skip

LIGHT_FIELD = planned(
    "factor_light_field",
    ("any light", *SCALES, "times 1e-200", "times 1e+200", "light of degree 2 times 1e-04", "a BRDF of 1e-04 at l = 2"),
    (
        "light of degree 2 times 1e-10", "light of degree 2 times 1e-14", "no light of degree 2",
        "no light of degree 0", "dark", "NaN",
    ),
)  # fmt: skip

DEPTH = (
    *planned(
        "integrate_normals",
        (
            "a plane", "a plane, 256 x 256", "a plane, float32", "a plane in a ragged mask", "a plane in two parts",
            "a line of pixels", "one pixel", "a slope of 1e-12", "a slope of 5.6 (80 degrees)",
            "pixels of 1e-12", "pixels of 1e+12", "pixels of 1e-300", "pixels of 1e+300", "trust from 1 to 1e-04",
            "trust from 1 to 1e-08", "trust from 1 to 1e-12", "trust of 1e-300", "trust of 1e+300",
        ),
        ("pixels that touch no other", "an empty mask", "a normal away from the camera", "NaN"),
    ),
    *planned(  # added after the first run, before these rows were run
        "integrate_perspective",
        (
            "a plane", "a plane, float32", "a plane in a ragged mask", "a distance of 1e-12", "a distance of 1e+12",
            "a distance of 1e-300", "a distance of 1e+300", "trust from 1 to 1e-08", "trust of 1e-300",
            "trust of 1e+300",
        ),
        ("an empty mask",),
    ),
    *planned(
        "depth_from_steps",
        (
            "steps that disagree", "steps that disagree, weights from 1 to 1e-04",
            "steps that disagree, weights from 1 to 1e-08", "steps that disagree, weights from 1 to 1e-12",
            "steps times 1e-300", "steps times 1e+300", "steps of 1e-310 (subnormal)", "a cut through the middle",
        ),
    ),
)  # fmt: skip

SURFACES = (
    *planned(
        "harmonic images",
        (
            "all normals equal (a wall)", "a mask of 9 pixels or fewer (9)", "a mask of 9 pixels or fewer (1)",
            "albedo zero in places", "grazing normals (z from 0 to 1e-3)", "a mesh times 0.001",
            "a mesh times 1000", "a mesh 1e+06 away from the origin", "float32 against float64",
        ),
    ),
    *planned(
        "harmonic images with shadows",
        ("a mesh times 0.001", "a mesh times 1000", "a mesh 1e+06 away from the origin"),
    ),
    *planned(
        "transport",
        (
            "all normals equal (a wall)", "a mask of 9 pixels or fewer (9)", "a mask of 9 pixels or fewer (1)",
            "float32 against float64",
        ),
    ),
    *planned(  # added after the first run, before these rows were run
        "transport of a ball",
        ("times 1e-12", "times 1e+12", "times 1e-100", "times 1e+100", "upon a height of 1e+06"),
    ),
    *planned(  # added as no shadow falls on a wall or a ball, before these rows were run
        "transport of a dent",
        ("times 1e-12", "times 1e+12", "times 1e-100", "times 1e+100", "upon a height of 1e+06"),
    ),
    *planned(
        "render",
        (
            "all normals equal (a wall)", "grazing normals (z from 0 to 1e-3)", "1e6 : 1 dynamic range, float64",
            "1e6 : 1 dynamic range, float32", "float32 against float64",
        ),
    ),
    *planned("normals", ("grazing depth", "a spike one pixel wide", "depth with steps and holes")),
    *planned("horizon", ("a spike one pixel wide", "depth with steps")),
    *planned(
        "horizons",
        (
            "a step times 1e-12", "a step times 1e+12", "a step times 1e-100", "a step times 1e+100",
            "a step upon a height of 1e+08", "a step of 1e-12 pixels", "a step of 1e+12 pixels",
            "a step of 1e-310 (subnormal)", "one pixel",
        ),
        ("an empty mask", "infinite depth in the mask"),
    ),
)  # fmt: skip

PRINCIPAL = planned(
    "analytic_pca",
    (
        "a ball", "a ball, float32", "albedo times 1e-12", "albedo times 1e+12", "albedo times 1e-100",
        "albedo times 1e+100", "every other pixel black", "every pixel twice", "normals within 0.1",
        "normals within 1e-02", "normals within 1e-04", "normals within 1e-08", "a wall", "one pixel",
    ),
    ("no albedo", "an empty mask", "no components"),
)  # fmt: skip

SEARCH = (
    *planned(
        "search",
        (
            "a crowd", "sketches of float16", "people of 1 to 9 rows", "people of one row", "a photo in the span",
            "a photo that nobody explains", "two people 1e-02 apart", "two people 1e-04 apart",
            "two people 1e-06 apart", "one person seven times", "a basis of one row", "a basis of everything",
            "a basis that sees nobody", "rows off orthonormal by 1e-03", "a photo of 1e-300", "a photo of 1e+300",
            "a photo of 1e-310 (subnormal)",
        ),
        ("rows not orthonormal", "a basis not orthonormal", "a black photo", "NaN"),
    ),
    *planned(
        "bound",
        (
            "any person", "nothing left over", "everything left over", "a person within the basis",
            "a person outside the basis", "products of 1e-30", "products of 1e-42 (subnormal)",
        ),
    ),
)  # fmt: skip

FAMILIES: dict[str, tuple[Planned, ...]] = {
    "harmonics": HARMONICS,
    "rotation": ROTATION,
    "projection": PROJECTION,
    "inverse light": INVERSE_LIGHT,
    "stereo under known lights": KNOWN_LIGHTS,
    "stereo under unknown lights": UNKNOWN_LIGHTS,
    "factorization of photographs": FACTORS,
    "factorization of light fields": LIGHT_FIELD,
    "integration": DEPTH,
    "surfaces and transport": SURFACES,
    "analytic principal components": PRINCIPAL,
    "search": SEARCH,
    "photographs": PHOTOGRAPHS,
}
