"""What hides a robot from a camera: rays from points of it, against the obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import coal
import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes

Indices = NDArray[np.intp]

MOST = 1000
"""So many bodies are looked at at most; of more, every so many of them."""


class Blockers(NamedTuple):
    """Bodies that can hide something, as boxes. B bodies."""

    centre: Array
    """(B, 3), m, at t = 0."""
    rotation: Array
    """From their own frames to the base frame (B, 3, 3)."""
    half: Array
    """Half their sizes along their own axes (B, 3), m."""
    is_ball: Array
    """1 for a sphere, whose radius is half of any size (B,)."""
    velocity: Array
    """(B, 3), m/s."""


def blockers(obstacles: Sequence[Obstacle]) -> Blockers:
    """Return the bodies of obstacles as boxes around them and spheres; half-spaces are left out."""
    bodies = [(placed, obstacle.velocity) for obstacle in obstacles for placed in placed_shapes(obstacle)]
    bodies = [(placed, velocity) for placed, velocity in bodies if not isinstance(placed.shape, coal.Halfspace)]
    bodies = bodies[:: -(-len(bodies) // MOST) or 1]
    rows = [(*_box(placed), isinstance(placed.shape, coal.Sphere), velocity) for placed, velocity in bodies]
    shapes = ((3,), (3, 3), (3,), (), (3,))
    columns = zip(*rows, strict=True) if rows else [()] * len(shapes)
    return Blockers(*(np.array(column, float).reshape(-1, *k) for column, k in zip(columns, shapes, strict=True)))


def hidden(bodies: Blockers, camera: Array, points: Array, t: Array) -> NDArray[np.bool_]:
    """Return which points a camera does not see, (P,) of bool.

    Args:
        bodies: What hides them.
        camera: Where the camera is (3,), m.
        points: The points (P, 3), m.
        t: When each of them is there (P,), s.
    """
    found = np.zeros(len(points), bool)
    if not len(bodies.centre):
        return found
    is_moving = bodies.velocity.any()
    for moment in np.unique(t) if is_moving else [0.0]:
        now = np.flatnonzero(t == moment) if is_moving else np.arange(len(points))
        there = bodies._replace(centre=bodies.centre + moment * bodies.velocity)
        found[now[_crossings(there, camera, points[now])[0]]] = True
    return found


def hiding(bodies: Blockers, camera: Array, points: Array) -> NDArray[np.bool_]:
    """Return which bodies hide any of the points (P, 3) from a camera (3,), m, at t = 0; (B,) of bool."""
    found = np.zeros(len(bodies.centre), bool)
    if len(found):
        found[_crossings(bodies, camera, points)[1]] = True
    return found


def crosses_box(start: Array, ray: Array, low: Array, high: Array) -> NDArray[np.bool_]:
    """Return which segments, from a start (..., 3) along a ray (..., 3), cross boxes along the axes, (...) of bool.

    Args:
        start: Where the segments begin, m.
        ray: From there to where they end, m.
        low: The lowest corners of the boxes (..., 3), m.
        high: Their highest corners (..., 3), m.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        one, two = (low - start) / ray, (high - start) / ray
    enter, leave = np.fmin(one, two).max(axis=-1), np.fmax(one, two).min(axis=-1)
    crossed: NDArray[np.bool_] = (enter <= leave) & (leave > 0) & (enter < 1)
    return crossed


def _crossings(bodies: Blockers, camera: Array, points: Array) -> tuple[Indices, Indices]:
    """Return the points and the bodies, by number, of the pairs in which the body hides the point."""
    ray = camera - points
    length = np.linalg.norm(ray, axis=1)
    radius = np.linalg.norm(bodies.half, axis=1)
    point, body = _near(bodies.centre, radius, points, ray / length[:, None], length)
    met = _meets(bodies, body, points[point], ray[point])
    return point[met], body[met]


def _near(centre: Array, radius: Array, points: Array, along: Array, length: Array) -> tuple[Indices, Indices]:
    """Return the rays and the bodies, by number, of the pairs whose ray comes near the ball around the body."""
    # |b - p|^2 and (b - p) u by products of matrices: there are millions of pairs.
    forward = along @ centre.T - np.einsum("ij,ij->i", along, points)[:, None]
    apart = np.einsum("ij,ij->i", points, points)[:, None] - 2 * points @ centre.T
    apart += np.einsum("ij,ij->i", centre, centre)
    near = (apart - forward**2 < radius**2) & (forward > -radius) & (forward < length[:, None] + radius)
    ray, body = np.nonzero(near)
    return ray, body


def _meets(bodies: Blockers, body: Indices, start: Array, ray: Array) -> NDArray[np.bool_]:
    """Return for pairs of a body (k,) and a segment from (k, 3) along (k, 3) whether they meet, (k,) of bool."""
    offset = start - bodies.centre[body]
    rotation, half = bodies.rotation[body], bodies.half[body]
    at, to = np.einsum("kij,ki->kj", rotation, offset), np.einsum("kij,ki->kj", rotation, ray)
    box = crosses_box(at, to, -half, half)
    share = np.clip(-np.einsum("ij,ij->i", offset, ray) / np.einsum("ij,ij->i", ray, ray), 0.0, 1.0)
    ball = np.linalg.norm(offset + share[:, None] * ray, axis=1) < half[:, 0]
    met: NDArray[np.bool_] = np.where(bodies.is_ball[body] > 0, ball, box)
    return met


def _box(placed: PlacedShape) -> tuple[Array, Array, Array]:
    """Return centre (3,), axes (3, 3) and half the size (3,) of the box around a shape in its own frame, m."""
    placed.shape.computeLocalAABB()
    low, high = np.array(placed.shape.aabb_local.min_), np.array(placed.shape.aabb_local.max_)
    rotation = np.array(placed.placement.getRotation())
    centre = rotation @ ((low + high) / 2) + np.array(placed.placement.getTranslation())
    return centre, rotation, (high - low) / 2
