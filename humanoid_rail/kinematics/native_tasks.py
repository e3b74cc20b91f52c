"""Tasks as the native engine has them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.kinematics.hand_motion import unit
from humanoid_rail.kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import ConfigurationTask, DirectionTask, PointTask, RelativeTask, Task
from humanoid_rail.kinematics.task_stack import check_tasks, task_error, task_jacobian
from humanoid_rail.kinematics.within_task import WithinTask
from humanoid_rail.model.robot import Robot

if TYPE_CHECKING:
    from humanoid_rail import _engine

NATIVE_TASKS = (
    PointTask,
    DirectionTask,
    RelativeTask,
    ConfigurationTask,
    LineTask,
    DistanceTask,
    AxisTask,
    OrientationTask,
    WithinTask,
)
"""The native engine has these tasks itself; a class derived from one is the user's own."""
StateAt = Callable[[Array, float], State]
"""Returns the state at a configuration (n,) and a time in s, for tasks and objectives that are written in Python."""


def native_tasks(robot: Robot, tasks: Sequence[Task], state_at: StateAt) -> _engine.TaskStack:
    """Return tasks as the native engine has them; those it does not know are called back.

    Args:
        robot: The robot whose hands the tasks name.
        tasks: The tasks, one or more.
        state_at: What a task that is called back is given.

    Raises:
        InvalidInput: If there is no task, or one names a hand or joint that the robot does not have.
    """
    check_tasks(tasks, robot)
    stack: _engine.TaskStack = engine().TaskStack([_native(robot, task, i, state_at) for i, task in enumerate(tasks)])
    return stack


def _native(robot: Robot, task: Task, number: int, state_at: StateAt) -> _engine.Task:
    native = engine()
    made: _engine.Task
    is_native = type(task) in NATIVE_TASKS
    match task:
        case PointTask() if is_native:
            made = native.PointTask(robot.hand(task.hand), np.array(task.offset, float), np.array(task.target, float))
        case DirectionTask() if is_native:
            towards = unit(task.direction)
            made = native.DirectionTask(robot.hand(task.hand), task.axis(robot), towards, task.lever_of(robot))
        case RelativeTask() if is_native:
            first, second = robot.hand(task.first), robot.hand(task.second)
            made = native.RelativeTask(first, second, np.array(task.difference, float), task.in_first)
        case DistanceTask() if is_native:
            made = native.DistanceTask(robot.hand(task.first), robot.hand(task.second), task.distance)
        case LineTask() if is_native:
            offset, point = np.array(task.offset, float), np.array(task.point, float)
            made = native.LineTask(robot.hand(task.hand), offset, point, task.across)
        case AxisTask() if is_native:
            axis, direction = unit(task.axis), unit(task.direction)
            made = native.AxisTask(robot.hand(task.hand), axis, direction, task.across, task.lever_of(robot))
        case OrientationTask() if is_native:
            reference = -1 if task.reference is None else robot.hand(task.reference)
            turned = np.array(task.rotation, float)
            made = native.OrientationTask(robot.hand(task.hand), turned, reference, task.lever_of(robot))
        case ConfigurationTask() if is_native:
            made = native.ConfigurationTask(task.columns(robot), np.array(task.target, float))
        case WithinTask() if is_native:
            inner = _native(robot, task.task, number, state_at)
            if isinstance(task.tolerance, tuple):
                made = native.WithinBoxTask(inner, np.array(task.axes).T, np.array(task.tolerance))
            else:
                made = native.WithinBallTask(inner, task.tolerance)
        case _:
            rows = task.rows

            def called_back(q: Array, t: float) -> tuple[Array, Array]:
                state = state_at(q, t)
                return task_error(task, state, rows, number), task_jacobian(task, state, rows, number)

            made = native.FunctionTask(rows, called_back)
    return made
