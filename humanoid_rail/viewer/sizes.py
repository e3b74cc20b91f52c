"""How large things in a picture are: as large as suits the robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.shapes import PlacedShape
from humanoid_rail.viewer.visual_meshes import Visual

REACH = 2.0
"""An arm of the paper's robot reaches as far, m; what is drawn is made for that, and scaled for other robots."""
SMALLEST = 0.05
"""Nothing is drawn smaller than by this factor."""


def scale(robot: Robot) -> float:
    """Return how large a robot is, compared with the paper's: by the reach of its longest arm."""
    return max(max(robot.arm_reaches, default=REACH) / REACH, SMALLEST)


def robot_points(robot: Robot, visuals: Sequence[Visual], q: ArrayLike) -> Array:
    """Return points (k, 3) around a robot: vertices of its meshes, and corners of boxes around its other bodies, m.

    Args:
        robot: The robot.
        visuals: Its visual bodies.
        q: Configuration (n,), m and rad.
    """
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.full_configuration(q))
    return np.vstack([np.zeros((0, 3)), *_points(robot, data, visuals)])


def bounds(placed: PlacedShape) -> Array:
    """Return the corners (2, 3) of the box around a shape, m; none (0, 3) for a half-space, which has no end."""
    if isinstance(placed.shape, coal.Halfspace):
        return np.zeros((0, 3))
    body = coal.CollisionObject(placed.shape, placed.placement)
    body.computeAABB()
    return np.array([body.getAABB().min_, body.getAABB().max_])


def corners(box: Array) -> Array:
    """Return the eight corners (8, 3) of a box that is given by two of them (2, 3)."""
    return np.array(np.meshgrid(*box.T)).reshape(3, -1).T


def _points(robot: Robot, data: pin.Data, visuals: Sequence[Visual]) -> Iterator[Array]:
    for visual in visuals:
        placement = data.oMi[robot.model.getJointId(visual.joint)] * visual.placement
        if isinstance(visual.shape, Sequence):
            for part in visual.shape:
                yield part.vertices @ placement.rotation.T + placement.translation
        else:
            yield corners(bounds(PlacedShape(visual.shape, coal_placement(placement))))
    for body in robot.collision_model.geometryObjects:
        yield corners(bounds(PlacedShape(body.geometry, coal_placement(data.oMi[body.parentJoint] * body.placement))))
