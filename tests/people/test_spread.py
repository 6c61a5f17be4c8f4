import importlib.util
from pathlib import Path

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.people.ict import ict_people
from harmonicface.people.spread import albedo_spread, common_mask, normal_spread
from harmonicface.people.synthetic import synthetic_people
from harmonicface.surfaces.surface import Surface

SCRIPT = Path(__file__).parents[2] / "scripts" / "people_spread.py"


def wall(tilt=0.0, albedo=0.5, shape=(4, 4)):
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    return Surface(np.tile(normal, (*shape, 1)), np.broadcast_to(albedo, shape).astype(float))


def test_spread_of_two_tilted_walls():
    spread = normal_spread([wall(0.1), wall(-0.1)])
    assert np.isclose(spread.rms, np.degrees(0.1)) and np.isclose(spread.mean, np.degrees(0.1))
    assert np.allclose(spread.map, np.degrees(0.1))


def test_spread_of_the_same_wall_is_nothing():
    assert normal_spread([wall(0.3)] * 3).rms < 1e-6


def test_tone_alone_is_no_spread_between_normalized_people():
    spread = albedo_spread([wall(albedo=0.4), wall(albedo=0.6)])
    assert np.isclose(spread.between, 0) and np.isclose(spread.contrast, 0)
    assert np.isclose(spread.tone, np.std([0.4, 0.6], ddof=1) / 0.5)


def test_spread_of_stripes():
    stripes = np.tile([0.9, 1.1], (4, 2)) / 2
    spread = albedo_spread([wall(albedo=stripes), wall(albedo=stripes[:, ::-1])])
    assert np.isclose(spread.between, np.std([0.9, 1.1], ddof=1)) and np.isclose(spread.contrast, 0.1)


def test_only_common_pixels_count():
    half = np.zeros((4, 4), bool)
    half[:2] = True
    assert common_mask([wall(), wall()], half).sum() == 8
    assert np.isnan(normal_spread([wall(0.1), wall()], half).map[3]).all()


def test_bad_people():
    with pytest.raises(HarmonicFaceError, match="expected at least two Surfaces, got 1"):
        normal_spread([wall()])
    with pytest.raises(HarmonicFaceError, match="expected Surfaces of one shape"):
        albedo_spread([wall(), wall(shape=(4, 5))])
    with pytest.raises(HarmonicFaceError, match="expected pixels that all of them have"):
        common_mask([wall(), wall()], np.zeros((4, 4), bool))


def test_synthetic_people_spread_as_when_they_were_measured():
    people = list(synthetic_people(60, 48, seed=7))
    shape, albedo = normal_spread(people), albedo_spread(people)
    assert 9.5 < shape.rms < 13.5 and 7.0 < shape.mean < 9.7
    assert 0.14 < albedo.between < 0.24
    assert 0.13 < albedo.tone < 0.21


@pytest.mark.data
def test_synthetic_people_spread_like_real_ones(data_dir):
    spec = importlib.util.spec_from_file_location("people_spread", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    ours = list(synthetic_people(80, 64, seed=1))
    ict = ict_people(data_dir / "heads/ICT-FaceKit/FaceXModel", 30, albedo="uniform")
    yale = script.yale_people(data_dir / "yaleb", 64)
    pixels = common_mask([*ours, *ict])
    shape, real_shape = normal_spread(ours, pixels), normal_spread(ict, pixels)
    assert 0.8 < shape.rms / real_shape.rms < 1.2 and 0.8 < shape.mean / real_shape.mean < 1.2
    pixels = common_mask([*ours, *yale])
    albedo, real_albedo = albedo_spread(ours, pixels), albedo_spread(yale, pixels)
    for name in ("between", "contrast", "tone"):
        assert 0.8 < getattr(albedo, name) / getattr(real_albedo, name) < 1.2, name
