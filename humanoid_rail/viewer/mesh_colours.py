"""The triangles of a mesh file with their colours, for pictures and exports."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array


class ColouredTriangles(NamedTuple):
    """Triangles of one geometry of a file."""

    vertices: Array
    """(n, 3), in the unit of the file."""
    faces: NDArray[np.int64]
    """Indices of vertices (m, 3), counterclockwise from outside."""
    colours: Array | None
    """Red, green, blue and opacity of the corners (m, 3, 4), from 0 to 1; None if the file says none."""


def coloured_triangles(scene: Any) -> Iterator[ColouredTriangles]:
    """Yield the triangles of trimesh's scene of a file, placed as the file says."""
    for node in scene.graph.nodes_geometry:
        T, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not len(getattr(geometry, "faces", ())):
            continue
        vertices, faces = np.asarray(geometry.vertices, float) @ T[:3, :3].T + T[:3, 3], np.asarray(geometry.faces)
        colours = _corner_colours(geometry)
        if np.linalg.det(T[:3, :3]) < 0:  # mirrored: the corners go round the other way
            faces, colours = faces[:, ::-1], None if colours is None else colours[:, ::-1]
        yield ColouredTriangles(vertices, faces.astype(np.int64), colours)


def _corner_colours(geometry: Any) -> Array | None:
    """Return the colours (m, 3, 4) of the corners of triangles, from 0 to 1; None if they have none."""
    visual, faces = geometry.visual, np.asarray(geometry.faces)
    match visual.kind:
        case "face":
            colours = np.asarray(visual.face_colors)[:, None]
        case "vertex":
            colours = np.asarray(visual.vertex_colors)[faces]
        case "texture":
            colours = np.asarray(visual.material.main_color)
            # Without the picture or coordinates in it, the colour of the material is what there is.
            with suppress(Exception):
                colours = np.asarray(visual.to_color().vertex_colors).reshape(-1, 4)[faces]
        case _:
            return None
    return np.broadcast_to(colours / 255.0, (*faces.shape, 4))
