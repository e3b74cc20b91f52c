"""Bounds of how far links move and how near bodies come on an edge, and support functions."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest
from conftest import random_q, random_scene

from humanoid_rail import HalfSpace, Kinematics, Robot
from humanoid_rail.collision.motion_bound import MotionBound
from humanoid_rail.collision.swept_distance import SweptDistance
from humanoid_rail.scene.shapes import placed_shapes, support


def test_motion_bounds_hold_for_points(robot: Robot, rng: np.random.Generator) -> None:
    """Both ends of every bone, seen from the base and from other joints, on random straight ways."""
    bound, tight = MotionBound(robot), []
    for _ in range(60):
        a = random_q(robot, rng)
        b = a + rng.normal(size=robot.n) * rng.choice([0.01, 0.1])
        full = [robot.full_configuration(q) for q in (a, b)]
        ways = np.linspace(a, b, 201)
        for origin in (0, robot.model.getJointId("rail"), robot.model.getJointId("spine_pitch")):
            seen = np.array([_bones_from(robot, origin, q) for q in ways])
            reach = bound.displacements(full[1] - full[0], np.maximum(*abs(np.array(full))), origin)
            way = np.linalg.norm(np.diff(seen, axis=0), axis=-1).sum(axis=0).max(axis=-1)
            bend = np.linalg.norm(np.diff(seen, 2, axis=0), axis=-1).max(axis=0).max(axis=-1) * 200**2
            carried = reach.length > 0
            assert (way[carried] <= reach.length[carried] + 1e-9).all()
            assert (bend[carried] <= reach.curvature[carried] * (1 + 1e-6) + 1e-6).all()
            tight.append((way[carried] / reach.length[carried]).max())
    assert max(tight) > 0.5


def _bones_from(robot: Robot, origin: int, q: np.ndarray) -> np.ndarray:
    """Return the ends of all bones in the frame of a joint."""
    data = robot.model.createData()
    bones = Kinematics(robot).bones(q)
    pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
    M = data.oMi[origin]
    return (bones - M.translation) @ M.rotation


def test_the_chest_that_stays_level_does_not_turn(robot: Robot) -> None:
    """Turns about parallel axes add up with their signs: with the torso bending, the hands move as the chest does."""
    bound = MotionBound(robot)
    a, b = robot.initial.copy(), robot.initial.copy()
    b[2] += 0.1
    full = [robot.full_configuration(q) for q in (a, b)]
    reach = bound.displacements(full[1] - full[0], abs(full[0]), 0)
    hand = list(robot.link_names).index("left_forearm")
    assert reach.length[hand] == pytest.approx(0.1 * (0.5 + 0.5), rel=1e-9)


def test_lower_bounds_hold_on_edges(robot: Robot, rng: np.random.Generator) -> None:
    """Least distances of random pairs on random edges against dense sampling."""
    scene = random_scene(rng)
    swept, closest = SweptDistance(robot, scene.obstacles), []
    for _ in range(15):
        a = random_q(robot, rng)
        b = a + rng.normal(size=robot.n) * 0.05
        for pair in range(len(swept.pairs)):
            bound = swept.lower_bound(pair, 0.0, a, 1.0, b)
            least = min(swept.distance(pair, s, a + s * (b - a)).distance for s in np.linspace(0, 1, 41))
            assert bound <= least + 2e-6
            if least > 0:
                closest.append(least - bound)
    assert np.median(closest) < 0.02


def test_support_functions(rng: np.random.Generator) -> None:
    """Against points on the surfaces, by coal's own distance from a far plane."""
    shapes = random_scene(rng).obstacles[:3]
    for obstacle in shapes:
        (placed,) = placed_shapes(obstacle)
        for _ in range(20):
            n = rng.normal(size=3)
            n /= np.linalg.norm(n)
            (plane,) = placed_shapes(HalfSpace(normal=tuple(-n), offset=-50.0))
            result = coal.DistanceResult()
            request = coal.DistanceRequest()
            far = coal.distance(placed.shape, placed.placement, plane.shape, plane.placement, request, result)
            assert support(placed, n) == pytest.approx(50.0 - far, abs=1e-6)
