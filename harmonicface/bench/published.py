"""Published error rates on Yale B: as printed, on how many photographs, and beside which of our methods they belong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from harmonicface.recognition.intervals import Rate, rate

LEE = (
    "Lee, Ho & Kriegman 2005, table of 450 photographs of ten people, subset 1 among them; their faces are cropped "
    "more closely than the data set's, which helps methods that compare photographs here"
)
XIE = "Xie, Zheng, Lai, Yuen & Suen 2011; 38 people, photographs counted as in the data set"
TRIGGS = "preprocessing of Tan & Triggs 2010, then local binary patterns; 38 people, counted as in the data set"
WRIGHT = "Wright, Yang, Ganesh, Sastry & Ma 2009; about 1,207 photographs of 38 people"
BEST_HALF = "best that has been reported for a random half; counted as the former"

# Why our error lies outside the published interval, by our method; of the same photographs cut to 112 x 96 pixels of
# the face alone, at 42 x 36, correlation misses 26.0 %, Eigenfaces 26.0 and 24.7 without three, three dimensions 6.0.
WIDER = "the data set's crop shows outline and hair, which help; with the face alone {:.1f} % as measured, {}"
DIFFERENCES = {
    "correlation": WIDER.format(26.0, "inside"),
    "eigenfaces": WIDER.format(26.0, "one photograph below"),
    "eigenfaces_minus3": WIDER.format(24.7, "inside"),
    "linear3": WIDER.format(6.0, "inside"),
}

TEN_PEOPLE = {"1-4": 450}
EVERYBODY = {"2": 456, "3": 455, "4": 526, "5": 714}  # photographs of 38 people, without those that are damaged
HALF = {"1-5": 1207}


@dataclass(frozen=True)
class Published:
    """A row of a published table.

    Parameters
    ----------
    name
        What the literature calls the method.
    train
        The protocol.
    ours
        The method of this package that stands beside it.
    error_percent
        As printed, by subset or range of subsets.
    n
        On how many photographs each.
    source
        Who reports it, and how photographs are counted.
    """

    name: str
    train: str
    ours: str
    error_percent: Mapping[str, float]
    n: Mapping[str, int]
    source: str

    def rate(self, subsets: str) -> Rate:
        """Return the published error with its 95 % interval: of the whole number of errors nearest to it.

        Examples
        --------
        >>> str(published("subset1")[0].rate("1-4"))
        '29.1 % (25 to 33.5)'
        """
        count = self.n[subsets]
        return rate(round(self.error_percent[subsets] / 100 * count), count)


def published(train: str) -> list[Published]:
    """Return what the literature reports for a protocol; nothing for those that are ours alone.

    Examples
    --------
    >>> [row.name for row in published("nine-lights")]
    ['nine points of light, real']
    """
    return [row for row in ROWS if row.train == train]


def explained(train: str, rows: Sequence[Sequence[str]]) -> dict[str, str]:
    """Return why ours differ, by the published names, for those rows of a table whose last cell says that they do.

    Examples
    --------
    >>> list(explained("subset1", [["correlation", "1-4", "29.1", "19.1", "fewer"], ["Eigenfaces", "as many"]]))
    ['correlation']
    """
    beyond = {row[0] for row in rows if row[-1] in ("fewer", "more")}
    return {
        row.name: DIFFERENCES[row.ours] for row in published(train) if row.name in beyond and row.ours in DIFFERENCES
    }


def _ten_people(name: str, ours: str, percent: float, train: str = "subset1") -> Published:
    """Return a row of the table of 450 photographs."""
    return Published(name, train, ours, {"1-4": percent}, TEN_PEOPLE, LEE)


def _single(name: str, ours: str, percents: tuple[float, ...], source: str) -> Published:
    """Return a row for one frontal photograph a person."""
    return Published(name, "frontal", ours, dict(zip(EVERYBODY, percents, strict=True)), EVERYBODY, source)


ROWS = (
    _ten_people("correlation", "correlation", 29.1),
    _ten_people("Eigenfaces", "eigenfaces", 30.4),
    _ten_people("Eigenfaces, without three", "eigenfaces_minus3", 25.8),
    _ten_people("3-D linear subspace", "linear3", 4.6),
    _ten_people("cone, attached shadows", "cone_attached", 2.7),
    _ten_people("harmonic images, attached", "harmonic9", 1.1),
    _ten_people("nine points, simulated", "nine_points_simulated", 0.87),
    _ten_people("harmonic images, cast", "harmonic_shadowed_fixed", 0.85),
    _ten_people("gradient angle", "gradient_angle", 0.44),
    _ten_people("cone, cast shadows", "cone_cast", 0.0),
    _ten_people("nine points of light, real", "nine_points_real", 0.0, "nine-lights"),
    _single("RLS(LOG-DCT)", "default", (0.0, 12.9, 12.4, 15.2), XIE),
    _single("Tan-Triggs, LBPH", "tan_triggs", (0.0, 0.9, 12.5, 17.4), TRIGGS),
    Published("sparse representation", "random-half", "default", {"1-5": 1.9}, HALF, WRIGHT),
    Published("best reported", "random-half", "default", {"1-5": 0.7}, HALF, BEST_HALF),
)
