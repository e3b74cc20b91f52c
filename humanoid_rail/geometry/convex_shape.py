"""Convex bodies as coal has them."""

from __future__ import annotations

import coal

from humanoid_rail._arrays import Array


def convex_shape(vertices: Array) -> coal.ConvexBase:
    """Return the convex hull of points (k, 3) as a shape of coal."""
    points = coal.StdVec_Vec3s()
    points.extend(list(vertices))
    return coal.ConvexBase.convexHull(points, True, "Qt")
