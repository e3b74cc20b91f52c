"""Distances of objects, obstacles and bones by plain geometry: edges of one body from the other one. NumPy and SciPy.

Two convex bodies that do not touch are nearest at an edge of one of them, so that their distance is that of the edges
of each from the solid of the other one. Spheres and capsules are points and segments with a radius.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from humanoid_rail._arrays import Array, triple
from humanoid_rail.scene.obstacles import Box, Capsule, HalfSpace, Mesh, Obstacle, Sphere
from validation.plain_geometry import RADIUS, STRIDE, rotation, segment_box, segment_segment

FLAT = 1e-9
"""Faces whose normals differ by less are one."""


@dataclass(frozen=True, eq=False)
class Polytope:
    """A convex polytope in a frame of its own."""

    edges: Array
    """(E, 2, 3), m."""
    triangles: Array
    """(F, 3, 3), m, each one counterclockwise seen from outside."""
    normals: Array
    """(F, 3), outwards, of length 1."""
    offsets: Array
    """(F,): inside, normals @ x <= offsets, m."""

    def distance(self, segments: Array) -> Array:
        """Return the distances (...) of segments (..., 2, 3), 0 where they touch, m."""
        apart = segment_segment(segments[..., None, :, :], self.edges).min(axis=-1)
        apart = np.minimum(apart, self._from_faces(segments).min(axis=(-1, -2)))
        heights = segments @ self.normals.T - self.offsets
        start, change = heights[..., 0, :], heights[..., 1, :] - heights[..., 0, :]
        with np.errstate(divide="ignore", invalid="ignore"):
            cut = -start / change
        enter = np.where(change < 0.0, cut, np.where((change == 0.0) & (start > 0.0), np.inf, -np.inf)).max(axis=-1)
        leave = np.where(change > 0.0, cut, np.inf).min(axis=-1)
        touching = np.maximum(enter, 0.0) <= np.minimum(leave, 1.0)
        return np.where(touching, 0.0, apart)

    def _from_faces(self, points: Array) -> Array:
        """Return how high points (..., 3) are above each face (..., F), m; infinite where they are not above it."""
        heights = points @ self.normals.T - self.offsets
        above = heights > 0.0
        for i in range(3):
            a, b = self.triangles[:, i], self.triangles[:, (i + 1) % 3]
            inwards = np.cross(self.normals, b - a)
            above &= points @ inwards.T - np.einsum("fi,fi->f", inwards, a) >= 0.0
        return np.where(above, heights, np.inf)


@cache
def _polytope(points: tuple[tuple[float, float, float], ...]) -> Polytope:
    corners = np.array(points)
    hull = ConvexHull(corners)
    triangles, normals, offsets = corners[hull.simplices], hull.equations[:, :3], -hull.equations[:, 3]
    turned = np.einsum(
        "fi,fi->f", np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), normals
    )
    triangles = np.where((turned < 0.0)[:, None, None], triangles[:, ::-1], triangles)
    pairs = sorted({tuple(sorted(pair)) for simplex in hull.simplices for pair in combinations(simplex, 2)})
    return Polytope(corners[np.array(pairs)], triangles, normals, offsets)


@dataclass(frozen=True, eq=False)
class Body:
    """A body at K moments; at one moment if it never moves."""

    edges: Array
    """(K, E, 2, 3), m: of a sphere its center, of a capsule its axis."""
    radius: float = 0.0
    """m."""
    solid: Polytope | Array | None = None
    """What is between the edges: a polytope, or the half sizes (3,) of a box."""
    rotation: Array | None = None
    """(K, 3, 3), of the solid."""
    place: Array | None = None
    """(K, 3), of the solid, m."""
    plane: tuple[Array, Array] | None = None
    """The normal (3,) of length 1 of a half-space, and its offset (K,), m."""

    def at(self, k: NDArray[np.int64] | slice) -> Body:
        """Return it at some of the moments."""
        if self.plane is not None:
            normal, offset = self.plane
            return self if len(offset) == 1 else replace(self, plane=(normal, offset[k]))
        if len(self.edges) == 1:
            return self
        if self.rotation is None or self.place is None:
            return replace(self, edges=self.edges[k])
        return replace(self, edges=self.edges[k], rotation=self.rotation[k], place=self.place[k])

    def shift(self) -> Array:
        """Return how far its points are at most from where they were at the multiple of STRIDE before (K,), m."""
        if self.plane is not None:
            offset = self.plane[1]
            moved: Array = abs(offset - np.repeat(offset[::STRIDE], STRIDE)[: len(offset)])
            return moved
        anchors = np.repeat(self.edges[::STRIDE], STRIDE, axis=0)[: len(self.edges)]
        found: Array = np.sqrt(((self.edges - anchors) ** 2).sum(axis=-1)).max(axis=(1, 2))
        return found

    def from_edges(self, edges: Array) -> Array:
        """Return how far edges (K, E, 2, 3) are from it without its radius, 0 where they touch (K,), m."""
        if self.plane is not None:
            normal, offset = self.plane
            heights: Array = (edges @ normal).min(axis=(1, 2)) - offset
            return heights
        if self.solid is None:
            pairs = segment_segment(edges[:, :, None], self.edges[:, None])
            return np.asarray(pairs.min(axis=(1, 2)))
        assert self.rotation is not None
        assert self.place is not None
        turned = np.broadcast_to(self.rotation, (max(len(edges), len(self.place)), 3, 3))
        local = np.einsum("kesi,kij->kesj", edges - self.place[:, None, None], turned)
        apart = self.solid.distance(local) if isinstance(self.solid, Polytope) else segment_box(local, self.solid)
        return np.asarray(apart.min(axis=1))


def distance(one: Body, other: Body) -> Array:
    """Return the clearances (K,) of two bodies, m; bodies without radius that touch have none."""
    if one.plane is not None or (one.solid is not None and other.solid is None and other.plane is None):
        one, other = other, one
    apart = other.from_edges(one.edges)
    if one.solid is not None and other.solid is not None:
        apart = np.minimum(apart, one.from_edges(other.edges))
    return apart - one.radius - other.radius


def clearances(one: Body, other: Body, count: int, near: float) -> Array:
    """Return the clearances (count,) of two bodies at as many moments, m.

    Of those that are neither the smallest nor below `near` (m) only a lower bound.
    """
    anchors = np.arange(0, count, STRIDE)
    apart = np.broadcast_to(distance(one.at(anchors), other.at(anchors)), len(anchors))
    lower = np.repeat(apart, STRIDE)[:count] - one.shift() - other.shift()
    k = np.flatnonzero(lower < max(near, float(apart.min())))
    if len(k):
        lower[k] = distance(one.at(k), other.at(k))
    return lower


def bone(ends: Array) -> Body:
    """Return a bone with end points (K, 2, 3), m."""
    return Body(ends[:, None], RADIUS)


def point(at: Array) -> Body:
    """Return a point (3,), m."""
    return Body(np.broadcast_to(at, (1, 1, 2, 3)))


def body_of(shape: Obstacle, turned: Array, place: Array) -> Body:
    """Return an object or an obstacle whose frame is turned (K, 3, 3) and at a place (K, 3), m.

    Raises:
        TypeError: If there is no plain geometry for it.
    """
    match shape:
        case Sphere():
            return Body(np.repeat(place[:, None, None], 2, axis=2), shape.radius)
        case Capsule():
            half = 0.5 * shape.length * turned[:, :, 2]
            return Body(np.stack([place - half, place + half], axis=1)[:, None], shape.radius)
        case Box():
            half = 0.5 * np.array(shape.size)
            corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij")).reshape(3, -1).T * half
            pairs = [(i, j) for i, j in combinations(range(8), 2) if (corners[i] != corners[j]).sum() == 1]
            return _solid(corners[np.array(pairs)], half, turned, place)
        case Mesh():
            scale = np.broadcast_to(np.array(shape.scale), 3)
            lines = [line.split() for line in Path(shape.file).read_text(encoding="utf-8").splitlines()]
            points = [scale * np.array(line[1:], float) for line in lines if line[:1] == ["v"]]
            found = _polytope(tuple(map(triple, points)))
            return _solid(found.edges, found, turned, place)
    raise TypeError(f"no plain geometry for a {shape.type}")


def _solid(edges: Array, solid: Polytope | Array, turned: Array, place: Array) -> Body:
    there = np.einsum("kij,esj->kesi", turned, edges) + place[:, None, None]
    return Body(there, 0.0, solid, turned, place)


def obstacle_body(obstacle: Obstacle, t: Array) -> Body:
    """Return an obstacle at times (K,), s."""
    velocity = np.array(obstacle.velocity)
    times = t if velocity.any() else t[:1] * 0.0
    if isinstance(obstacle, HalfSpace):
        normal, length = np.array(obstacle.normal), float(np.linalg.norm(obstacle.normal))
        return Body(
            np.zeros((1, 1, 2, 3)),
            plane=(normal / length, obstacle.offset / length + times * (normal @ velocity) / length),
        )
    turned = np.broadcast_to(rotation(getattr(obstacle, "rpy", (0.0, 0.0, 0.0))), (len(times), 3, 3))
    return body_of(obstacle, turned, np.array(obstacle.center) + times[:, None] * velocity)
