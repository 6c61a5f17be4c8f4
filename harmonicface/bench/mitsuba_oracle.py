"""Pictures by an independent renderer, mitsuba, of the same mesh, view and light: what ours are judged against."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import Light, SumOfLights
from harmonicface.lighting.sources import AmbientLight, DirectionalLights
from harmonicface.surfaces.view import View

VARIANT = "scalar_rgb"
BEHIND = np.diag([-1.0, 1.0, -1.0])  # mitsuba's maps have -z at their borders, ours in their middle column


def mitsuba_picture(
    mesh: Mesh, view: View, light: Light, samples: int = 64, depth: int | None = None, seed: int = 0
) -> NDArray[np.float32]:
    r"""Return the picture of a matte mesh with cast shadows, by Monte Carlo: B = pi times the radiance of a pixel.

    An orthographic sensor with the view's own pixels, each the mean over its square (box filter); smooth normals of
    the vertices, faces seen from both sides. The picture's noise falls with the root of `samples`; two seeds tell
    how large it is.

    Parameters
    ----------
    mesh
        What is seen; its albedo is that of the vertices or of textures times one colour.
    view
        Where the camera stands; the light is in the camera's axes.
    light
        Directional or ambient light, an EnvironmentMap, or a sum of directional lights and at most one of the others.
        An environment is a "latlong" map (see `EnvironmentMap.converted`), bilinear between its pixels.
    samples
        Paths per pixel; rounded up to rows times columns of jittered places.
    depth
        None for direct light alone; otherwise the most segments of a path from camera to light: 2 is direct light
        too, 3 adds one bounce.
    seed
        Of the paths.

    Returns
    -------
    (h, w, 3) float32; 0 where nothing is seen.

    Raises
    ------
    HarmonicFaceError
        A view that is not orthographic, a light of another kind or layout, two lights that surround the scene, vertex
        colours that differ together with a texture, or vertices without a normal.
    """
    import mitsuba

    if not isinstance(view, View):
        raise HarmonicFaceError(f"view: expected an orthographic View, got a {type(view).__name__}")
    mitsuba.set_variant(VARIANT)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)  # not every count of samples is a product of two alike
    scene = {
        "type": "scene",
        "integrator": _integrator(depth),
        "sensor": _sensor(mitsuba, mesh, view, samples),
        **{f"light{number}": emitter for number, emitter in enumerate(_emitters(mitsuba, light))},
        **{f"part{number}": part for number, part in enumerate(_parts(mitsuba, mesh, view))},
    }
    radiance = mitsuba.render(mitsuba.load_dict(scene), seed=seed, spp=samples)
    return np.asarray(np.pi * np.array(radiance), dtype=np.float32)


def mitsuba_renderer() -> Callable[..., Any]:
    """Return the function of mitsuba's by which pictures are rendered."""
    import mitsuba

    mitsuba.set_variant(VARIANT)
    renderer: Callable[..., Any] = mitsuba.render
    return renderer


def _integrator(depth: int | None) -> dict[str, Any]:
    if depth is None:
        return {"type": "direct", "hide_emitters": True}
    return {"type": "path", "max_depth": depth, "hide_emitters": True}


def _sensor(mitsuba: Any, mesh: Mesh, view: View, samples: int) -> dict[str, Any]:
    """Return the camera in front of a mesh in `_camera_space`."""
    front = float(_camera_space(mesh, view)[:, 2].max()) + 1.0
    height, width = view.shape
    return {
        "type": "orthographic",
        "to_world": mitsuba.ScalarTransform4f().look_at(origin=[0, 0, front], target=[0, 0, 0], up=[0, 1, 0]),
        "near_clip": 0.5,
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "multijitter", "sample_count": samples},
    }


def _camera_space(mesh: Mesh, view: View) -> NDArray[np.float64]:
    """Return the vertices where mitsuba's sensor expects them: the picture is 2 wide, its centre at 0."""
    x0, y0, x1, y1 = view.frame
    turned = view.turn(mesh.vertices)
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2, np.mean([turned[:, 2].min(), turned[:, 2].max()])])
    return np.asarray((turned - middle) * (2 / (x1 - x0)))


def _parts(mitsuba: Any, mesh: Mesh, view: View) -> Iterator[Any]:
    """Yield the faces of each texture, and those without any, as shapes."""
    if (np.linalg.norm(mesh.normals[np.unique(mesh.faces)], axis=1) == 0).any():
        raise HarmonicFaceError("mesh: expected a normal at every vertex of a face, got vertices without")
    vertices, normals = _camera_space(mesh, view), view.turn(mesh.normals)
    for number in np.unique(mesh.face_texture):
        faces = mesh.faces[mesh.face_texture == number]
        if number < 0:
            reflectance: dict[str, Any] = {"type": "mesh_attribute", "name": "vertex_albedo"}
        else:
            reflectance = _texture(mitsuba, mesh, faces, number)
        properties = mitsuba.Properties()
        properties["bsdf"] = mitsuba.load_dict(
            {"type": "twosided", "matte": {"type": "diffuse", "reflectance": reflectance}}
        )
        shape = mitsuba.Mesh(
            f"part{number}",
            len(vertices),
            len(faces),
            has_vertex_normals=True,
            has_vertex_texcoords=mesh.uv is not None,
            props=properties,
        )
        shape.add_attribute("vertex_albedo", 3, mesh.vertex_albedo.astype(np.float32).ravel())
        fields = mitsuba.traverse(shape)
        fields["vertex_positions"] = vertices.astype(np.float32).ravel()
        fields["vertex_normals"] = normals.astype(np.float32).ravel()
        fields["faces"] = faces.astype(np.uint32).ravel()
        if mesh.uv is not None:
            fields["vertex_texcoords"] = np.stack([mesh.uv[:, 0], 1 - mesh.uv[:, 1]], axis=1).astype(np.float32).ravel()
        fields.update()
        yield shape


def _texture(mitsuba: Any, mesh: Mesh, faces: NDArray[np.int64], number: int) -> dict[str, Any]:
    """Return a texture times the one colour of the vertices that wear it."""
    tints = mesh.vertex_albedo[np.unique(faces)]
    if not (tints == tints[0]).all():
        raise HarmonicFaceError("mesh: expected a texture over one colour of the vertices, got several colours")
    texture = np.atleast_3d(mesh.textures[number])
    coloured = np.ascontiguousarray(np.broadcast_to(texture, (*texture.shape[:2], 3)) * tints[0], dtype=np.float32)
    return {"type": "bitmap", "bitmap": mitsuba.Bitmap(coloured), "raw": True, "filter_type": "bilinear"}


def _emitters(mitsuba: Any, light: Light) -> list[dict[str, Any]]:
    """Return what gives the light; a scene has room for one emitter around it."""
    emitters = list(_each_emitter(mitsuba, light))
    around = sum(emitter["type"] != "directional" for emitter in emitters)
    if around > 1:
        raise HarmonicFaceError(f"light: expected at most one ambient light or environment, got {around}")
    return emitters


def _each_emitter(mitsuba: Any, light: Light) -> Iterator[dict[str, Any]]:
    if isinstance(light, SumOfLights):
        for part in light.parts:
            yield from _each_emitter(mitsuba, part)
    elif isinstance(light, DirectionalLights):
        for direction, strength in zip(light.directions, light.strengths, strict=True):
            yield {"type": "directional", "direction": (-direction).tolist(), "irradiance": _colour(strength)}
    elif isinstance(light, AmbientLight):
        yield {"type": "constant", "radiance": _colour(light.strength / np.pi)}
    elif isinstance(light, EnvironmentMap) and light.layout == "latlong":
        turn = np.eye(4)
        turn[:3, :3] = BEHIND if light.rotation is None else light.rotation @ BEHIND
        yield {
            "type": "envmap",
            "bitmap": mitsuba.Bitmap(_from_pole_to_pole(light.radiance)),
            "to_world": mitsuba.ScalarTransform4f(turn),
        }
    else:
        kind = f"{light.layout} map" if isinstance(light, EnvironmentMap) else type(light).__name__
        raise HarmonicFaceError(f"light: expected directional or ambient light or a latlong map, got a {kind}")


def _colour(value: NDArray[Any]) -> dict[str, Any]:
    return {"type": "rgb", "value": np.broadcast_to(value, 3).tolist()}


def _from_pole_to_pole(radiance: NDArray[Any]) -> NDArray[np.float32]:
    """Return a map with rows between ours: mitsuba's first and last row are the poles themselves, ours lie beside them.

    Bilinear between these rows is bilinear between ours.
    """
    rows = np.broadcast_to(np.atleast_3d(radiance), (*radiance.shape[:2], 3)).astype(np.float64)
    height, width = radiance.shape[:2]
    result = np.empty((2 * height + 1, width, 3), dtype=np.float32)
    result[1::2] = rows
    result[2:-1:2] = (rows[1:] + rows[:-1]) / 2
    for pole, row in ((0, rows[0]), (-1, rows[-1])):
        result[pole] = (row + np.roll(row, width // 2, axis=0)) / 2
    return result
