"""Triangles and lines for what meshcat has no shapes for."""

from __future__ import annotations

import meshcat.geometry as mg
import numpy as np
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array


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
    return mg.TriangularMeshGeometry(points, faces)


def line_mesh(points: Array, pairs: Array) -> mg.TriangularMeshGeometry:
    """Return lines between points (k, 3), m, as triangles without area, which a wireframe material draws as lines.

    Args:
        points: Where the lines end.
        pairs: The two points of each line (m, 2), by number.
    """
    return mg.TriangularMeshGeometry(points, np.column_stack([pairs, pairs[:, 0]]))
