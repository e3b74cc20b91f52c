"""A task that is done within a tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from humanoid_rail._arrays import Array, checked_array, triple
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics.kept_tasks import AxisTask, OrientationTask
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import PointTask, Task

Row = tuple[float, float, float]
BASE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class WithinTask:
    """Another task of a hand that has to be done within a tolerance: 0 there, and beyond it what is too much.

    A point may be in a box along some axes: e = d - clamp(d, -tolerance, tolerance) with d = axes e_point. An axis or
    an orientation may be off by an angle: e = d max(0, 1 - tolerance / |d|) with its own error d.
    """

    task: PointTask | AxisTask | OrientationTask
    """The task, which is done exactly in the middle."""
    tolerance: float | Row
    """How far along each axis a point may be off, m; by what norm of its error another task may be, in its unit."""
    axes: tuple[Row, Row, Row] = BASE
    """The axes of a point's tolerance in the base frame, of length 1 and at right angles."""

    def __post_init__(self) -> None:
        if type(self.task) not in (PointTask, AxisTask, OrientationTask):
            raise InvalidInput("task", self.task, "a PointTask, an AxisTask or an OrientationTask")
        if isinstance(self.task, PointTask):
            given = np.array(checked_array("tolerance", self.tolerance, (3,), "three numbers, 0 or more, m"))
            if (given < 0.0).any():
                raise InvalidInput("tolerance", self.tolerance, "three numbers, 0 or more, m")
            object.__setattr__(self, "tolerance", tuple(given.tolist()))
        else:
            object.__setattr__(self, "tolerance", checked_number("tolerance", self.tolerance, least=0.0))
        axes = checked_array("axes", self.axes, (3, 3), "three unit vectors at right angles")
        if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9):
            raise InvalidInput("axes", self.axes, "three unit vectors at right angles")
        object.__setattr__(self, "axes", tuple(tuple(row) for row in axes.tolist()))

    @property
    def hand(self) -> str:
        """Name of the hand."""
        return self.task.hand

    @property
    def rows(self) -> int:
        """As many as those of the task."""
        return self.task.rows

    def error(self, state: State) -> Array:
        """Return e (m,)."""
        d = self.task.error(state)
        if isinstance(self.tolerance, tuple):
            d, most = np.array(self.axes) @ d, np.array(self.tolerance)
            box: Array = d - np.clip(d, -most, most)
            return box
        norm = float(np.linalg.norm(d))
        ball: Array = d * (1.0 - self.tolerance / norm if norm > self.tolerance else 0.0)
        return ball

    def jacobian(self, state: State) -> Array:
        """Return de/dq (m, n)."""
        return self._slope(self.task.error(state)) @ self.task.jacobian(state)

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (m,)."""
        d = self.task.error(state)
        drift: Array = self._slope(d) @ self.task.drift(state, velocity)
        norm = float(np.linalg.norm(d))
        if not isinstance(self.tolerance, tuple) and norm > self.tolerance:
            # The slope F = (1 - s / r) + s d d^T / r^3 of r = |d| turns with d.
            s, r, speed = self.tolerance, norm, self.task.jacobian(state) @ velocity
            rate = float(d @ speed) / r
            turn = s * rate / r**2 * np.eye(d.size) + s * (np.outer(speed, d) + np.outer(d, speed)) / r**3
            drift = drift + (turn - 3.0 * s * rate / r**4 * np.outer(d, d)) @ speed
        return drift

    def _slope(self, d: Array) -> Array:
        """Return de/dd (m, m) where the task has the error d (m,)."""
        if isinstance(self.tolerance, tuple):
            axes = np.array(self.axes)
            slope: Array = axes * (abs(axes @ d) >= self.tolerance)[:, None]
            return slope
        norm = float(np.linalg.norm(d))
        if norm <= self.tolerance:
            return np.zeros((d.size, d.size))
        unit = d / norm
        return (1.0 - self.tolerance / norm) * np.eye(d.size) + self.tolerance / norm * np.outer(unit, unit)


def nominal(tasks: Sequence[Task]) -> tuple[Task, ...]:
    """Return tasks without their tolerances."""
    return tuple(task.task if isinstance(task, WithinTask) else task for task in tasks)


def pinned(tasks: Sequence[Task], state: State) -> tuple[Task, ...]:
    """Return tasks with a hand kept where it is in a state, within their tolerances, instead of anywhere within."""
    return tuple(_pinned(task.task, state) if isinstance(task, WithinTask) else task for task in tasks)


def _pinned(task: PointTask | AxisTask | OrientationTask, state: State) -> Task:
    turned = state.rotations[state.robot.hand(task.hand)]
    match task:
        case PointTask():
            return replace(task, target=triple(np.array(task.target) + task.error(state)))
        case AxisTask():
            return replace(task, direction=triple(turned @ np.array(task.axis)))
        case OrientationTask():
            first, second, third = (triple(row) for row in turned)
            return replace(task, rotation=(first, second, third))
