"""A mesh cut by planes into sets of triangles whose convex hulls are small.

The plane that saves most of the volume of a hull is taken first, as in approximate convex decompositions by voxels
(Mamou, "Volumetric hierarchical approximate convex decomposition", 2016). Triangles are cut themselves, so that their
parts on both sides are contained by construction, and open meshes need not be closed. Of a closed one the inside is
contained as well: a line in a solid, parallel to a plane that cuts it, has both ends on the surface on one side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.geometry.solids import size_of

MOST = (8, 24)
"""A mesh is cut into no more pieces than this, roughly and finely."""
LEAST_SAVED = (0.02, 0.005)
"""A cut saves at least this share of the volume of the whole hull, roughly and finely."""
LARGE = 0.1
"""Pieces whose hull has this share of that volume are cut twice if one cut alone saves nothing."""
POSITIONS = 6
"""The extent of a piece along an axis is divided into so many parts: planes are tried between them."""
COARSE = 0.03
"""Planes are chosen for a mesh whose vertices are in the middles of cells of this size, relative to the mesh."""


class _Piece(NamedTuple):
    """A piece, and the best cut of it."""

    triangles: Array
    """(m, 3, 3), m."""
    saved: float
    """How much less volume the hulls of both sides have, m^3."""
    sides: tuple[Array, ...]
    """The triangles on both sides; none if no plane cuts it."""


def plane_cuts(mesh: Triangles, fine: bool = False) -> list[Array]:
    """Return sets of points (n, 3) such that each triangle of a mesh is in the hulls of these sets together, m.

    Args:
        mesh: A surface, open or closed, that is not flat.
        fine: Whether it is cut into more pieces.
    """
    cell, whole = COARSE * size_of(mesh.vertices), _volume(mesh.vertices)
    least, large = LEAST_SAVED[fine] * whole, LARGE * whole
    pieces = [_piece(mesh.corners, cell, least, large)]
    while len(pieces) < MOST[fine]:
        worst = max(range(len(pieces)), key=lambda i: pieces[i].saved)
        if pieces[worst].saved < least:
            break
        pieces[worst : worst + 1] = [_piece(side, cell, least, large) for side in pieces[worst].sides]
    return [np.unique(piece.triangles.reshape(-1, 3), axis=0) for piece in pieces]


def _piece(triangles: Array, cell: float, least: float, large: float) -> _Piece:
    """Return a piece with the cut that saves most: alone, or if that is little, with those of both sides after it."""
    points, edges = _coarse(triangles, cell)
    volume = _volume(points)
    saved, plane = _best_plane(points, edges, volume)
    sides = _cut(triangles, *plane) if plane else ()
    if saved < least and volume > large:  # a ring, of which one cut alone saves nothing
        for normal in _axes(points):
            heights = points @ normal
            halves = _cut(triangles, normal, float(heights.min() + heights.max()) / 2.0)
            coarse = [_coarse(half, cell) for half in halves]
            volumes = [_volume(points) for points, _ in coarse]
            after = sum(_best_plane(*half, v)[0] for half, v in zip(coarse, volumes, strict=True))
            if (both := volume - sum(volumes) + after) > saved:
                saved, sides = both, halves
    return _Piece(triangles, saved if all(map(len, sides)) else 0.0, sides)


def _best_plane(points: Array, edges: Array, volume: float) -> tuple[float, tuple[Array, float] | None]:
    """Return the plane that saves most of the volume of a hull, m^3, and how much; none if nothing can be saved."""
    best, plane = volume, None
    for normal in _axes(points) if volume > 0.0 else ():
        heights = points @ normal
        low, high = float(heights.min()), float(heights.max())

        def remaining(share: float, normal: Array = normal, low: float = low, high: float = high) -> float:
            return sum(map(_volume, _sides(points, edges, normal, low + share * (high - low))))

        volumes = {k / POSITIONS: remaining(k / POSITIONS) for k in range(1, POSITIONS)}
        share = min(volumes, key=lambda s: volumes[s])
        for step in (0.5 / POSITIONS, 0.25 / POSITIONS):
            volumes |= {s: remaining(s) for s in (share - step, share + step)}
            share = min(volumes, key=lambda s: volumes[s])
        if volumes[share] < best:
            best, plane = volumes[share], (normal, low + share * (high - low))
    return volume - best, plane


def _coarse(triangles: Array, cell: float) -> tuple[Array, Array]:
    """Return the vertices (k, 3) and the edges (e, 2) of triangles, each vertex one of those in its cell."""
    points = triangles.reshape(-1, 3)
    _, first, index = np.unique(
        np.round(points / cell).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    faces = index.reshape(-1, 3)
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    return points[first], np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)


def _axes(points: Array) -> Array:
    """Return the normals (6, 3) of planes that are tried: the axes of the mesh and its principal ones."""
    centred = points - points.mean(axis=0)
    return np.vstack([np.eye(3), np.linalg.eigh(centred.T @ centred)[1].T])


def _sides(points: Array, edges: Array, normal: Array, offset: float) -> tuple[Array, Array]:
    """Return the points on both sides of a plane, each with those in which it cuts edges."""
    heights = points @ normal - offset
    low, high = heights[edges].T
    crossing = low * high < 0.0
    a, b = points[edges[crossing].T]
    cut = a + (b - a) * (low[crossing] / (low[crossing] - high[crossing]))[:, None]
    return np.vstack([points[heights <= 0.0], cut]), np.vstack([points[heights >= 0.0], cut])


def _cut(triangles: Array, normal: Array, offset: float) -> tuple[Array, Array]:
    """Return the triangles (m, 3, 3) below a plane and above it; those that it crosses are divided."""
    heights = triangles @ normal - offset
    below, above = (heights <= 0.0).all(axis=1), (heights > 0.0).all(axis=1)
    crossing, h = triangles[~below & ~above], heights[~below & ~above]
    is_above = h > 0.0
    # One corner is alone on its side.
    alone = np.where(is_above.sum(axis=1) == 1, is_above.argmax(axis=1), is_above.argmin(axis=1))
    rows = np.arange(len(crossing))
    a, b, c = (crossing[rows, (alone + k) % 3] for k in range(3))
    ha, hb, hc = (h[rows, (alone + k) % 3][:, None] for k in range(3))
    p, q = a + (b - a) * (ha / (ha - hb)), a + (c - a) * (ha / (ha - hc))
    tip, rest = np.stack([a, p, q], axis=1), np.concatenate([np.stack([p, b, c], axis=1), np.stack([p, c, q], axis=1)])
    up = ha[:, 0] > 0.0
    both = np.concatenate([up, up])
    return (
        np.concatenate([triangles[below], tip[~up], rest[both]]),
        np.concatenate([triangles[above], tip[up], rest[~both]]),
    )


def _volume(points: Array) -> float:
    """Return the volume of the hull of points, m^3; 0 if they are flat or fewer than four."""
    try:
        return float(ConvexHull(points).volume) if len(points) >= 4 else 0.0
    except QhullError:
        return 0.0
