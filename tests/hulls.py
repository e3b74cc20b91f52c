"""Robots whose bodies are hulls of points."""

from __future__ import annotations

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail import Robot
from humanoid_rail.model.robot import Robot as _Robot


def hulled(robot: Robot, sides: int = 8, rings: int = 3) -> Robot:
    """Return a robot of capsules with hulls of points on these instead."""
    bodies = pin.GeometryModel(robot.collision_model)
    for body in bodies.geometryObjects:
        body.geometry = _hull(body.geometry, sides, rings)
    changed: _Robot = replace(robot, collision_model=bodies)
    return changed


def _hull(capsule: coal.Capsule, sides: int, rings: int) -> coal.CollisionGeometry:
    around = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    points = coal.StdVec_Vec3s()
    for end in (-1.0, 1.0):
        for up in np.linspace(0.0, np.pi / 2.0, rings, endpoint=False):
            ring = np.stack(
                [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.full(sides, end * np.sin(up))]
            )
            for point in capsule.radius * ring.T + [0.0, 0.0, end * capsule.halfLength]:
                points.append(point)
        points.append(np.array([0.0, 0.0, end * (capsule.halfLength + capsule.radius)]))
    return coal.Convex.convexHull(points, True, "Qt")
