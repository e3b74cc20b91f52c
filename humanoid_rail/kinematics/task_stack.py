"""Tasks one after the other: checks of them, and their errors and Jacobians as one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import Array, checked_array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import ConfigurationTask, DirectionTask, PointTask, RelativeTask, Task
from humanoid_rail.kinematics.within_task import WithinTask
from humanoid_rail.model.robot import Robot

MOST_ROWS = 1000
"""A task has at most this many rows."""


def check_tasks(tasks: Sequence[Task], robot: Robot, field: str = "tasks", least: int = 1) -> None:
    """Check that there are tasks, and that the robot has the hands and joints that they name.

    Args:
        tasks: The tasks.
        robot: The robot.
        field: What errors call them.
        least: There have to be so many, 1 or 0.

    Raises:
        InvalidInput: If there is none, one of them is no task, or one names what the robot does not have.
    """
    if isinstance(tasks, str) or not isinstance(tasks, Sequence) or len(tasks) < least:
        raise InvalidInput(field, tasks, f"a sequence of {'one task or more' if least else 'tasks'}")
    for i, task in enumerate(tasks):
        if isinstance(task, type) or not isinstance(task, Task):
            raise InvalidInput(f"{field}[{i}]", task, "a task, with rows, error, jacobian, drift")
        rows: object = task.rows
        if isinstance(rows, bool) or not isinstance(rows, int | np.integer) or not 1 <= rows <= MOST_ROWS:
            raise InvalidInput(f"{field}[{i}].rows", rows, f"a whole number from 1 to {MOST_ROWS}")
        try:
            _check_names(task, robot)
        except InvalidInput as error:
            raise InvalidInput(f"{field}[{i}].{error.field}", error.value, error.valid) from None


def _check_names(task: Task, robot: Robot) -> None:
    match task:
        case PointTask() | DirectionTask() | LineTask() | AxisTask() | OrientationTask():
            robot.hand(task.hand)
            if isinstance(task, OrientationTask) and task.reference is not None:
                robot.hand(task.reference)
        case RelativeTask() | DistanceTask():
            robot.hand(task.first)
            robot.hand(task.second)
        case ConfigurationTask():
            task.columns(robot)
        case WithinTask():
            _check_names(task.task, robot)
        case _:
            pass  # one of the user's own


def task_error(task: Task, state: State, rows: int, number: int) -> Array:
    """Return the error (rows,) of a task, the one of a number among others.

    Raises:
        InvalidInput: If the task returns anything else.
    """
    return checked_array(f"tasks[{number}].error(state)", task.error(state), (rows,))


def task_jacobian(task: Task, state: State, rows: int, number: int) -> Array:
    """Return the Jacobian (rows, n) of a task, the one of a number among others.

    Raises:
        InvalidInput: If the task returns anything else.
    """
    return checked_array(f"tasks[{number}].jacobian(state)", task.jacobian(state), (rows, state.q.size))


def stack_error(state: State, tasks: Sequence[Task]) -> Array:
    """Return the errors of tasks one after the other: e (m,) of eq. 4.1 for points, m.

    Raises:
        InvalidInput: If a task does not return a finite number for each of its rows.
    """
    return np.concatenate([task_error(task, state, task.rows, i) for i, task in enumerate(tasks)])


def stack_jacobian(state: State, tasks: Sequence[Task]) -> Array:
    """Return the Jacobians of tasks one below the other (m, n).

    Raises:
        InvalidInput: If a task does not return finite numbers, a row for each of its rows.
    """
    return np.vstack([task_jacobian(task, state, task.rows, i) for i, task in enumerate(tasks)])


def count_rows(tasks: Sequence[Task]) -> int:
    """Return the number of rows of tasks."""
    return sum(task.rows for task in tasks)
