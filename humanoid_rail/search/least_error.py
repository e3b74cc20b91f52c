"""The configuration within the joint limits at which tasks have the smallest error, obstacles and links left alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import stack_error, stack_jacobian

MAX_STEPS = 100
"""The search for the smallest error takes at most this many steps."""


class LeastError(NamedTuple):
    """Where the weighted errors of tasks are smallest."""

    q: Array
    """Configuration (n,), m and rad."""
    error: float
    """The norm of the weighted errors, m."""
    slope: Array
    """The derivative (n,) of half its square by the joints: at a limit it points to where it would fall further."""


def least_error(
    kinematics: NativeKinematics, tasks: Sequence[Task], q: Array, weight: Array | float = 1.0
) -> LeastError:
    """Return a local minimum. Inverse kinematics is made for errors that vanish; this is for those that do not.

    Args:
        kinematics: The robot, whose joint limits count.
        tasks: What is to be reached.
        q: Where to begin (n,), m and rad. Joints that cannot move stay there.
        weight: What the errors are multiplied by, one number or one for each row of the tasks.
    """
    # Imported here: it is needed only where targets are out of reach.
    from scipy.optimize import least_squares

    robot = kinematics.robot
    free = np.flatnonzero((robot.velocity_limit > 0) & (robot.lower < robot.upper))
    weight = np.broadcast_to(weight, sum(task.rows for task in tasks))

    def state(x: Array) -> State:
        there = q.copy()
        there[free] = x
        return kinematics.state(there)

    def error(x: Array) -> Array:
        return weight * stack_error(state(x), tasks)

    def slope(x: Array) -> Array:
        return weight[:, None] * stack_jacobian(state(x), tasks)[:, free]

    bounds = robot.lower[free], robot.upper[free]
    closest = least_squares(error, q[free], slope, bounds=bounds, max_nfev=MAX_STEPS)
    there, gradient = q.copy(), np.zeros(robot.n)
    there[free], gradient[free] = np.clip(closest.x, *bounds), closest.grad
    return LeastError(there, float(np.sqrt(2.0 * closest.cost)), gradient)
