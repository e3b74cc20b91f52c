"""A lower bound of clearances while a robot moves straight from one configuration to another.

Two bounds of the distance d of two convex bodies, which is measured at both ends a and b of the edge:

- From either end d has shrunk by no more than the path from there, so d >= (d_a + d_b - l) / 2, where l bounds how far
  the points of the two can get relative to each other (conservative advancement).
- Let n be the normal of their nearest points at one end. The gap between the planes with normal n that touch the one
  and the other is a lower bound of d at any moment. The coordinate of each point along n differs from a straight line
  from a to b by at most an eighth of its largest second derivative c, so d >= min(gap_a, gap_b) - c / 8. Short edges
  lose next to nothing.

For two links all this is seen from the body that carries both. The native engine computes it
(`engine/collision/swept_distance.cpp`); this class shows it pair by pair.
"""

from __future__ import annotations

from typing import NamedTuple

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle


class Pair(NamedTuple):
    """Two bodies that must not touch."""

    link: int
    other: int
    """The obstacle, or the other link."""
    piece: int
    """The convex piece of all obstacles' pieces; -1 for two links."""


class Nearest(NamedTuple):
    """How near two bodies are."""

    distance: float
    """m; negative in penetration."""
    point: Array
    """The nearest point on the link (3,), in the base frame, m."""
    normal: Array
    """From the link to the other (3,), in penetration too."""


class SweptDistance:
    """A robot among obstacles that may move. Threads may share it: calls wait for one another.

    Raises:
        EngineMissing: If there is no native engine.
    """

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...]) -> None:
        self._native = engine().SweptDistance(native_robot(robot), native_obstacles(obstacles))
        self.pairs = tuple(Pair(*pair) for pair in self._native.pairs())

    def distance(self, pair: int, t: float, q: Array) -> Nearest:
        """Return how near the bodies of a pair are at a time in s and a configuration (n,)."""
        return Nearest(*self._native.distance(pair, t, q))

    def lower_bound(self, pair: int, t_a: float, a: Array, t_b: float, b: Array) -> float:
        """Return a lower bound of the distance of a pair on the edge between configurations (n,) at two times, m."""
        bound: float = self._native.lower_bound(pair, t_a, a, t_b, b)
        return bound
