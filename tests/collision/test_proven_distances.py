"""Distances that proofs rest on are never above exact ones: closed forms in extended precision."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from humanoid_rail import Box, Capsule, HalfSpace, Robot, Sphere
from humanoid_rail.collision.swept_distance import SweptDistance
from humanoid_rail.model.robot import Hand, robot_from_urdf
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.shapes import placed_shapes
from validation.plain_geometry import point_segment, rotation, segment_box, segment_segment
from validation.random_motions import numbers

ROUNDING = 64.0 * float(np.finfo(float).eps)
"""Rounding takes at most this share of the largest coordinate."""
TIGHT = 1e-5
"""Proven distances are at most this below exact ones, m, and in m per m of distance."""
KINDS = ("sphere", "capsule", "box", "halfspace")


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


def obstacle_of(kind: str, rng: np.random.Generator, scale: float, place: np.ndarray, like: tuple) -> Obstacle:
    """Return an obstacle at a place (3,), nearly parallel to a rotation as often as not."""
    size = numbers(scale * np.exp(rng.uniform(-4.0, 0.5, 3)))
    rpy = like if rng.random() < 0.5 else numbers(rng.uniform(-3.0, 3.0, 3))
    rpy = numbers(np.array(rpy) + rng.normal(size=3) * 10.0 ** rng.uniform(-10.0, -2.0))
    match kind:
        case "sphere":
            return Sphere(center=numbers(place), radius=size[0])
        case "capsule":
            return Capsule(center=numbers(place), radius=size[0], length=size[1], rpy=rpy)
        case "box":
            return Box(center=numbers(place), size=size, rpy=rpy)
        case _:
            normal = rng.normal(size=3)
            return HalfSpace(normal=numbers(normal), offset=float(normal @ place))


def exact(obstacle: Obstacle, segment: np.ndarray, radius: float) -> float:
    """Return the distance of a capsule with a segment (2, 3) as its axis, m."""
    match obstacle:
        case Sphere():
            center = np.array(obstacle.center, np.longdouble)
            return float(point_segment(center, segment) - obstacle.radius - radius)
        case Capsule():
            half = 0.5 * obstacle.length * rotation(obstacle.rpy)[:, 2].astype(np.longdouble)
            axis = np.array(obstacle.center, np.longdouble) + np.array([-half, half])
            return float(segment_segment(segment, axis) - obstacle.radius - radius)
        case Box():
            local = (segment - np.array(obstacle.center)) @ rotation(obstacle.rpy).astype(np.longdouble)
            return float(segment_box(local, 0.5 * np.array(obstacle.size, np.longdouble)) - radius)
        case HalfSpace():
            normal = np.array(obstacle.normal, np.longdouble)
            return float((segment @ normal - obstacle.offset).min() / np.sqrt(normal @ normal) - radius)
    raise TypeError(type(obstacle))


@pytest.mark.parametrize("far", [0.0, 2e3])
@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_proven_distance_is_not_above_the_exact_one(kind: str, scale: float, far: float) -> None:
    rng = np.random.default_rng([KINDS.index(kind), int(100 * scale), int(far)])
    for _ in range(25):
        radius, length = (scale * np.exp(rng.uniform([-4.0, -3.0], [-1.0, 0.5]))).tolist()
        rpy, at = numbers(rng.uniform(-3.0, 3.0, 3)), rng.uniform(-far, far, 3)
        place = at + rng.normal(size=3) * scale * np.exp(rng.uniform(-2.0, 1.0))
        obstacle = obstacle_of(kind, rng, scale, place, rpy)
        proven = SweptDistance(sliding_capsule(radius, length, rpy), (obstacle,)).distance(0, 0.0, at).distance
        half = 0.5 * np.longdouble(length) * rotation(rpy)[:, 2]
        distance = exact(obstacle, at + np.array([-half, half]), radius)
        assert proven <= distance + ROUNDING * (abs(at).max() + far + 10.0 * scale)
        if distance > 0.0:
            assert proven >= distance - TIGHT * (1.0 + distance)


def test_the_library_alone_is_above_the_exact_distance() -> None:
    """Its iterations end within 1e-6 of the distance, which is more than 1 um where that is large."""
    above = []
    rng = np.random.default_rng(3)
    for _ in range(300):
        radius, length = 1.0, 30.0
        rpy = numbers(rng.normal(size=3) * 10.0 ** rng.uniform(-9.0, -2.0))
        obstacle = Box(center=numbers(rng.normal(0.0, 60.0, 3)), size=(40.0, 20.0, 10.0), rpy=rpy)
        half = 0.5 * length * np.eye(3, dtype=np.longdouble)[2]
        (box,) = placed_shapes(obstacle)
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        capsule = coal.Capsule(radius, length)
        measured = coal.distance(capsule, coal.Transform3s(), box.shape, box.placement, request, result)
        distance = exact(obstacle, np.array([-half, half]), radius)
        if distance > 0.0:
            above.append(measured - distance)
    assert max(above) > 2e-6


def test_rotations_of_the_oracle_are_those_of_the_robot() -> None:
    assert rotation((0.3, -0.4, 0.5)) == pytest.approx(pin.rpy.rpyToMatrix(0.3, -0.4, 0.5), abs=1e-15)
