"""Tasks: what is to be reached, as errors that are to become 0.

A task has an error e(q) and its Jacobian de/dq, as in Pink. Errors are what is there minus what is wanted, so that eq.
4.6 with the stacked rows of all tasks makes them decay. Anything with `rows`, `error`, `jacobian` and `drift` is a
task; those of this module also exist in the native engine, and others are called back from there.

Shapes: m rows, n actuated joints. The targets of a scene become tasks in :mod:`humanoid_rail.planning.target_tasks`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import SHORTEST, Array, checked_array
from humanoid_rail.errors import MISSING, InvalidInput, checked_number
from humanoid_rail.kinematics.hand_motion import hand_drift, keep_vectors, rows_of, unit
from humanoid_rail.kinematics.state import State
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.scale import PAPER_REACH

LEVER = 0.3
"""The points that give a hand of the paper's robot its orientation are this far from its own point, m: where errors are
below 1e-7 m, an orientation is right to 3e-7 rad. For other robots it is the same share of what the hand's arm
reaches."""


def orientation_lever(robot: Robot, hand: str) -> float:
    """Return how far from a hand's own point those are that give its orientation, m."""
    return LEVER * (robot.arm_reaches[robot.hand(hand)] / PAPER_REACH)


@runtime_checkable
class Task(Protocol):
    """Something to be reached: the error of a state, which is to become 0."""

    @property
    def rows(self) -> int:
        """The number m of rows."""
        ...

    def error(self, state: State) -> Array:
        """Return e (m,)."""
        ...

    def jacobian(self, state: State) -> Array:
        """Return de/dq (m, n)."""
        ...

    def drift(self, state: State, velocity: Array) -> Array:
        """Return what e'' has beside the Jacobian times q'' (m,): J_dot q_dot for a velocity (n,)."""
        ...


@dataclass(frozen=True)
class PointTask:
    """A point of a hand that has to be at a place: e = p + R offset - target, in m."""

    hand: str
    """Name of the hand."""
    target: tuple[float, float, float]
    """Where the point has to be, in the base frame, m."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the point is in the hand's frame, m; by default the hand's own point."""

    def __post_init__(self) -> None:
        keep_vectors(self, "target", "offset")

    @property
    def rows(self) -> int:
        """3."""
        return 3

    def error(self, state: State) -> Array:
        """Return e (3,), m."""
        h = state.robot.hand(self.hand)
        error: Array = state.hands[h] + state.rotations[h] @ np.array(self.offset) - np.array(self.target)
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (3, n): J_v - [R offset]x J_w."""
        rows = rows_of(state.robot.hand(self.hand))
        arm = state.rotations[rows.start // 3] @ np.array(self.offset)
        J: Array = state.jacobian[rows] - pin.skew(arm) @ state.angular_jacobian[rows]
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (3,), m/s^2: the acceleration of the point while q_dot is constant."""
        h = state.robot.hand(self.hand)
        acceleration, angular, spin = hand_drift(state, self.hand, velocity)
        arm = state.rotations[h] @ np.array(self.offset)
        drift: Array = acceleration + np.cross(angular, arm) + np.cross(spin, np.cross(spin, arm))
        return drift


@dataclass(frozen=True)
class DirectionTask:
    """A hand that has to point in a direction, and may turn about it: e = lever (R pointing - direction), in m.

    Two of its three rows are independent.
    """

    hand: str
    """Name of the hand."""
    direction: tuple[float, float, float]
    """Where to point, in the base frame; of any length but 0."""
    pointing: tuple[float, float, float] | None = None
    """What of the hand has to point there, in its frame; the robot's own if not given."""
    lever: float | None = None
    """What turns an angle into an error in m. If not given it is 0.3 m for the paper's robot, and for others the same
    share of what the hand's arm reaches."""

    def __post_init__(self) -> None:
        keep_vectors(self, "direction", *(["pointing"] if self.pointing is not None else []))
        for name in ("direction", "pointing"):
            if getattr(self, name) is not None and np.linalg.norm(getattr(self, name)) < SHORTEST:
                raise InvalidInput(name, getattr(self, name), f"a vector that is at least {SHORTEST:g} long")
        if self.lever is not None:
            object.__setattr__(self, "lever", checked_number("lever", self.lever, above=0.0))

    @property
    def rows(self) -> int:
        """3."""
        return 3

    def lever_of(self, robot: Robot) -> float:
        """Return what turns an angle into an error, m."""
        return orientation_lever(robot, self.hand) if self.lever is None else self.lever

    def axis(self, robot: Robot) -> Array:
        """Return the unit vector (3,) in the hand's frame that has to point in the direction.

        Raises:
            InvalidInput: If neither the task nor the robot names one.
        """
        pointing = robot.hands[robot.hand(self.hand)].pointing if self.pointing is None else self.pointing
        if pointing is None:
            raise InvalidInput("pointing", MISSING, f"a direction in the frame of the hand {self.hand}, which has none")
        return unit(pointing)

    def error(self, state: State) -> Array:
        """Return e (3,), m."""
        axis = state.rotations[state.robot.hand(self.hand)] @ self.axis(state.robot)
        error: Array = self.lever_of(state.robot) * (axis - unit(self.direction))
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (3, n): -lever [R pointing]x J_w."""
        rows = rows_of(state.robot.hand(self.hand))
        axis = state.rotations[rows.start // 3] @ self.axis(state.robot)
        J: Array = -self.lever_of(state.robot) * pin.skew(axis) @ state.angular_jacobian[rows]
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (3,), m/s^2."""
        _, angular, spin = hand_drift(state, self.hand, velocity)
        axis = state.rotations[state.robot.hand(self.hand)] @ self.axis(state.robot)
        drift: Array = self.lever_of(state.robot) * (np.cross(angular, axis) + np.cross(spin, np.cross(spin, axis)))
        return drift


@dataclass(frozen=True)
class RelativeTask:
    """Two hands that have to be in a relation: e = p_second - p_first - difference, in m.

    In the base frame, or in that of the first hand: e = R_first^T (p_second - p_first) - difference.
    """

    first: str
    """Name of the one hand."""
    second: str
    """Name of the other."""
    difference: tuple[float, float, float]
    """Where the second hand has to be from the first, m."""
    in_first: bool = False
    """Whether the difference is in the frame of the first hand; if not, in the base frame."""

    def __post_init__(self) -> None:
        keep_vectors(self, "difference")
        if not isinstance(self.in_first, bool):
            raise InvalidInput("in_first", self.in_first, "True or False")

    @property
    def rows(self) -> int:
        """3."""
        return 3

    def error(self, state: State) -> Array:
        """Return e (3,), m."""
        first, second = (state.robot.hand(name) for name in (self.first, self.second))
        error: Array = self._back(state) @ (state.hands[second] - state.hands[first]) - np.array(self.difference)
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (3, n): J_second - J_first, with R_first^T (... + [p_second - p_first]x J_w) in its frame."""
        first, second = (rows_of(state.robot.hand(name)) for name in (self.first, self.second))
        J: Array = state.jacobian[second] - state.jacobian[first]
        if self.in_first:
            apart = state.hands[second.start // 3] - state.hands[first.start // 3]
            J = self._back(state) @ (J + pin.skew(apart) @ state.angular_jacobian[first])
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (3,), m/s^2."""
        first, second = (state.robot.hand(name) for name in (self.first, self.second))
        (of_first, angular, spin), (of_second, _, _) = (
            hand_drift(state, name, velocity) for name in (self.first, self.second)
        )
        drift: Array = of_second - of_first
        if self.in_first:
            apart = state.hands[second] - state.hands[first]
            speed = (state.jacobian[rows_of(second)] - state.jacobian[rows_of(first)]) @ velocity
            turning = np.cross(angular, apart) + 2.0 * np.cross(spin, speed) - np.cross(spin, np.cross(spin, apart))
            drift = self._back(state) @ (drift - turning)
        return drift

    def _back(self, state: State) -> Array:
        """Return the rotation (3, 3) from the base frame to that of the difference."""
        back: Array = state.rotations[state.robot.hand(self.first)].T if self.in_first else np.eye(3)
        return back


@dataclass(frozen=True)
class ConfigurationTask:
    """Joints that have to be at positions: e = q_i - target_i, in m and rad."""

    joints: tuple[str, ...]
    """Names of the actuated joints."""
    target: tuple[float, ...]
    """Where each has to be, m or rad."""

    def __post_init__(self) -> None:
        names = self.joints
        if isinstance(names, str) or not isinstance(names, Sequence) or not names or not all(map(_is_name, names)):
            raise InvalidInput("joints", names, "a sequence of names of joints")
        target = checked_array("target", self.target, (len(names),), f"a number for each of {', '.join(names)}")
        object.__setattr__(self, "joints", tuple(names))
        object.__setattr__(self, "target", tuple(target.tolist()))

    @property
    def rows(self) -> int:
        """The number of joints."""
        return len(self.joints)

    def columns(self, robot: Robot) -> list[int]:
        """Return the indices of the joints in q.

        Raises:
            InvalidInput: If the robot has no such joint.
        """
        for name in self.joints:
            if name not in robot.joint_names:
                raise InvalidInput("joints", name, f"actuated joints: {', '.join(robot.joint_names)}")
        return [robot.joint_names.index(name) for name in self.joints]

    def error(self, state: State) -> Array:
        """Return e (m,), m and rad."""
        error: Array = state.q[self.columns(state.robot)] - np.array(self.target)
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (m, n): rows of the identity."""
        return np.eye(state.q.size)[self.columns(state.robot)]

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (m,), which is 0."""
        return np.zeros(self.rows)


def _is_name(value: object) -> bool:
    return isinstance(value, str)
