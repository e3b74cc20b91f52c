"""A mesh cut into sets of points whose hulls together contain each of its triangles, by guarantee."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.geometry.solids import size_of

EDGE = 0.05
"""Triangles are divided until no edge is longer than this, relative to the size of the mesh."""


def cells(mesh: Triangles, pieces: Sequence[Array]) -> list[Array]:
    """Return sets of points (n, 3) on a mesh, one a piece, such that each of its triangles is in the hull of a set.

    Pieces of an approximate decomposition neither contain the mesh nor keep to it. So each triangle, divided until it
    is small, goes to the piece that it reaches out of least, with all its corners; and each vertex of the piece is
    replaced by the nearest corner of a triangle. Thus pieces that touch along a cut still do.

    Args:
        mesh: Sorted by :func:`in_order`.
        pieces: Vertices (k, 3) of convex bodies, m; those that are flat are left out.

    Raises:
        ValueError: If all pieces are flat.
    """
    fine = divided(mesh, EDGE * size_of(mesh.vertices))
    solid, beyond = [], []
    for piece in pieces:
        try:
            planes = ConvexHull(piece).equations
        except QhullError:
            continue
        outside = (fine.vertices @ planes[:, :3].T + planes[:, 3]).max(axis=1)
        beyond.append(outside[fine.faces].max(axis=1))
        solid.append(piece)
    if not solid:
        raise ValueError("a mesh that can be cut into convex pieces that are not flat")
    owner = np.argmin(beyond, axis=0)
    nearest = cKDTree(fine.vertices)
    sets = []
    for i, piece in enumerate(solid):
        corners = np.union1d(fine.faces[owner == i].ravel(), nearest.query(piece)[1])
        sets.append(fine.vertices[corners])
    return sets


def divided(mesh: Triangles, longest: float) -> Triangles:
    """Return a mesh whose triangles are halved at their longest edge until no edge is longer than a length, m."""
    small, left = [], mesh.corners
    while len(left):
        lengths = np.linalg.norm(left - np.roll(left, -1, axis=1), axis=2)
        small.append(left[lengths.max(axis=1) <= longest])
        large, first = left[lengths.max(axis=1) > longest], lengths.argmax(axis=1)[lengths.max(axis=1) > longest]
        a, b, c = (large[np.arange(len(large)), (first + k) % 3] for k in range(3))
        half = (a + b) / 2.0
        left = np.concatenate([np.stack([a, half, c], axis=1), np.stack([half, b, c], axis=1)])
    vertices, faces = np.unique(np.concatenate(small).reshape(-1, 3), axis=0, return_inverse=True)
    return Triangles(vertices, faces.reshape(-1, 3))


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
