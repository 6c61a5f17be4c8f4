"""Loading Surfaces from files, real heads among them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from skimage import data, feature

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import write_image
from harmonicface.io.normal_maps import write_normal_map
from harmonicface.io.transfer import linear_to_srgb
from harmonicface.surfaces.load import load_surface, surface_from_normals
from harmonicface.surfaces.surface import Surface

# The same part of the face, brow to chin, in each mesh's own units (y up): the line of the eyes at 25 % of the height
# from the top, the line of the mouth at 69 %. The scan is a bust whose face lies in the upper middle.
SCAN_FRAME = (-1.524, -0.479, 1.364, 2.409)
ICT_FRAME = (-8.0, -8.5, 8.0, 7.5)


@pytest.fixture
def ball(tmp_path):
    path = tmp_path / "ball.glb"
    trimesh.creation.icosphere(4).export(path)
    return path


def test_a_mesh_is_seen_at_64_pixels_by_default(ball):
    surface = load_surface(ball)
    assert surface.shape == (64, 64)
    assert surface.pixel_size == pytest.approx(2 / 64, rel=1e-3)
    assert load_surface(ball, (20, 30), frame=(-2, -2, 2, 2)).pixel_size == pytest.approx(0.2)


def test_a_saved_surface_is_loaded_as_it_is(ball, tmp_path):
    surface = load_surface(ball, 16)
    surface.save(tmp_path / "a.npz")
    again = load_surface(tmp_path / "a.npz")
    for name in ("normals", "albedo", "mask", "depth"):
        assert getattr(again, name).tobytes() == getattr(surface, name).tobytes()
    assert again.pixel_size == surface.pixel_size


@pytest.mark.parametrize(
    "arguments",
    [
        {"size": 16},
        {"texture": "map.png"},
        {"flip_texture": True},
        {"rotation": (0, 0, 0)},
        {"frame": (0, 0, 1, 1)},
        {"intrinsics": (9, 9, 4, 4)},
        {"distance": 3.0},
        {"supersample": 1},
    ],
)
def test_a_saved_surface_has_no_other_view(tmp_path, arguments):
    (tmp_path / "junk.npz").write_bytes(b"junk")
    with pytest.raises(HarmonicFaceError, match="expected a saved Surface, got a file that is none"):
        load_surface(tmp_path / "junk.npz", **arguments)
    Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2))).save(tmp_path / "a.npz")
    with pytest.raises(HarmonicFaceError, match=f"expected no view of a saved Surface, got {next(iter(arguments))}"):
        load_surface(tmp_path / "a.npz", **arguments)


def test_bad_files_and_views_name_the_file(tmp_path, ball):
    with pytest.raises(HarmonicFaceError, match=r"a\.txt: expected a mesh .* or a saved Surface"):
        load_surface(tmp_path / "a.txt")
    with pytest.raises(HarmonicFaceError, match=r"ball\.glb: frame: expected"):
        load_surface(ball, frame=(5, 5, 6, 6))
    with pytest.raises(HarmonicFaceError, match=r"ball\.glb: size: expected"):
        load_surface(ball, 0)


def test_normal_and_albedo_pictures_make_a_surface(tmp_path):
    normals = np.tile([0.0, 0.6, 0.8], (6, 5, 1))
    normals[0] = 0
    albedo = np.linspace(0.1, 0.9, 30).reshape(6, 5)
    write_normal_map(tmp_path / "normals.png", normals)
    write_image(tmp_path / "albedo.png", albedo)
    surface = surface_from_normals(tmp_path / "normals.png", str(tmp_path / "albedo.png"), pixel_size=0.5)
    np.testing.assert_allclose(surface.normals, normals, atol=1e-4)
    np.testing.assert_allclose(surface.albedo[1:], albedo[1:], atol=0.005)
    assert surface.mask.tolist() == normals.any(axis=2).tolist()
    assert surface.pixel_size == 0.5
    assert (surface_from_normals(normals, 0.3).pixel_albedo == 0.3).all()
    mask = np.zeros((6, 5), dtype=bool)
    mask[2, 3] = True
    assert surface_from_normals(normals, albedo, mask=mask).pixel_albedo == albedo[2, 3]


def test_green_points_up_or_down_by_name(tmp_path):
    normals = np.tile([0.0, 0.6, 0.8], (6, 5, 1))
    write_normal_map(tmp_path / "down.png", normals * [1, -1, 1])
    seen = surface_from_normals(tmp_path / "down.png", green="down")
    np.testing.assert_allclose(seen.normals, normals, atol=1e-4)
    np.testing.assert_array_equal(surface_from_normals(normals * [1, -1, 1], green="down").normals, normals)
    for source in (normals, tmp_path / "down.png"):
        with pytest.raises(
            HarmonicFaceError, match=r"green: expected 'up' \(OpenGL\) or 'down' \(DirectX\), got 'left'"
        ):
            surface_from_normals(source, green="left")


def test_a_mesh_is_seen_by_a_pinhole_if_it_has_intrinsics(ball):
    surface = load_surface(ball, 16, intrinsics=(40, 40, 8, 8), distance=6.0)
    assert surface.depth[8, 8] == pytest.approx(-5, abs=0.05)
    assert surface.pixel_size == pytest.approx(-surface.depth[surface.mask].mean() / 40)
    assert load_surface(ball, 16, intrinsics=(40, 40, 8, 8)).mask[0].any()  # fills the picture
    with pytest.raises(HarmonicFaceError, match=r"ball\.glb: intrinsics: expected a part of the mesh in view"):
        load_surface(ball, 16, intrinsics=(40, 40, 500, 8), distance=6.0)


def test_points_are_loaded_like_meshes(tmp_path):
    sphere = np.asarray(trimesh.creation.icosphere(4).vertices)
    np.save(tmp_path / "a.npy", np.hstack([sphere, sphere]))
    np.savetxt(tmp_path / "a.xyz", np.hstack([sphere, sphere]))
    for name in ("a.npy", "a.xyz"):
        surface = load_surface(tmp_path / name, 24, rotation=(10, 0, 0), frame=(-1, -1, 1, 1))
        assert surface.normals[12, 12] @ [0.04, -0.04, 1] > 0.99
    assert load_surface(tmp_path / "a.npy").shape == (64, 64)
    with pytest.raises(
        HarmonicFaceError, match="expected size, rotation and frame of points at most, got texture, dis"
    ):
        load_surface(tmp_path / "a.npy", texture="map.png", distance=2.0)
    with pytest.raises(HarmonicFaceError, match=r"a\.npy: frame: expected some of the points in view"):
        load_surface(tmp_path / "a.npy", frame=(5, 5, 6, 6))


def test_pictures_that_do_not_fit_are_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match="albedo: expected shape"):
        surface_from_normals(np.tile([0.0, 0, 1], (6, 5, 1)), np.ones((5, 6)))
    with pytest.raises(HarmonicFaceError, match="normals: expected an array of shape"):
        surface_from_normals(np.ones(3), 0.5)
    with pytest.raises(HarmonicFaceError, match="expected an image"):
        surface_from_normals(tmp_path / "none.png")


def scan(data_dir, size, **options):
    folder = data_dir / "heads" / "LeePerrySmith"
    return load_surface(folder / "LeePerrySmith.glb", size, texture=folder / "Map-COL.jpg", **options)


def faces_found(picture):
    """What a detector trained on photographs finds: (row, column, size) of faces, on a margin of 40 pixels."""
    detector = feature.Cascade(data.lbp_frontal_face_cascade_filename())
    bytes_ = np.pad((linear_to_srgb(picture.clip(0, 1)) * 255).astype(np.uint8), ((40, 40), (40, 40), (0, 0)))
    found = detector.detect_multi_scale(bytes_, scale_factor=1.1, step_ratio=1, min_size=(90, 90), max_size=(200, 200))
    return [(face["r"] - 40, face["c"] - 40, face["width"]) for face in found]


@pytest.mark.data
def test_the_scanned_head_is_a_face_that_a_detector_recognizes(data_dir):
    surface = scan(data_dir, 128, flip_texture=True, frame=SCAN_FRAME)
    light = np.array([0.0, 0.3, 1.0]) / np.hypot(0.3, 1.0)
    shaded = surface.albedo * (surface.normals @ light).clip(0)[..., None]
    for picture in (surface.albedo, 1.3 * shaded):  # its albedo alone, and in light
        assert len(faces_found(picture)) > 0
    assert faces_found(scan(data_dir, 128, flip_texture=False, frame=SCAN_FRAME).albedo) == []
    assert surface.albedo.shape == (128, 128, 3) and surface.mask.mean() > 0.9
    skin = surface.pixel_albedo.mean(axis=0)
    assert skin[0] > skin[1] > skin[2]


@pytest.mark.data
def test_the_scanned_head_survives_saving_bit_for_bit(data_dir, tmp_path):
    surface = scan(data_dir, 64, flip_texture=True, frame=SCAN_FRAME)
    surface.save(tmp_path / "head.npz")
    again = Surface.load(tmp_path / "head.npz")
    for name in ("normals", "albedo", "mask", "depth"):
        assert getattr(again, name).tobytes() == getattr(surface, name).tobytes()


@pytest.mark.data
def test_the_frames_show_the_same_part_of_every_head(data_dir):
    """The nose is the nearest point; on every head its tip lies on the same spot of the picture."""
    folder = data_dir / "heads" / "ICT-FaceKit" / "FaceXModel"
    heads = [scan(data_dir, 64, frame=SCAN_FRAME)]
    heads += [load_surface(folder / f"{name}.obj", frame=ICT_FRAME) for name in ("generic_neutral_mesh", "identity005")]
    for head in heads:
        row, column = np.unravel_index(np.nanargmax(head.depth), head.shape)
        assert abs(row - 28) <= 2 and abs(column - 31.5) <= 2
        assert head.mask.mean() > 0.85
