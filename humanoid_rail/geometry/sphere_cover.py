"""Point clouds as spheres: a ball around each point, or fewer balls that contain all of these."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array, frozen

ROUNDING = 1e-9
"""Radii of the cover are larger by this, m, so that rounding leaves no point out."""


class SphereCover(NamedTuple):
    """Spheres that contain the balls of a radius around all points of a cloud."""

    centers: Array
    """(k, 3), m."""
    radii: Array
    """(k,), m."""
    swelling: float
    """No point of a sphere is farther than this from the balls that it stands for, m; 0 where each has its own."""


def sphere_cover(points: Array, radius: float, voxel: float | None = None) -> SphereCover:
    """Return spheres that contain the balls of a radius around points.

    Without voxels each point has its own, and points that are the same have one. With voxels those in the same cube of
    a grid share one sphere: around the middle c of the box around them, with the radius r + max |p - c|. It contains
    the ball of each of them, by the triangle inequality. A point x of the sphere is no farther from the nearest ball
    than |x - c| + min |p - c| - r <= max |p - c| + min |p - c|, which is less than the diagonal of a voxel.

    Args:
        points: The points (n, 3), m.
        radius: The radius r of their balls, m.
        voxel: The edge of the cubes, m.
    """
    different = np.unique(points, axis=0)
    if voxel is None:
        return SphereCover(frozen(different), frozen(np.full(len(different), radius)), 0.0)
    cubes = np.floor(different / voxel).astype(np.int64)
    order = np.lexsort(cubes.T)
    cubes, sorted_points = cubes[order], different[order]
    is_first = np.concatenate([[True], (np.diff(cubes, axis=0) != 0).any(axis=1)])
    starts, owner = np.flatnonzero(is_first), np.cumsum(is_first) - 1
    low, high = np.minimum.reduceat(sorted_points, starts), np.maximum.reduceat(sorted_points, starts)
    centers = (low + high) / 2.0
    away = np.linalg.norm(sorted_points - centers[owner], axis=1)
    farthest, nearest = np.maximum.reduceat(away, starts), np.minimum.reduceat(away, starts)
    radii = radius + farthest + ROUNDING
    return SphereCover(frozen(centers), frozen(radii), float((farthest + nearest).max()) + ROUNDING)
