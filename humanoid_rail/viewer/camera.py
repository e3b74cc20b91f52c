"""What is to be seen of a motion, and from where."""

from __future__ import annotations

import coal
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.scene.targets import position
from humanoid_rail.trajectory import Trajectory

CAMERA = np.array([-1.45, -1.2, 0.5])
"""Where the camera is from the middle of what is to be seen, in units of its radius; mirrored where a wall is there."""
ZOOM = 1.9
"""The camera magnifies by this factor."""
NEARBY = 1.5
"""Obstacles count for the picture within this distance of robot and targets, m."""


def viewpoint(robot: Robot, scene: Scene, trajectory: Trajectory) -> tuple[Array, Array]:
    """Return the middle (3,) of what is to be seen, and where the camera is from there (3,), m.

    To be seen are the robot during the whole motion, the targets and those parts of the obstacles that are near them.
    """
    kinematics = Kinematics(robot)
    times = np.linspace(0.0, trajectory.duration, 12)
    robots = np.vstack([kinematics.stick_figure(trajectory.configuration(t)) for t in times])
    targets = [position(target) for step in scene.steps for target in step.values() if target is not None]
    points = np.vstack([robots, trajectory.hands.reshape(-1, 3), targets])
    low, high = points.min(axis=0), points.max(axis=0)
    boxes = [_bounds(piece) for obstacle in scene.obstacles for piece in placed_shapes(obstacle)]
    near = np.clip(np.vstack([points, *boxes]), low - NEARBY, high + NEARBY)
    low, high = near.min(axis=0), near.max(axis=0)
    middle, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1.0)
    walls = [(np.array(o.normal), o.offset) for o in scene.obstacles if isinstance(o, HalfSpace)]
    cameras = [radius * CAMERA * [x, y, 1.0] for x in (1, -1) for y in (1, -1)]
    clear = [camera for camera in cameras if all(n @ (middle + camera) > d for n, d in walls)]
    return middle, (clear or cameras)[0]


def _bounds(placed: PlacedShape) -> Array:
    """Return the corners (2, 3) of the box around a shape, m; none (0, 3) for a half-space, which has no end."""
    if isinstance(placed.shape, coal.Halfspace):
        return np.zeros((0, 3))
    body = coal.CollisionObject(placed.shape, placed.placement)
    body.computeAABB()
    return np.array([body.getAABB().min_, body.getAABB().max_])
