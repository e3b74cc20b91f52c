"""How far the points of links can get while the joints move at constant rates.

The bounds come from the lengths of the links and the rates of the joints alone and are valid in every configuration, as
in conservative advancement (Mirtich 1996; Zhang, Lee and Kim 2006). `engine/collision/motion_bound.cpp` derives them.
"""

from __future__ import annotations

from typing import NamedTuple

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot


class Displacements(NamedTuple):
    """Bounds for the points of all links (L,), when the joints move at constant rates for a unit of time."""

    length: Array
    """The longest path of a point, m."""
    curvature: Array
    """The largest second derivative by that time, m."""


class MotionBound:
    """Bounds on the motion of a robot's links. Threads may share it: calls wait for one another.

    Raises:
        EngineMissing: If there is no native engine.
    """

    def __init__(self, robot: Robot) -> None:
        self._native = engine().MotionBound(native_robot(robot))

    def displacements(self, change: Array, slide: Array, origin: int) -> Displacements:
        """Return how far the links get relative to the body of a joint; those it does not carry do not move.

        Args:
            change: How far the joints move (nv,), m and rad.
            slide: The farthest that each is from 0 on the way (nv,), m and rad.
            origin: The joint, 0 for the base.
        """
        return Displacements(*self._native.displacements(change, slide, origin))
