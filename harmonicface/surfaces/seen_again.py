"""A mesh seen again: by another camera than the one that a Surface was made with."""

from __future__ import annotations

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces._resampling import MaskedMean, spread
from harmonicface.surfaces.mesh import FINEST, FINEST_DEPTH, SUPERSAMPLE
from harmonicface.surfaces.perspective import Camera
from harmonicface.surfaces.samples import sample
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.windows import Window


def see_again(mesh: Mesh, view: Camera) -> Surface:
    """Return what any camera sees of a mesh, as `surface_from_mesh` returns it for one that it places itself.

    Parameters
    ----------
    mesh
        A mesh with at least one face.
    view
        The camera.

    Returns
    -------
    Surface of float32 arrays with the mesh as its scene: the means over 4 x 4 samples a pixel, or fewer where these
    would exceed 1024 a side; inside the mask where at least half of the samples see the mesh.

    Raises
    ------
    HarmonicFaceError
        A view in which nothing is seen.
    """
    divisions = int(np.clip(FINEST // max(view.shape), 1, SUPERSAMPLE))
    samples = sample(mesh, view.finer(divisions))
    window = Window(0, 0, float(divisions), view.shape)
    mean = MaskedMean(samples.mask, window)
    normals = mean(samples.normals[samples.mask])
    length = np.linalg.norm(normals, axis=1)
    directed = length > 1e-6  # opposite sideways normals within one pixel leave no direction
    inside = mean.inside.copy()
    inside[mean.inside] = directed
    if not inside.any():
        raise HarmonicFaceError("view: expected a part of the mesh in it, got a camera that sees nothing")
    depth = mean(samples.raster.depth[samples.mask])[directed]
    pixel_size = float(view.pixel_size_at(depth.mean()))
    coarse = np.spacing(np.abs(depth).max().astype(np.float32)) > FINEST_DEPTH * pixel_size
    return Surface(
        spread(normals[directed] / length[directed, None], inside, np.float32),
        spread(mean(samples.albedo[samples.mask])[directed], inside, np.float32),
        inside,
        spread(depth, inside, np.float64 if coarse else np.float32),
        pixel_size,
        scene=Scene(mesh, view),
    )
