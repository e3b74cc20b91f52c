"""Convex bodies of few vertices that contain others of many: coal takes no vertex of 255 neighbours or more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.simple_hull import DIRECTIONS, farthest
from humanoid_rail.geometry.solids import size_of

MOST_VERTICES = 250
"""A convex body has no more vertices than this: so none has 255 neighbours, and distances do not take long."""
SWELLING = 1e-3
"""A body of fewer vertices gets more until it is larger than the original by no more than this share of its size."""
MOST_SWELLING = 0.03
"""A body that is larger than the original by more than this share of its size is not used."""


def enclosing_hull(points: Array) -> Array:
    """Return the vertices (k, 3) of a convex body that contains points (n, 3), m: their hull if it has few vertices.

    Otherwise it is the hull of some of them, enlarged about its middle until it contains them all. Those are taken
    that stick out most of the hull of those before.

    Raises:
        ValueError: If the points lie in a plane, or the body would be too large.
    """
    vertices = points[ConvexHull(points).vertices]
    if len(vertices) <= MOST_VERTICES:
        return vertices
    taken: NDArray[np.int64] = np.unique(farthest(vertices, DIRECTIONS)[0])
    while True:
        middle = vertices[taken].mean(axis=0)
        planes = ConvexHull(vertices[taken] - middle).equations
        # How far the body has to be enlarged for each vertex to be behind each plane.
        normals = planes[:, :3] / -planes[:, 3:]
        first, factors = farthest(vertices - middle, normals)
        factor = max(1.0, float(factors.max()))
        reach = float(np.linalg.norm(vertices[taken] - middle, axis=1).max())
        swelling = (factor - 1.0) * reach / size_of(vertices)
        more = np.setdiff1d(first, taken)
        room = MOST_VERTICES - len(taken)
        if swelling <= SWELLING or not more.size or not room:
            break
        sticks_out = ((vertices[more] - middle) @ normals.T).max(axis=1)
        outermost = np.argsort(-sticks_out, kind="stable")[:room]
        taken = np.union1d(taken, more[outermost])
    if swelling > MOST_SWELLING:
        raise ValueError(f"a mesh whose convex parts can be made of {MOST_VERTICES} vertices or fewer each")
    enlarged: Array = middle + factor * (1.0 + 1e-12) * (vertices[taken] - middle)
    return enlarged
