import numpy as np

from harmonicface.people.traits import LARGEST, TRAITS, draw_head


def test_traits_have_the_spread_and_bounds_of_their_table():
    rng = np.random.default_rng(1)
    heads = [draw_head(rng) for _ in range(2000)]
    values = np.array([head.values for head in heads])
    spreads = np.array([trait.spread for trait in TRAITS])
    ratio = values.std(axis=0) / spreads
    assert (np.abs(ratio - 0.92) < 0.1).all()  # the soft limit takes a little
    assert (np.abs(values) < LARGEST * spreads).all()
    assert np.abs(values.mean(axis=0) / spreads).max() < 0.1


def test_traits_follow_masculinity_and_age():
    rng = np.random.default_rng(2)
    heads = [draw_head(rng) for _ in range(2000)]
    values = np.array([head.values for head in heads])
    for name, factor in (("masculine", [head.masculine for head in heads]), ("age", [head.age for head in heads])):
        wanted = np.array([getattr(trait, name) for trait in TRAITS])
        found = np.array([np.corrcoef(column, factor)[0, 1] for column in values.T])
        assert np.abs(found - wanted).max() < 0.12


def test_names_are_unique():
    assert len({trait.name for trait in TRAITS}) == len(TRAITS)
