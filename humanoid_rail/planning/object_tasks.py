"""Turns the targets of held objects into tasks of the hands that hold them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from humanoid_rail._arrays import triple
from humanoid_rail.holding.holding import Holding
from humanoid_rail.kinematics.task import PointTask, Task, orientation_lever
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.targets import Pose, Step, orientation, position


def object_tasks(robot: Robot, step: Step, holding: Holding) -> tuple[Task, ...]:
    """Return the tasks that bring held objects to the targets that a step has for them.

    The origin of an object's frame has to be at the target; if this has an orientation, two points on the axes of the
    frame too, so that all errors are in m. The points are those of the first hand that holds it.

    Args:
        robot: The robot with the hands that hold objects.
        step: Targets, by the names of hands and of held objects.
        holding: What is held.
    """
    return tuple(
        task for name in holding.held if step.get(name) is not None for task in _tasks(robot, step, holding, name)
    )


def _tasks(robot: Robot, step: Step, holding: Holding, name: str) -> Iterator[PointTask]:
    held, target = holding.held[name], step[name]
    assert target is not None
    hand, place = held.hands[0], np.array(position(target))
    yield PointTask(hand, triple(place), triple(held.placement.translation))
    if isinstance(target, Pose) and (rotation := orientation(target)) is not None:
        for axis in np.eye(3)[:2] * orientation_lever(robot, hand):
            yield PointTask(hand, triple(place + rotation @ axis), triple(held.placement.act(axis)))


def hands_in(task: Task) -> tuple[str, ...]:
    """Return the hands that a task is about, as far as it says so."""
    named = (getattr(task, name, None) for name in ("hand", "first", "second", "reference"))
    return tuple(name for name in named if isinstance(name, str))
