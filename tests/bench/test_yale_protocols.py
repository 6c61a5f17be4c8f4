"""Which photographs are learned from, and which are asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.yale_protocols import PROTOCOLS, published_size, yale_protocol
from harmonicface.datasets.yale_b import YalePerson, light_direction, load_yale_b, subset_of


def person(angles: list[tuple[int, int]], number: int = 1) -> YalePerson:
    """Return somebody under lights of these azimuths and elevations, without pictures."""
    lights = np.array([light_direction(*pair) for pair in angles])
    beside = np.degrees(np.arccos(np.clip(lights[:, 2], -1, 1)))
    subsets = np.array([subset_of(angle) for angle in beside])
    files = tuple(Path(f"{index}.pgm") for index in range(len(angles)))
    return YalePerson(number, np.zeros((len(angles), 2, 2), np.float32), lights, beside, subsets, files)


LIGHTS = [(0, 0), (10, 0), (-5, 10), (20, 10), (-25, 0), (35, 15), (60, 20), (85, 20), (-110, 40), (0, 90)]


@pytest.mark.parametrize(
    ("train", "learned"),
    [("subset1", [0, 1, 2]), ("subset12", [0, 1, 2, 3, 4]), ("frontal", [0])],
)
def test_what_is_learned_from(train: str, learned: list[int]) -> None:
    face = person(LIGHTS)
    (split,) = yale_protocol(train).splits([face])
    assert np.flatnonzero(split.training[0]).tolist() == learned
    asked = np.flatnonzero(split.queries[0]).tolist()
    assert asked == (list(range(10)) if train.startswith("subset") else [i for i in range(10) if i not in learned])


def test_halves_are_random_and_do_not_depend_on_the_others() -> None:
    faces = [person(LIGHTS, number) for number in (1, 2)]
    splits = yale_protocol("random-half").splits(faces)
    assert len(splits) == 10
    for split in splits:
        for training, queries in zip(split.training, split.queries, strict=True):
            assert training.sum() == 5
            np.testing.assert_array_equal(queries, ~training)
    assert len({split.training[0].tobytes() for split in splits}) > 5
    assert any(not np.array_equal(split.training[0], split.training[1]) for split in splits)
    for split, alone in zip(splits, yale_protocol("random-half").splits(faces[1:]), strict=True):
        np.testing.assert_array_equal(split.training[1], alone.training[0])


@pytest.mark.parametrize(
    ("train", "lights"), [("subset1", LIGHTS[5:]), ("frontal", LIGHTS[1:]), ("nine-lights", LIGHTS[:8])]
)
def test_somebody_without_such_photographs(train: str, lights: list[tuple[int, int]]) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"yaleB04: expected photographs with .*, got none"):
        yale_protocol(train).splits([person(LIGHTS), person(lights, 4)])


def test_no_such_protocol() -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"train: expected one of subset1, .*, random-half, got 'all'"):
        yale_protocol("all")


def test_the_published_450() -> None:
    n = {"1": 70, "2": 120, "3": 120, "4": 140, "5": 190}
    assert published_size(range(1, 11), n)
    assert not published_size(range(1, 12), n)
    assert not published_size(range(1, 11), {**n, "1": 60})


@pytest.mark.data
def test_counts_on_the_real_photographs(data_dir: Path) -> None:
    faces = load_yale_b(data_dir / "yaleb", range(1, 11))
    counts = {}
    for name in PROTOCOLS:
        split = yale_protocol(name).splits(faces)[0]
        chosen = [face.subsets[queries] for face, queries in zip(faces, split.queries, strict=True)]
        counts[name] = np.bincount(np.concatenate(chosen), minlength=6)[1:].tolist()
    assert counts["subset1"] == counts["subset12"] == [70, 120, 120, 140, 190]
    assert counts["frontal"] == [60, 120, 120, 140, 190]
    assert sum(counts["nine-lights"]) == 640 - 90
    assert sum(counts["random-half"]) == 320
    nine = yale_protocol("nine-lights").splits(faces)[0].training[0]
    names = [face.stem[12:] for face, chosen in zip(faces[0].files, nine, strict=True) if chosen]
    assert names == sorted(
        ["+000E+00", "+020E-40", "+035E+65", "+070E-35", "+085E+20", "-035E+40", "-070E+45", "-070E-35", "-095E+00"]
    )
