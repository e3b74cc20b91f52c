"""Tasks that are mostly kept along a motion, each with as many rows as freedoms it takes away.

Those that turn hands have no second solution: their errors are 0 in one orientation only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import FARTHEST, SHORTEST, Array, checked_array
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics.hand_motion import hand_drift, keep_vectors, rows_of, unit
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import PointTask, orientation_lever
from humanoid_rail.model.robot import Robot

OPPOSITE = 1e-12
"""An axis is opposite to its direction if the cosine of their angle is less than this above -1."""
ROTATION = 1e-6
"""A rotation matrix is one to this."""

Vector3 = tuple[float, float, float]


@dataclass(frozen=True)
class LineTask:
    """A point of a hand that has to be on a line: e = B^T (p + R offset - point), in m.

    B (3, 2) is a basis of what is across the line, so the norm of e is the distance from it.
    """

    hand: str
    """Name of the hand."""
    point: Vector3
    """A point of the line, in the base frame, m."""
    direction: Vector3
    """Where the line runs, in the base frame; of any length but 0."""
    offset: Vector3 = (0.0, 0.0, 0.0)
    """Where the point is in the hand's frame, m; by default the hand's own point."""

    def __post_init__(self) -> None:
        keep_vectors(self, "point", "direction", "offset")
        _check_length("direction", self.direction)

    @property
    def rows(self) -> int:
        """2."""
        return 2

    @property
    def across(self) -> Array:
        """B (3, 2)."""
        return across(self.direction)

    @property
    def _point(self) -> PointTask:
        return PointTask(self.hand, self.point, self.offset)

    def error(self, state: State) -> Array:
        """Return e (2,), m."""
        error: Array = self.across.T @ self._point.error(state)
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (2, n): B^T of that of the point."""
        J: Array = self.across.T @ self._point.jacobian(state)
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (2,), m/s^2."""
        drift: Array = self.across.T @ self._point.drift(state, velocity)
        return drift


@dataclass(frozen=True)
class DistanceTask:
    """Two hands that have to be at a distance: e = |p_second - p_first| - distance, in m."""

    first: str
    """Name of the one hand."""
    second: str
    """Name of the other."""
    distance: float
    """How far apart their points have to be, m; more than 0."""

    def __post_init__(self) -> None:
        distance = checked_number("distance", self.distance, least=SHORTEST, most=FARTHEST)
        object.__setattr__(self, "distance", distance)

    @property
    def rows(self) -> int:
        """1."""
        return 1

    def error(self, state: State) -> Array:
        """Return e (1,), m."""
        return np.array([float(np.linalg.norm(self._apart(state))) - self.distance])

    def jacobian(self, state: State) -> Array:
        """Return de/dq (1, n): u^T (J_second - J_first), with u from the first hand to the second."""
        J: Array = self._along(state)[None, :] @ self._relative(state)
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (1,), m/s^2."""
        first, second = (hand_drift(state, name, velocity)[0] for name in (self.first, self.second))
        speed, u, apart = self._relative(state) @ velocity, self._along(state), np.linalg.norm(self._apart(state))
        return np.array([u @ (second - first) + (speed @ speed - (u @ speed) ** 2) / max(float(apart), SHORTEST)])

    def _apart(self, state: State) -> Array:
        apart: Array = state.hands[state.robot.hand(self.second)] - state.hands[state.robot.hand(self.first)]
        return apart

    def _along(self, state: State) -> Array:
        apart = self._apart(state)
        length = float(np.linalg.norm(apart))
        return apart / length if length else apart

    def _relative(self, state: State) -> Array:
        first, second = (rows_of(state.robot.hand(name)) for name in (self.first, self.second))
        J: Array = state.jacobian[second] - state.jacobian[first]
        return J


@dataclass(frozen=True)
class AxisTask:
    """An axis of a hand that has to lie along a direction d: e = 2 lever B^T a / (1 + d . a), in m.

    a is the axis in the base frame, B (3, 2) a basis of what is across d. The norm of e is 2 lever tan(angle / 2).
    """

    hand: str
    """Name of the hand."""
    axis: Vector3
    """The axis in the hand's frame; of any length but 0."""
    direction: Vector3 = (0.0, 0.0, 1.0)
    """Where it has to point, in the base frame; up if not given."""
    lever: float | None = None
    """What turns an angle into an error in m; see :class:`DirectionTask`."""

    def __post_init__(self) -> None:
        keep_vectors(self, "axis", "direction")
        _check_length("axis", self.axis)
        _check_length("direction", self.direction)
        _keep_lever(self)

    @property
    def rows(self) -> int:
        """2."""
        return 2

    @property
    def across(self) -> Array:
        """B (3, 2)."""
        return across(self.direction)

    def lever_of(self, robot: Robot) -> float:
        """Return what turns an angle into an error, m."""
        return orientation_lever(robot, self.hand) if self.lever is None else self.lever

    def error(self, state: State) -> Array:
        """Return e (2,), m."""
        a, total = self._axis(state)
        error: Array = 2.0 * self.lever_of(state.robot) / total * (self.across.T @ a)
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (2, n)."""
        a, total = self._axis(state)
        turned = -pin.skew(a) @ state.angular_jacobian[rows_of(state.robot.hand(self.hand))]
        rows = (self.across.T - np.outer(self.across.T @ a, unit(self.direction)) / total) / total
        J: Array = 2.0 * self.lever_of(state.robot) * rows @ turned
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (2,), m/s^2."""
        _, angular, spin = hand_drift(state, self.hand, velocity)
        a, total = self._axis(state)
        first = np.cross(spin, a)
        second = np.cross(angular, a) + np.cross(spin, first)
        d, B = unit(self.direction), self.across.T
        speed = d @ first
        drift: Array = (B @ second - (2.0 * speed * (B @ first) + d @ second * (B @ a)) / total) / total
        return 2.0 * self.lever_of(state.robot) * (drift + 2.0 * speed**2 * (B @ a) / total**3)

    def _axis(self, state: State) -> tuple[Array, float]:
        """Return a (3,) and 1 + d . a."""
        a: Array = state.rotations[state.robot.hand(self.hand)] @ unit(self.axis)
        return a, max(1.0 + float(unit(self.direction) @ a), OPPOSITE)


@dataclass(frozen=True)
class OrientationTask:
    """A hand that has to be turned in one way: e = 2 lever v, in m.

    (w, v) with w >= 0 is the quaternion of what is left of the turn, in the frame that the rotation is in. The norm of
    e is 2 lever sin(angle / 2).
    """

    hand: str
    """Name of the hand."""
    rotation: tuple[Vector3, Vector3, Vector3]
    """The rotation (3, 3) from the hand's frame to the base frame, or to that of the reference. Kept as a tuple."""
    reference: str | None = None
    """Name of the hand in whose frame the rotation is; in the base frame if not given."""
    lever: float | None = None
    """What turns an angle into an error in m; see :class:`DirectionTask`."""

    def __post_init__(self) -> None:
        R = checked_array("rotation", self.rotation, (3, 3))
        if not np.allclose(R @ R.T, np.eye(3), rtol=0.0, atol=ROTATION) or np.linalg.det(R) < 0.0:
            raise InvalidInput("rotation", self.rotation, "a rotation matrix")
        object.__setattr__(self, "rotation", tuple(map(tuple, R.tolist())))
        _keep_lever(self)

    @property
    def rows(self) -> int:
        """3."""
        return 3

    def lever_of(self, robot: Robot) -> float:
        """Return what turns an angle into an error, m."""
        return orientation_lever(robot, self.hand) if self.lever is None else self.lever

    def error(self, state: State) -> Array:
        """Return e (3,), m."""
        error: Array = 2.0 * self.lever_of(state.robot) * self._left(state)[1]
        return error

    def jacobian(self, state: State) -> Array:
        """Return de/dq (3, n): lever (w - [v]x) J_w, as 2 v_dot = w omega - v x omega."""
        w, v = self._left(state)
        J: Array = self.lever_of(state.robot) * (w * np.eye(3) - pin.skew(v)) @ self._angular(state)
        return J

    def drift(self, state: State, velocity: Array) -> Array:
        """Return J_dot q_dot (3,), m/s^2: lever (w omega_dot - v x omega_dot - |omega|^2 v / 2)."""
        w, v = self._left(state)
        _, angular, spin = hand_drift(state, self.hand, velocity)
        if self.reference is not None:
            _, of_reference, before = hand_drift(state, self.reference, velocity)
            back = self._back(state)
            angular = back @ (angular - of_reference - np.cross(before, spin - before))
            spin = back @ (spin - before)
        drift: Array = self.lever_of(state.robot) * (w * angular - np.cross(v, angular) - spin @ spin * v / 2.0)
        return drift

    def _back(self, state: State) -> Array:
        back: Array = np.eye(3) if self.reference is None else state.rotations[state.robot.hand(self.reference)].T
        return back

    def _left(self, state: State) -> tuple[float, Array]:
        """Return w and v (3,)."""
        turned = self._back(state) @ state.rotations[state.robot.hand(self.hand)]
        left = pin.Quaternion(turned @ np.array(self.rotation).T)
        sign = -1.0 if left.w < 0.0 else 1.0
        return sign * float(left.w), sign * left.vec()

    def _angular(self, state: State) -> Array:
        """Return the Jacobian (3, n) of the angular velocity."""
        J: Array = state.angular_jacobian[rows_of(state.robot.hand(self.hand))]
        if self.reference is None:
            return J
        relative: Array = self._back(state) @ (J - state.angular_jacobian[rows_of(state.robot.hand(self.reference))])
        return relative


def across(direction: Vector3) -> Array:
    """Return an orthonormal basis (3, 2) of what is across a direction."""
    d = unit(direction)
    first = np.cross(d, np.eye(3)[abs(d).argmin()])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(d, first)])


def _check_length(name: str, vector: Vector3) -> None:
    if np.linalg.norm(vector) < SHORTEST:
        raise InvalidInput(name, vector, f"a vector that is at least {SHORTEST:g} long")


def _keep_lever(task: AxisTask | OrientationTask) -> None:
    if task.lever is not None:
        object.__setattr__(task, "lever", checked_number("lever", task.lever, above=0.0))
