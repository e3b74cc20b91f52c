"""Configurations in which tasks are done, clear of everything and within the joint limits.

The native engine (`engine/kinematics/inverse_kinematics.cpp`) brings the sum of the squared errors to 0 by the method
of Levenberg and Marquardt, with a damping that shrinks with what is left of it (Sugihara 2011).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.native_tasks import StateAt, native_tasks
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle


class Posture(NamedTuple):
    """A configuration that was found, and how good it is."""

    q: Array
    """Configuration (n,) within the limits, m and rad."""
    error: float
    """Norm of the tasks' errors, m."""
    clearance: float
    """The smallest clearance of all pairs nearer than asked for, m; infinite where there are none."""
    reached: bool
    """Whether the tasks are done to 1e-7 m and every pair keeps the distance that was asked for."""


class InverseKinematics:
    """A robot among obstacles where they are at t = 0. Threads may share it: calls wait for one another.

    Raises:
        EngineMissing: If there is no native engine.
    """

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...]) -> None:
        self.robot = robot
        self._native = engine().InverseKinematics(native_robot(robot), native_obstacles(obstacles))
        self._stack: tuple[Sequence[Task], object] | None = None
        # It does not know `self`: the stack of tasks that calls it back is kept here, and no collector sees through it.
        kinematics = cache(lambda: NativeKinematics(robot, obstacles))
        self._state_at: StateAt = lambda q, t: kinematics().state(q, t)

    def solve(self, start: Array, tasks: Sequence[Task], distance: float) -> Posture:
        """Look from a configuration for one near it in which tasks are done.

        Args:
            start: Configuration (n,), m and rad.
            tasks: What is to be reached.
            distance: The distance that all pairs keep, m; minus infinity to leave clearances alone.
        """
        found = self._native.solve(start, self._stack_of(tasks), distance)
        return Posture(found.q, found.error, found.clearance, found.reached)

    def reached(self, starts: Sequence[Array], tasks: Sequence[Task], distance: float) -> list[Array]:
        """Return the configurations (n,) in which tasks are done that are found from several others.

        Args:
            starts: Configurations (n,), m and rad.
            tasks: As for :meth:`solve`.
            distance: As for :meth:`solve`.
        """
        found: list[Array] = self._native.reached(np.array(starts), self._stack_of(tasks), distance)
        return found

    def pulled(self, goal: Array, start: Array, tasks: Sequence[Task], distance: float) -> Array:
        """Return a configuration (n,) in which tasks are done nearer to a start, by looking from between the two.

        Args:
            goal: Configuration (n,) in which the tasks are done, m and rad; returned if none nearer is found.
            start: Configuration (n,); nearness is measured in joint coordinates in units of the speed limits.
            tasks: As for :meth:`solve`.
            distance: As for :meth:`solve`.
        """
        nearer: Array = self._native.pulled(goal, start, self._stack_of(tasks), distance)
        return nearer

    def evaluate(self, q: Array, tasks: Sequence[Task]) -> tuple[Array, Array]:
        """Return the errors (r,) of tasks at a configuration (n,), m and rad, and their Jacobian (r, n)."""
        error, jacobian = self._native.evaluate(q, self._stack_of(tasks))
        return error, jacobian

    def errors(self, q: Array, tasks: Sequence[Task]) -> Array:
        """Return the errors (N, r) of tasks at configurations (N, n), m and rad."""
        errors: Array = self._native.errors(q, self._stack_of(tasks))
        return errors

    def _stack_of(self, tasks: Sequence[Task]) -> object:
        # The same tasks are asked for again and again.
        stack = self._stack
        if stack is None or stack[0] is not tasks:
            stack = self._stack = tasks, native_tasks(self.robot, tasks, self._state_at)
        return stack[1]
