"""Triangles and lines for what meshcat has no shapes for."""

from __future__ import annotations

from typing import Any

import meshcat.geometry as mg
import numpy as np
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array


class _Smooth(mg.TriangularMeshGeometry):  # type: ignore[misc]  # meshcat has no types
    """Triangles that look round: at a point the normal is the mean of those of its triangles, by their area."""

    def lower(self, object_data: dict[str, Any]) -> dict[str, Any]:
        a, b, c = (self.vertices[self.faces[:, corner]] for corner in range(3))
        normals = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(normals, self.faces[:, corner], np.cross(b - a, c - a))
        # Where all triangles of a point are flat it has no normal, and keeps the zeros.
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
        data: dict[str, Any] = super().lower(object_data)
        data["data"]["attributes"]["normal"] = mg.pack_numpy_array(normals.T)
        return data


def hull_mesh(points: Array) -> mg.TriangularMeshGeometry:
    """Return the convex hull of points (k, 3), m."""
    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    corners = points[faces]
    inward = np.einsum(
        "fx,fx->f", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), hull.equations[:, :3]
    )
    # meshcat draws the side from which the corners of a face go round counterclockwise.
    faces[inward < 0] = faces[inward < 0][:, ::-1]
    return _Smooth(points, faces)


def line_mesh(points: Array, pairs: Array) -> mg.TriangularMeshGeometry:
    """Return lines between points (k, 3), m, as triangles without area, which a wireframe material draws as lines.

    Args:
        points: Where the lines end.
        pairs: The two points of each line (m, 2), by number.
    """
    return mg.TriangularMeshGeometry(points, np.column_stack([pairs, pairs[:, 0]]))
