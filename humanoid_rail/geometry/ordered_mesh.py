"""Meshes in one order, whatever order their files have, and what they enclose."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from humanoid_rail.geometry.mesh_files import Triangles


def in_order(mesh: Triangles) -> Triangles:
    """Return a mesh whose vertices are each given once, those of triangles only, and sorted, and so are the triangles.

    It is the same whatever the order in the file. Triangles without area remain: they may hold vertices.
    """
    used, index = np.unique(mesh.faces, return_inverse=True)
    vertices, same = np.unique(mesh.vertices[used] + 0.0, axis=0, return_inverse=True)
    faces = same.ravel()[index].reshape(-1, 3)
    first = faces.argmin(axis=1)[:, None]
    return Triangles(vertices, np.unique(np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1), axis=0))


def enclosed_volume(mesh: Triangles) -> float | None:
    """Return the volume that the parts of a mesh enclose, m^3; None if one is open or its triangles face both ways.

    Parts that overlap count twice, cavities count as solid parts.

    Args:
        mesh: Sorted by :func:`in_order`.
    """
    a, b, c = mesh.faces.T
    faces = mesh.faces[(a != b) & (b != c) & (c != a)]
    n = len(mesh.vertices)
    ahead = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2) @ np.array([n, 1])
    back = np.stack([np.roll(faces, -1, axis=1), faces], axis=2).reshape(-1, 2) @ np.array([n, 1])
    if not len(faces) or not np.array_equal(np.sort(ahead), np.sort(back)):
        return None
    edges = coo_array((np.ones(len(ahead)), (ahead // n, ahead % n)), shape=(n, n))
    part = connected_components(edges, directed=False)[1]
    a, b, c = np.moveaxis((mesh.vertices - mesh.vertices.mean(axis=0))[faces], 1, 0)
    signed = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return float(np.abs(np.bincount(part[faces[:, 0]], signed)).sum())
