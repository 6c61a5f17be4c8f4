"""Scene: the whole shape behind a Surface, so that what the view does not show can cast shadows too."""

from __future__ import annotations

from dataclasses import dataclass

from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.view import View


@dataclass(frozen=True, eq=False)
class Scene:
    """A mesh and the view of it that a Surface is.

    Parameters
    ----------
    mesh
        The mesh, in its own axes and units.
    view
        What turned it and cut the picture out.
    """

    mesh: Mesh
    view: View
