"""A random capsule near a random obstacle: the proven distance and the exact one, in extended precision."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from humanoid_rail import Box, Capsule, Cylinder, HalfSpace, Robot, Sphere
from humanoid_rail._arrays import Array, triple
from humanoid_rail.collision.swept_distance import SweptDistance
from humanoid_rail.model.building import robot_from_urdf
from humanoid_rail.model.robot import Hand
from humanoid_rail.scene.obstacles import Obstacle
from validation.plain_geometry import point_segment, rotation, segment_box, segment_cylinder, segment_segment

EXTENDED: Any = np.longdouble
"""The precision of the closed forms."""
KINDS = ("sphere", "capsule", "box", "halfspace", "cylinder")


class Measured(NamedTuple):
    """How far a capsule is from an obstacle."""

    proven: float
    """m."""
    exact: float
    """m."""
    largest: float
    """The largest coordinate of the two places, m."""


def measured_distances(kind: str, rng: np.random.Generator, scale: float, far: float) -> Measured:
    """Return the distances of a random capsule from a random obstacle of a kind.

    Args:
        kind: One of KINDS.
        rng: What makes them up.
        scale: How large they are and how far apart, m.
        far: How far from the base they are along each axis, m.
    """
    radius, length = (scale * np.exp(rng.uniform([-4.0, -3.0], [-1.0, 0.5]))).tolist()
    rpy, at = triple(rng.uniform(-3.0, 3.0, 3)), rng.uniform(-far, far, 3)
    place = at + rng.normal(size=3) * scale * np.exp(rng.uniform(-2.0, 1.0))
    obstacle = obstacle_of(kind, rng, scale, place, rpy)
    proven = SweptDistance(sliding_capsule(radius, length, rpy), (obstacle,)).distance(0, 0.0, at).distance
    half = 0.5 * EXTENDED(length) * rotation(rpy)[:, 2]
    exact = exact_distance(obstacle, at + np.array([-half, half]), radius)
    return Measured(proven, exact, float(max(abs(at).max(), abs(place).max())))


def sliding_capsule(radius: float, length: float, rpy: tuple[float, float, float]) -> Robot:
    """Return a capsule on three prismatic joints, so that a configuration is a place, m."""
    limit = '<limit lower="-1e4" upper="1e4" effort="1" velocity="1"/>'
    parts = ['<link name="base"/><link name="x"/><link name="y"/>']
    for parent, child, axis in (("base", "x", "1 0 0"), ("x", "y", "0 1 0"), ("y", "tip", "0 0 1")):
        parts.append(
            f'<joint name="to_{child}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>'
            f'<axis xyz="{axis}"/>{limit}</joint>'
        )
    parts.append(
        f'<link name="tip"><collision name="body"><origin rpy="{" ".join(map(repr, rpy))}"/><geometry>'
        f'<cylinder radius="{radius!r}" length="{length!r}"/></geometry></collision>'
        '<collision_checking><capsule name="body"/></collision_checking></link>'
    )
    return robot_from_urdf(
        f'<robot name="r" version="1.0">{"".join(parts)}</robot>', None, [Hand("h", "tip", ("to_x", "to_y", "to_tip"))]
    )


def obstacle_of(
    kind: str, rng: np.random.Generator, scale: float, place: Array, like: tuple[float, float, float]
) -> Obstacle:
    """Return an obstacle at a place (3,), nearly parallel to a rotation as often as not."""
    size = triple(scale * np.exp(rng.uniform(-4.0, 0.5, 3)))
    rpy = like if rng.random() < 0.5 else triple(rng.uniform(-3.0, 3.0, 3))
    rpy = triple(np.array(rpy) + rng.normal(size=3) * 10.0 ** rng.uniform(-10.0, -2.0))
    match kind:
        case "sphere":
            return Sphere(center=triple(place), radius=size[0])
        case "capsule":
            return Capsule(center=triple(place), radius=size[0], length=size[1], rpy=rpy)
        case "box":
            return Box(center=triple(place), size=size, rpy=rpy)
        case "cylinder":
            return Cylinder(center=triple(place), radius=size[0], length=size[1], rpy=rpy)
        case _:
            normal = rng.normal(size=3)
            return HalfSpace(normal=triple(normal), offset=float(normal @ place))


def exact_distance(obstacle: Obstacle, segment: Array, radius: float) -> float:
    """Return the distance of a capsule with a segment (2, 3) as its axis, m.

    Raises:
        TypeError: If there is no closed form.
    """
    match obstacle:
        case Sphere():
            center = np.array(obstacle.center, EXTENDED)
            return float(point_segment(center, segment) - obstacle.radius - radius)
        case Capsule():
            half = 0.5 * obstacle.length * rotation(obstacle.rpy)[:, 2].astype(EXTENDED)
            axis = np.array(obstacle.center, EXTENDED) + np.array([-half, half])
            return float(segment_segment(segment, axis) - obstacle.radius - radius)
        case Box():
            local = (segment - np.array(obstacle.center)) @ rotation(obstacle.rpy).astype(EXTENDED)
            return float(segment_box(local, 0.5 * np.array(obstacle.size, EXTENDED)) - radius)
        case Cylinder():
            local = (segment - np.array(obstacle.center)) @ rotation(obstacle.rpy).astype(EXTENDED)
            size = EXTENDED(obstacle.radius), 0.5 * EXTENDED(obstacle.length)
            return float(segment_cylinder(local, *size) - radius)
        case HalfSpace():
            normal = np.array(obstacle.normal, EXTENDED)
            return float((segment @ normal - obstacle.offset).min() / np.sqrt(normal @ normal) - radius)
    raise TypeError(f"no distance from a {obstacle.type}")
