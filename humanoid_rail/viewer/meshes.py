"""Triangles and lines for what meshcat has no shapes for."""

from __future__ import annotations

from itertools import combinations, product

import coal
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


def capsule_mesh(shape: coal.Capsule) -> mg.TriangularMeshGeometry:
    """Return a capsule along z as the hull of points on its two half spheres."""
    azimuth, height = np.meshgrid(np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(-np.pi / 2, np.pi / 2, 16))
    sphere = np.stack([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)], axis=-1)
    points = shape.radius * sphere.reshape(-1, 3)
    points[:, 2] += np.where(points[:, 2] > 0, shape.halfLength, -shape.halfLength)
    return hull_mesh(np.unique(points.round(9), axis=0))


def box_edges(box: coal.Box) -> Array:
    """Return the twelve edges of a box as pairs of points (3, 24), m."""
    corners = np.array(list(product((-1, 1), repeat=3))) * box.halfSide
    pairs = [(a, b) for a, b in combinations(range(8), 2) if (corners[a] != corners[b]).sum() == 1]
    edges: Array = corners[np.array(pairs).ravel()].T
    return edges
