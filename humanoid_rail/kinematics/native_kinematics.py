"""A robot among obstacles in the native engine: the interface of `kinematics.py`, computed in C++."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, checked_array
from humanoid_rail._native import engine
from humanoid_rail.errors import checked_number
from humanoid_rail.kinematics.state import Clearances, Course, Measurement, State, checked_course
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle


class NativeKinematics:
    """A robot among obstacles; see :class:`humanoid_rail.Kinematics`. Threads may share it: calls wait for one another.

    Raises:
        EngineMissing: If there is no native engine.
    """

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...] = ()) -> None:
        self.robot = robot
        self.obstacles = obstacles
        self.native = engine().SafeVelocity(native_robot(robot), native_obstacles(obstacles))

    @cached_property
    def _for_callbacks(self) -> NativeKinematics:
        return NativeKinematics(self.robot, self.obstacles)

    def state_for_callback(self, q: Array, t: float) -> State:
        """Return the state for a function that the engine calls back, while it is at work itself."""
        return self._for_callbacks.state(q, t)

    def state(self, q: ArrayLike, t: float = 0.0) -> State:
        """Return everything that eq. 4.9 and its constraints need to know at a configuration (n,) and a time in s."""
        q, t = checked_array("q", q, (self.robot.n,)), checked_number("t", t)
        found = self.native.state(q, t)
        n, h = self.robot.n, len(self.robot.hands)
        return State(
            q=q,
            t=t,
            robot=self.robot,
            hands=found.hands.reshape(h, 3),
            rotations=found.rotations.reshape(h, 3, 3),
            jacobian=found.jacobian,
            angular_jacobian=found.angular_jacobian,
            manipulability=found.manipulability,
            manipulability_gradient=found.manipulability_gradient,
            clearance=found.clearance,
            clearance_gradient=found.clearance_gradient.reshape(*found.clearance.shape, n),
            pieces=Clearances(
                found.piece_distance,
                found.piece_gradient.reshape(*found.piece_distance.shape, n),
                found.piece_rate,
            ),
            links=Clearances(found.link_distance, found.link_gradient, np.zeros(len(found.link_distance))),
        )

    def measure(self, q: ArrayLike, horizon: float = np.inf, t: float = 0.0) -> Measurement:
        """Return hands, manipulability and clearances at a configuration (n,), without derivatives.

        Args:
            q: Configuration (n,), m and rad.
            horizon: Clearances beyond it are infinite, except for the smallest of all, m. Those of pairs of links are
                given in any case.
            t: Time, which matters where obstacles move, s.
        """
        q, t = checked_array("q", q, (self.robot.n,)), checked_number("t", t)
        found = self.native.measure(q, t, horizon)
        return Measurement(found.hands.reshape(-1, 3), found.manipulability, found.clearance, found.link_distance)

    def along(self, q: ArrayLike, horizon: float = np.inf, t: ArrayLike | None = None) -> Course:
        """Return the same for each configuration of a motion (N, n), with the clearances of the nearest link.

        Args:
            q: Configurations (N, n), m and rad.
            horizon: As for :meth:`measure`.
            t: Times (N,), which matter where obstacles move, s; 0 if not given.
        """
        q, times = checked_course(self.robot, q, t)
        found = self.native.along(times, q, horizon)
        return Course(found.hands.reshape(len(q), -1, 3), found.manipulability, found.clearance)
