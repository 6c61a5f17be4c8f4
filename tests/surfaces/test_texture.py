"""Texture lookup: texel centres, repetition, averages."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.surfaces.texture import look_up, shrink_to_density

TEXTURE = np.random.default_rng(0).random((4, 6, 3))


def test_texel_centres_give_the_texels():
    rows, columns = np.mgrid[:4, :6]
    uv = np.stack([(columns + 0.5) / 6, 1 - (rows + 0.5) / 4], axis=2).reshape(-1, 2)
    np.testing.assert_allclose(look_up(TEXTURE, uv), TEXTURE.reshape(-1, 3), atol=1e-6)


@given(st.floats(0, 1), st.floats(0, 1), st.integers(-3, 3), st.integers(-3, 3))
def test_it_repeats_in_both_directions(u, v, tile_u, tile_v):
    here, there = look_up(TEXTURE, np.array([[u, v], [u + tile_u, v + tile_v]]))
    np.testing.assert_allclose(here, there, atol=1e-6)


def test_between_texels_it_is_bilinear():
    # the border between the top left texel and its three neighbours
    corner = look_up(TEXTURE, np.array([[1 / 6, 1 - 1 / 4]]))[0]
    np.testing.assert_allclose(corner, TEXTURE[:2, :2].mean(axis=(0, 1)), atol=1e-6)


def test_shrinking_averages():
    fine = np.kron(TEXTURE, np.ones((4, 4, 1))) + np.tile([[-0.1, 0.1], [0.1, -0.1]], (8, 12))[..., None]
    np.testing.assert_allclose(shrink_to_density(fine, 4.0), TEXTURE, atol=1e-12)
    assert shrink_to_density(TEXTURE, 0.3) is TEXTURE
    np.testing.assert_allclose(shrink_to_density(TEXTURE, 1e9), [[TEXTURE.mean(axis=(0, 1))]], atol=1e-12)
