"""Turns the targets of a scene into tasks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from humanoid_rail._arrays import triple
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.task import ConfigurationTask, PointTask, Task, orientation_lever
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.scene.joint_targets import joint_targets
from humanoid_rail.scene.targets import ANY_AXIS, Pose, Step, direction, orientation, pointing_direction, position


def tasks_of(robot: Robot, step: Step) -> tuple[Task, ...]:
    """Return the tasks of a step of a scene that was checked: the points of all hands, joints, how hands are turned.

    The orientation of a hand is where its points are: one behind its own gives the direction it points in, and two on
    different axes give its orientation. So what moves points also turns hands, and all errors are in m.
    """
    points: list[Task] = [
        PointTask(name, position(target)) for name in robot.hand_names if (target := step.get(name)) is not None
    ]
    turned = [
        PointTask(hand.name, at, offset)
        for hand in robot.hands
        if isinstance(target := step.get(hand.name), Pose)
        for offset, at in _further_points(hand, target, orientation_lever(robot, hand.name))
    ]
    at = joint_targets(robot, step)
    joints = [ConfigurationTask(tuple(at), tuple(at.values()))] if at else []
    return (*points, *joints, *turned)


def _further_points(
    hand: Hand, pose: Pose, lever: float
) -> Iterator[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Yield offsets in a hand's frame and where the points there have to be, m.

    Raises:
        InvalidInput: If the hand has to point somewhere and has nothing that points.
    """
    if hand.pointing is None and pointing_direction(pose) is not None:
        valid = "no direction to point in: the robot's file names none that this hand points in (hands.*.pointing)"
        raise InvalidInput(f"targets.{hand.name}.approach", pose.approach, valid)
    place, along = np.array(pose.position), hand.pointing or ANY_AXIS
    pointing, towards = np.array(along) / np.linalg.norm(along), direction(pose, along)
    if towards is not None:
        yield triple(-lever * pointing), triple(place - lever * towards)
    if (turned := orientation(pose)) is not None:
        across = np.cross(pointing, np.eye(3)[abs(pointing).argmin()])
        across /= np.linalg.norm(across)
        yield triple(-lever * across), triple(place - lever * turned @ across)
