"""Whether convex pieces cover a solid, by points on and in it: independent of what made the pieces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.geometry.solids import areas

ON_SURFACE = 4000
"""At most so many vertices, middles of triangles and random points on them are looked at, of each kind."""
INSIDE = 2000
"""So many random points in the box around a solid are looked at, fewer if it has many triangles."""
MOST_ANGLES = 20_000_000
"""The most solid angles of triangles that are computed, for points in the box."""


def farthest_outside(points: Array, pieces: Sequence[Array]) -> float:
    """Return how far points (n, 3) are outside of all pieces at most, m; 0 if none is.

    The distance from a piece is that from its farthest plane: the true one, or less near to an edge or a vertex.

    Args:
        points: In m.
        pieces: Vertices (k, 3) of convex bodies, m.
    """
    outside = np.full(len(points), np.inf)
    for piece in pieces:
        left = np.flatnonzero(outside > 0.0)
        planes = ConvexHull(piece).equations
        for part in np.array_split(left, 1 + left.size * len(planes) // 1_000_000):
            distance = (points[part] @ planes[:, :3].T + planes[:, 3]).max(axis=1, initial=-np.inf)
            outside[part] = np.minimum(outside[part], distance)
    return max(0.0, float(outside.max(initial=0.0)))


def is_inside(piece: Array, others: Sequence[Array]) -> bool:
    """Return whether a convex body (k, 3) is inside one of others, which makes it superfluous."""
    low, high = piece.min(axis=0), piece.max(axis=0)
    around = (o for o in others if (o.min(axis=0) <= low).all() and (o.max(axis=0) >= high).all())
    return any(farthest_outside(piece, [other]) == 0.0 for other in around)


def points_on(triangles: Triangles, rng: np.random.Generator) -> Array:
    """Return points (n, 3) on triangles, m: their corners, their middles, and random ones, evenly spread."""
    vertices = triangles.vertices[np.unique(triangles.faces)]
    corners, area = triangles.corners, areas(triangles)
    weights = rng.dirichlet(np.ones(3), ON_SURFACE)
    chosen = rng.choice(len(corners), ON_SURFACE, p=area / area.sum()) if area.any() else np.zeros(ON_SURFACE, int)
    random = np.einsum("nk,nkx->nx", weights, corners[chosen])
    return np.vstack([_some(vertices, rng), _some(corners.mean(axis=1), rng), random])


def points_in(solid: Triangles, rng: np.random.Generator) -> Array:
    """Return random points (n, 3) inside a closed surface, m."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    points = rng.uniform(low, high, (min(INSIDE, MOST_ANGLES // len(solid.faces) + 50), 3))
    inside: Array = points[abs(winding_numbers(points, solid)) > 0.5]
    return inside


def winding_numbers(points: Array, solid: Triangles) -> Array:
    """Return how often a closed surface goes round points (n, 3): 0 outside.

    They are the sums of the solid angles of the triangles over 4 pi (Van Oosterom and Strackee, "The solid angle of a
    plane triangle", 1983).
    """
    corners, total = solid.corners, np.zeros(len(points))
    for k, point in enumerate(points):
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.sqrt(np.einsum("fx,fx->f", v, v)) for v in (a, b, c))
        ab, bc, ca = (np.einsum("fx,fx->f", v, w) for v, w in ((a, b), (b, c), (c, a)))
        triple = np.einsum("fx,fx->f", a, np.cross(b, c))
        total[k] = np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2.0 * np.pi)
    return total


def _some(points: Array, rng: np.random.Generator) -> Array:
    return points if len(points) <= ON_SURFACE else rng.choice(points, ON_SURFACE, replace=False)
