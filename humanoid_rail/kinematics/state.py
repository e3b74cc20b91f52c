"""What is true of a robot among obstacles, as frozen data, and what computes it.

Shapes: n actuated joints, h hands, L links (collision bodies), O obstacles, K convex pieces of all obstacles, P pairs
of links to check against each other. Metres and radians, in the base frame.
"""

from __future__ import annotations

from collections.abc import Sized
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, checked_array
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle


class Clearances(NamedTuple):
    """Signed distances of pairs of bodies, and how they change."""

    distance: Array
    """(...), m; negative in penetration."""
    gradient: Array
    """With respect to q (..., n)."""
    rate: Array
    """With respect to time, by the obstacles' own motion (...), m/s."""


@dataclass(frozen=True, eq=False)
class State:
    """Everything that eq. 4.9 and its constraints need to know at a configuration. Its arrays are read-only."""

    q: Array
    """Configuration (n,), m and rad."""
    t: float
    """Time, which matters where obstacles move, s."""
    robot: Robot
    """The robot; its hands are the h hands below."""
    hands: Array
    """f(q) of eq. 2.1: positions of the hands (h, 3), m."""
    rotations: Array
    """Rotations (h, 3, 3) from the hands' frames to the base frame."""
    jacobian: Array
    """J of eq. 2.2 (3h, n), the hands in order."""
    angular_jacobian: Array
    """The same for the hands' angular velocities in the base frame (3h, n)."""
    manipulability: float
    """mu of eq. 3.4."""
    manipulability_gradient: Array
    """d mu / dq (n,); see :func:`humanoid_rail.kinematics.manipulability.manipulability_gradient` for where mu is 0."""
    clearance: Array
    """psi of eq. 3.3 (L, O): signed distance of each link from each obstacle, m; negative in penetration."""
    clearance_gradient: Array
    """d psi / dq (L, O, n)."""
    pieces: Clearances
    """The clearances of each link from each convex piece (L, K): those from the obstacles, if none has several."""
    links: Clearances
    """The clearances of pairs of links (P,), in the order of `Robot.self_collision_pairs`."""

    def __post_init__(self) -> None:
        for value in (*vars(self).values(), *self.pieces, *self.links):
            if isinstance(value, np.ndarray):
                value.flags.writeable = False


class Measurement(NamedTuple):
    """The values of a :class:`State` without its derivatives."""

    hands: Array
    """(h, 3), m."""
    manipulability: float
    clearance: Array
    """(L, O), m; infinite where it was not asked for."""
    self_clearance: Array
    """Of pairs of links (P,), m."""


class Course(NamedTuple):
    """What is true along a motion of N configurations."""

    hands: Array
    """(N, h, 3), m."""
    manipulability: Array
    """(N,)."""
    clearance: Array
    """Signed distance of the nearest link from each obstacle (N, O), m; infinite where it was not asked for."""


class KinematicsModel(Protocol):
    """A robot among obstacles: :class:`humanoid_rail.Kinematics` in Python, or the native engine's."""

    @property
    def robot(self) -> Robot:
        """The robot."""
        ...

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles."""
        ...

    def state(self, q: ArrayLike, t: float = 0.0) -> State:
        """Return everything that eq. 4.9 and its constraints need to know at a configuration (n,) and a time in s."""
        ...

    def measure(self, q: ArrayLike, horizon: float = np.inf, t: float = 0.0) -> Measurement:
        """Return hands, manipulability and clearances at a configuration (n,), without derivatives.

        Args:
            q: Configuration (n,), m and rad.
            horizon: Clearances beyond it are infinite, except for the smallest of all, m. Those of pairs of links are
                given in any case.
            t: Time, which matters where obstacles move, s.
        """
        ...

    def along(self, q: ArrayLike, horizon: float = np.inf, t: ArrayLike | None = None) -> Course:
        """Return the same for each configuration of a motion (N, n), with the clearances of the nearest link.

        Args:
            q: Configurations (N, n), m and rad.
            horizon: As for :meth:`measure`.
            t: Times (N,), which matter where obstacles move, s; 0 if not given.
        """
        ...


def checked_course(robot: Robot, q: ArrayLike, t: ArrayLike | None) -> tuple[Array, Array]:
    """Return the configurations (N, n) of a motion, m and rad, and the times (N,), s, which are 0 if not given.

    Raises:
        InvalidInput: If they are not finite numbers of these shapes.
    """
    rows = len(q) if isinstance(q, Sized) else 0
    shape = (rows, robot.n)
    return (
        checked_array("q", q, shape, f"one configuration or more, each of {robot.n} finite numbers"),
        np.zeros(rows) if t is None else checked_array("t", t, (rows,), f"{rows} finite times"),
    )
