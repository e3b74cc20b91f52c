"""Turns the targets of a scene into tasks."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from humanoid_rail._arrays import triple
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.kept_tasks import AxisTask, OrientationTask
from humanoid_rail.kinematics.task import ConfigurationTask, PointTask, Task, orientation_lever
from humanoid_rail.kinematics.within_task import BASE, WithinTask
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.scene.joint_targets import joint_targets
from humanoid_rail.scene.targets import (
    ANY_AXIS,
    AnyOf,
    Pose,
    Step,
    Target,
    direction,
    orientation,
    pointing_direction,
    position,
)

SPARE = 1e-6
"""Goals are this much within a tolerance, m and rad, so that none is beyond it by what is left of an error."""


def tasks_of(robot: Robot, step: Step) -> tuple[Task, ...]:
    """Return the tasks of a step of a scene that was checked: the points of all hands, joints, how hands are turned.

    The orientation of a hand is where its points are: one behind its own gives the direction it points in, and two on
    different axes give its orientation. So what moves points also turns hands, and all errors are in m.

    Raises:
        InvalidInput: If a hand has several targets of which one is to be taken.
    """
    for name, target in step.items():
        if isinstance(target, AnyOf):
            raise InvalidInput(f"targets.{name}", target, "one target: several, of which one is taken, are for plan")
    points: list[Task] = [
        _within(PointTask(name, position(target)), target)
        for name in robot.hand_names
        if (target := step.get(name)) is not None
    ]
    poses = [(hand, pose) for hand in robot.hands if isinstance(pose := step.get(hand.name), Pose)]
    turned = [task for hand, pose in poses for task in _turned(robot, hand, pose)]
    at = joint_targets(robot, step)
    joints = [ConfigurationTask(tuple(at), tuple(at.values()))] if at else []
    return (*points, *joints, *turned)


def _within(task: PointTask, target: Target) -> Task:
    """Return a task of a point with the tolerance of its target, if that has one."""
    if not isinstance(target, Pose) or target.tolerance is None:
        return task
    given = np.broadcast_to(np.array(target.tolerance, float), 3)
    return WithinTask(task, triple(np.maximum(given - SPARE, given / 2)), target.axes or BASE)


def _turned(robot: Robot, hand: Hand, pose: Pose) -> Iterator[Task]:
    """Yield the tasks that turn a hand.

    Raises:
        InvalidInput: If the hand has to point somewhere and has nothing that points.
    """
    if hand.pointing is None and pointing_direction(pose) is not None:
        valid = "no direction to point in: the robot's file names none that this hand points in (hands.*.pointing)"
        raise InvalidInput(f"targets.{hand.name}.approach", pose.approach, valid)
    lever, turned = orientation_lever(robot, hand.name), orientation(pose)
    if pose.angle_tolerance is None:
        for offset, at in _further_points(hand, pose, lever):
            yield PointTask(hand.name, at, offset)
        return
    half = max(pose.angle_tolerance - SPARE, pose.angle_tolerance / 2) / 2.0
    if turned is not None:
        first, second, third = (triple(row) for row in turned)
        yield WithinTask(OrientationTask(hand.name, (first, second, third)), 2.0 * lever * math.sin(half))
    elif (towards := direction(pose, hand.pointing)) is not None:
        assert hand.pointing is not None
        yield WithinTask(AxisTask(hand.name, hand.pointing, triple(towards)), 2.0 * lever * math.tan(half))


def _further_points(
    hand: Hand, pose: Pose, lever: float
) -> Iterator[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Yield offsets in a hand's frame and where the points there have to be, m."""
    place, along = np.array(pose.position), hand.pointing or ANY_AXIS
    pointing, towards = np.array(along) / np.linalg.norm(along), direction(pose, along)
    if towards is not None:
        yield triple(-lever * pointing), triple(place - lever * towards)
    if (turned := orientation(pose)) is not None:
        across = np.cross(pointing, np.eye(3)[abs(pointing).argmin()])
        across /= np.linalg.norm(across)
        yield triple(-lever * across), triple(place - lever * turned @ across)
