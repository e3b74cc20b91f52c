"""Triangles made fewer for a page: points that are near each other become one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.mesh_files import Triangles

FINEST = 1e-4
"""The first size of cells that is tried, as a share of the size of what is simplified."""
COARSER = 1.3
"""Cells become larger by this factor until the triangles are few enough."""
STIFFNESS = 1e-2
"""How much the place of a point counts that is the mean of its cell, beside the planes of its triangles."""
_BITS = 21
"""Numbers of cells along each axis have as many bits: three of them fit into one number."""


def cell_size(meshes: Sequence[Triangles], most: int, size: float) -> float:
    """Return the smallest size of cells in which some meshes together have few enough triangles, m.

    Args:
        meshes: The meshes; where their sizes differ, small parts lose the same detail as large ones.
        most: How many triangles there may be.
        size: Size of the whole, m.

    Returns:
        0.0 if they are few enough as they are.
    """
    if sum(len(mesh.faces) for mesh in meshes) <= most:
        return 0.0
    cell = FINEST * size
    while sum(int(_is_left(_cells(mesh.vertices, cell)[mesh.faces]).sum()) for mesh in meshes) > most:
        cell *= COARSER
    return cell


def clustered(mesh: Triangles, cell: float) -> tuple[Triangles, NDArray[np.bool_]]:
    """Return a mesh in which the points of each cell are one, and which of its triangles are left (m,).

    That point is where the planes of its triangles meet as well as can be, so that edges stay sharp. It moves by at
    most the diagonal of a cell. A triangle with two corners in one cell is gone.

    Args:
        mesh: The mesh.
        cell: Size of the cells, m; 0 makes one of those points that are the same.
    """
    if cell == 0.0:
        vertices, number = np.unique(mesh.vertices, axis=0, return_inverse=True)
        left = _is_left(number.reshape(-1)[mesh.faces])
        return Triangles(vertices, number.reshape(-1)[mesh.faces][left]), left
    number = _cells(mesh.vertices, cell)
    faces = number[mesh.faces]
    left = _is_left(faces)
    return Triangles(_points(mesh, number, cell), faces[left]), left


def _cells(vertices: Array, cell: float) -> NDArray[np.int64]:
    """Return the number of the cell of each vertex (n,), from 0 on."""
    at = np.floor((vertices - vertices.min(axis=0)) / cell).astype(np.int64)
    packed = (at[:, 0] << 2 * _BITS) | (at[:, 1] << _BITS) | at[:, 2]
    number: NDArray[np.int64] = np.unique(packed, return_inverse=True)[1].reshape(-1)
    return number


def _is_left(faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which triangles have three corners, and are the first with these (m,)."""
    a, b, c = np.sort(faces, axis=1).T
    whole: NDArray[np.bool_] = (a != b) & (b != c)
    packed = (a << 2 * _BITS) | (b << _BITS) | c
    first = np.zeros(len(faces), bool)
    first[np.unique(packed, return_index=True)[1]] = True
    left: NDArray[np.bool_] = whole & first
    return left


def _points(mesh: Triangles, number: NDArray[np.int64], cell: float) -> Array:
    """Return the point of each cell (k, 3): nearest to all planes of its triangles, in the squared mean."""
    count = int(number.max()) + 1

    def summed(values: Array, by: NDArray[np.int64]) -> Array:
        columns = values.reshape(len(by), -1).T
        sums: Array = np.stack([np.bincount(by, weights=column, minlength=count) for column in columns], axis=-1)
        return sums.reshape(count, *values.shape[1:])

    mean = summed(mesh.vertices, number) / np.bincount(number, minlength=count)[:, None]
    corners = mesh.corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    weighted = normal / np.sqrt(np.maximum(length, 1e-30))  # times itself: by the area
    quadric = weighted[:, :, None] * weighted[:, None, :]
    A, b = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for corner in range(3):
        at = mesh.faces[:, corner]
        cells = number[at]
        A += summed(quadric, cells)
        b += summed(np.einsum("fij,fj->fi", quadric, mesh.vertices[at] - mean[cells]), cells)
    held = STIFFNESS * np.trace(A, axis1=1, axis2=2) + 1e-18
    step = np.linalg.solve(A + held[:, None, None] * np.eye(3), b[:, :, None])[:, :, 0]
    return np.asarray(mean + np.clip(step, -cell / 2, cell / 2))
