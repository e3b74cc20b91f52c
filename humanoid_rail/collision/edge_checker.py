"""Whether a robot keeps its distance from everything, at a configuration or on the straight edge between two.

An edge is not sampled but proven: the native engine halves it until the bounds on swept distances show of every pair
that it keeps its distance (`engine/collision/edge_checker.cpp`). Where no two bodies can get farther than a millimetre
relative to each other and the bounds still leave it open, the answer is no. So an edge is never wrongly said to be
valid, however thin an obstacle is.
"""

from __future__ import annotations

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle


class EdgeChecker:
    """A robot among obstacles where they are at t = 0. Threads may share it: calls wait for one another.

    Raises:
        EngineMissing: If there is no native engine.
    """

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...], distance: float, own_share: float = 1.0) -> None:
        """Set up the check.

        Args:
            robot: The robot.
            obstacles: What it keeps clear of, beside its own links.
            distance: The distance that links keep from obstacles and from each other, m.
            own_share: Pairs of links with a smaller one of their own, `Robot.pair_distances`, keep this share of it.
        """
        self.robot, self.distance = robot, distance
        native = engine().EdgeChecker(native_robot(robot), native_obstacles(obstacles), distance, own_share)
        self._is_valid, self._is_edge_valid = native.is_valid, native.is_edge_valid

    def is_valid(self, q: Array) -> bool:
        """Return whether a configuration (n,) is within the limits and every pair keeps its distance there."""
        valid: bool = self._is_valid(q)
        return valid

    def is_edge_valid(self, a: Array, b: Array) -> bool:
        """Return whether that is proven of the straight edge between two configurations (n,), m and rad."""
        valid: bool = self._is_edge_valid(a, b)
        return valid
