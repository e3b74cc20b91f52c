"""Meshes with their colours, as they are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import meshcat.geometry as mg
import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.mesh_files import Triangles, load, unit
from humanoid_rail.viewer.colours import PLAIN, colour_of
from humanoid_rail.viewer.mesh_colours import coloured_triangles
from humanoid_rail.viewer.simplified import clustered

CREASE = np.cos(np.radians(35.0))
"""Triangles that meet at a larger angle than this have an edge between them; others look round."""
STEPS = 127
"""Normals are rounded to this part of 1, so that they take little room."""


class Coloured(NamedTuple):
    """Triangles and the colours of their corners."""

    mesh: Triangles
    colours: NDArray[np.uint8]
    """Red, green, blue and opacity from 0 to 255: (4,), or for each corner of a triangle (m, 3, 4)."""


class Painted(NamedTuple):
    """Triangles as they are drawn, of one colour or with one for each vertex."""

    vertices: Array
    """(n, 3), m."""
    normals: Array
    """(n, 3), of length 1 up to rounding."""
    faces: NDArray[np.int64]
    """(m, 3)."""
    colours: NDArray[np.uint8]
    """Red, green, blue and opacity from 0 to 255: (4,) or (n, 4)."""


class _Shaded(mg.TriangularMeshGeometry):  # type: ignore[misc]  # meshcat has no types
    """Triangles with a normal at each vertex."""

    def __init__(self, vertices: Array, faces: NDArray[np.int64], colours: Array | None, normals: Array) -> None:
        super().__init__(vertices, faces, colours)
        self.normals = normals.astype(np.float32)

    def lower(self, object_data: dict[str, Any]) -> dict[str, Any]:
        data: dict[str, Any] = super().lower(object_data)
        data["data"]["attributes"]["normal"] = mg.pack_numpy_array(self.normals.T)
        return data


def read_coloured(file: str, scale: Sequence[float]) -> list[Coloured]:
    """Return the meshes of a file, placed as it says; those of the same colour are one.

    Args:
        file: Its path.
        scale: Factors along its axes.

    Raises:
        ValueError: If it is no file that holds a triangle mesh; the message says what would be valid.
    """
    scene, factor = load(file), unit(file)
    plain: dict[bytes, list[Coloured]] = {}
    found: list[Coloured] = []
    for vertices, faces, colours in coloured_triangles(scene):
        mesh = Triangles(factor * vertices * np.asarray(scale), faces)
        shown = np.broadcast_to(PLAIN, (len(faces), 3, 4)) if colours is None else colours
        part = Coloured(mesh, (255 * shown).round().astype(np.uint8))
        if (part.colours == part.colours[0, 0]).all():
            part = part._replace(colours=part.colours[0, 0])
            plain.setdefault(part.colours.tobytes(), []).append(part)
        else:
            found.append(part)
    found += [Coloured(_joined([part.mesh for part in parts]), parts[0].colours) for parts in plain.values()]
    if not found:
        raise ValueError("a file that holds a triangle mesh")
    return found


def painted(part: Coloured, cell: float) -> Painted:
    """Return triangles as they are drawn.

    Args:
        part: The triangles.
        cell: Points within cells of this size become one, m; 0 for none but those that are the same.
    """
    mesh, left = clustered(part.mesh, cell)
    normals = (STEPS * _corner_normals(mesh)).round().astype(np.int8).reshape(-1, 3)
    by_corner = part.colours.ndim > 1
    columns = [mesh.faces.reshape(-1, 1).astype(np.int32).view(np.uint8), normals.view(np.uint8)]
    if by_corner:
        columns.append(part.colours[left].reshape(-1, 4))
    rows = np.ascontiguousarray(np.hstack(columns))
    _, first, number = np.unique(rows.view(f"V{rows.shape[1]}").reshape(-1), return_index=True, return_inverse=True)
    return Painted(
        mesh.vertices[mesh.faces.reshape(-1)[first]],
        normals[first] / STEPS,
        number.reshape(-1, 3),
        part.colours[left].reshape(-1, 4)[first] if by_corner else part.colours,
    )


def draw_painted(view: Any, part: Painted, rgba: Sequence[float] | None) -> None:
    """Draw triangles, in a colour (4,) from 0 to 1 where one is given."""
    colours = part.colours / 255.0 if rgba is None else np.array(rgba)
    by_vertex = None if colours.ndim == 1 else colours[:, :3]
    opacity = float(colours[..., 3].mean())
    colour = colour_of(colours if by_vertex is None else np.ones(3))
    material = mg.MeshPhongMaterial(color=colour, opacity=opacity, vertexColors=by_vertex is not None)
    view.set_object(_Shaded(part.vertices, part.faces, by_vertex, part.normals), material)


def _joined(meshes: Sequence[Triangles]) -> Triangles:
    begins = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + begin for mesh, begin in zip(meshes, begins[:-1], strict=True)]
    return Triangles(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))


def _corner_normals(mesh: Triangles) -> Array:
    """Return the normals (m, 3, 3) at the corners of triangles: of those around a point that meet without an edge."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    area = np.cross(b - a, c - a)
    normal = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-30)
    order = np.argsort(mesh.faces.reshape(-1), kind="stable")
    point, face = mesh.faces.reshape(-1)[order], order // 3
    begin = np.searchsorted(point, point)
    count = np.searchsorted(point, point, "right") - begin
    summed = np.zeros((len(order), 3))
    # One neighbour of each corner at a time; points with very many triangles are rare.
    for k in range(int(count.max(initial=0))):
        has = np.flatnonzero(count > k)
        other = face[begin[has] + k]
        smooth = np.einsum("ij,ij->i", normal[face[has]], normal[other]) > CREASE
        summed[has[smooth]] += area[other[smooth]]
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    corners = np.empty_like(summed)
    corners[order] = np.where(length > 0, summed / np.maximum(length, 1e-30), normal[face])
    return corners.reshape(-1, 3, 3)
