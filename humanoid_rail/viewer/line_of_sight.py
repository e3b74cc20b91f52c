"""Whether a robot hides its own hands from a camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.viewer.occlusion import crosses_box
from humanoid_rail.viewer.sizes import robot_points, scale

NEAR_HAND = 0.3
"""Bodies of the robot do not count so near a hand, m; it is scaled with the robot."""


def hidden_hands(robot: Robot, q: Array, eyes: Array) -> Array:
    """Return the share of the hands that bodies of the robot hide from each of some cameras (C,).

    Bodies are taken as the boxes around them, along the axes of the base frame: that is enough to compare views.

    Args:
        robot: The robot.
        q: Its configuration (n,), m and rad.
        eyes: Where the cameras are (C, 3), m.
    """
    boxes, hands = robot_points(robot, (), q).reshape(-1, 8, 3), Kinematics(robot).hand_positions(q)
    bodies = np.stack([boxes.min(axis=1), boxes.max(axis=1)], axis=1)
    shares = []
    for eye in eyes:
        back = (eye - hands) / np.linalg.norm(eye - hands, axis=1, keepdims=True)
        before = hands + NEAR_HAND * scale(robot) * back
        shares.append(float(crossed(before, eye, bodies).any(axis=1).mean()))
    return np.array(shares)


def crossed(points: Array, eye: Array, boxes: Array) -> NDArray[np.bool_]:
    """Return which boxes (m, 2, 3) the lines from points (k, 3) to the eye (3,) cross (k, m)."""
    return crosses_box(points[:, None], (eye - points)[:, None], boxes[:, 0], boxes[:, 1])
