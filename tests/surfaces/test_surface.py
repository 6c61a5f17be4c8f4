"""Surface: what it accepts, and that a saved one comes back bit for bit or not at all."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface


def make(shape=(6, 5), colour=False, depth=True, dtype=np.float64, seed=0):
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(*shape, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    mask = rng.random(shape) < 0.7
    mask[0, 0] = True
    albedo = rng.random((*shape, 3) if colour else shape)
    heights = rng.normal(size=shape).astype(dtype) if depth else None
    return Surface(normals.astype(dtype), albedo.astype(dtype), mask, heights, pixel_size=rng.random() + 0.1)


def same(a, b):
    arrays = [(a.normals, b.normals), (a.albedo, b.albedo), (a.mask, b.mask)]
    arrays += [] if a.depth is None and b.depth is None else [(a.depth, b.depth)]
    return a.pixel_size == b.pixel_size and all(
        x.dtype == y.dtype and x.shape == y.shape and x.tobytes() == y.tobytes() for x, y in arrays
    )


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.booleans(), st.booleans(), st.sampled_from([np.float32, np.float64]), st.integers(0, 1000))
def test_a_saved_surface_comes_back_bit_for_bit(tmp_path, colour, depth, dtype, seed):
    surface = make(colour=colour, depth=depth, dtype=dtype, seed=seed)
    surface.save(tmp_path / "a.npz")
    assert same(surface, Surface.load(tmp_path / "a.npz"))
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_outside_the_mask_there_is_nothing():
    normals, albedo, depth = np.full((2, 2, 3), np.nan), np.full((2, 2), -5.0), np.full((2, 2), np.inf)
    normals[0, 0], albedo[0, 0], depth[0, 0] = [0, 0, 1], 0.5, 7
    surface = Surface(normals, albedo, np.array([[True, False], [False, False]]), depth)
    assert surface.normals[0, 0].tolist() == [0, 0, 1] and surface.normals.sum() == 1
    assert surface.albedo.tolist() == [[0.5, 0], [0, 0]]
    assert np.isnan(surface.depth).sum() == 3
    assert surface.pixel_normals.tolist() == [[0, 0, 1]]
    assert surface.pixel_albedo.tolist() == surface.grey_albedo.tolist() == [0.5]


def test_the_mask_is_where_normals_are_and_arrays_are_copies():
    normals = np.zeros((2, 3, 3))
    normals[0, 1, 2] = 1
    surface = Surface(normals, np.ones((2, 3, 3)) * [1, 0, 0])
    normals[:] = 9
    assert surface.mask.tolist() == [[False, True, False], [False] * 3]
    assert surface.shape == (2, 3)
    assert surface.grey_albedo == pytest.approx([0.2126])
    assert surface.normals.max() == 1


FLAT = np.tile([0.0, 0, 1], (2, 2, 1))
GREY = np.full((2, 2), 0.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((FLAT[0], GREY), "normals: expected an array of shape"),
        ((np.zeros((0, 2, 3)), GREY), "normals: expected an array of shape"),
        ((FLAT * 2, GREY), "normals: expected unit vectors, got one of length 2"),
        ((FLAT * np.nan, GREY), "normals: expected finite"),
        ((FLAT, GREY[:1]), r"albedo: expected shape \(2, 2\) or"),
        ((FLAT, GREY * np.nan), "albedo: expected finite"),
        ((FLAT, -GREY), "albedo: expected at least 0 in the mask, got -0.5"),
        ((FLAT, GREY, np.zeros((2, 2), bool)), "at least one pixel"),
        ((FLAT * 0, GREY), "at least one pixel"),
        ((FLAT, GREY, np.ones((2, 3), bool)), "mask: expected a boolean mask of shape"),
        ((FLAT, GREY, np.ones((2, 2))), "mask: expected a boolean mask"),
        ((FLAT, GREY, None, np.ones((2, 3))), "depth: expected shape"),
        ((FLAT, GREY, None, GREY * np.nan), "depth: expected finite"),
        ((FLAT, GREY, None, None, 0.0), "pixel_size: expected"),
        ((FLAT, GREY, None, None, np.nan), "pixel_size: expected"),
    ],
)
def test_bad_arrays_are_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        Surface(*arguments)


def test_a_surface_cut_short_is_refused_wherever_it_is_cut(tmp_path):
    make().save(tmp_path / "a.npz")
    data = (tmp_path / "a.npz").read_bytes()
    for cut in {*range(0, len(data), 37), *range(len(data) - 30, len(data))}:
        (tmp_path / "b.npz").write_bytes(data[:cut])
        with pytest.raises(HarmonicFaceError) as caught:
            Surface.load(tmp_path / "b.npz")
        assert "\n" not in str(caught.value)


def test_a_flipped_byte_is_refused_or_harmless(tmp_path):
    surface = make((4, 3), colour=True)
    surface.save(tmp_path / "a.npz")
    data = (tmp_path / "a.npz").read_bytes()
    refused = 0
    for place, change in zip(range(len(data)), np.random.default_rng(0).integers(1, 256, len(data)), strict=True):
        flipped = bytearray(data)
        flipped[place] ^= change
        (tmp_path / "b.npz").write_bytes(flipped)
        try:
            loaded = Surface.load(tmp_path / "b.npz")
        except HarmonicFaceError as error:
            refused += 1
            assert "\n" not in str(error)
            continue
        assert same(surface, loaded), place
    assert refused > len(data) / 2


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"normals": FLAT}, r"without \['albedo', 'mask', 'pixel_size'\]"),
        ({"normals": FLAT, "albedo": GREY, "mask": GREY > 0, "pixel_size": [1.0, 2.0]}, "expected one pixel_size"),
        ({"normals": FLAT, "albedo": GREY, "mask": GREY > 9, "pixel_size": 1.0}, "at least one pixel"),
    ],
)
def test_other_archives_are_refused(tmp_path, arrays, message):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(HarmonicFaceError, match=message):
        Surface.load(tmp_path / "a.npz")


def test_what_is_no_archive_is_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match="got no file"):
        Surface.load(tmp_path / "none.npz")
    with pytest.raises(HarmonicFaceError, match=r"a file name that ends in \.npz, got a\.npy"):
        make().save(tmp_path / "a.npy")
    np.save(tmp_path / "array.npy", FLAT)
    (tmp_path / "array.npy").rename(tmp_path / "array.npz")
    with pytest.raises(HarmonicFaceError, match="expected a saved Surface"):
        Surface.load(tmp_path / "array.npz")
    with zipfile.ZipFile(tmp_path / "empty.npz", "w"):
        pass
    with pytest.raises(HarmonicFaceError, match="expected a saved Surface"):
        Surface.load(tmp_path / "empty.npz")
    np.savez(tmp_path / "pickle.npz", normals=np.array([{}], dtype=object))
    with pytest.raises(HarmonicFaceError, match="Object arrays cannot be loaded"):
        Surface.load(tmp_path / "pickle.npz")
    with pytest.raises(HarmonicFaceError, match="cannot write"):
        make().save(tmp_path / "nowhere" / "a.npz")


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    surface = make()
    surface.save(tmp_path / "a.npz")

    def full(*_, **__):
        raise OSError("No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(HarmonicFaceError, match=r"cannot write .*: No space left"):
        make(seed=1).save(tmp_path / "a.npz")
    assert same(surface, Surface.load(tmp_path / "a.npz"))
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]
