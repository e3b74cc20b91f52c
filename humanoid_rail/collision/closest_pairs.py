"""The closest bodies at moments of a motion: a link and an obstacle, and two links. In C++."""

from __future__ import annotations

from typing import NamedTuple

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle


class ClosestPair(NamedTuple):
    """The two bodies of a kind that are closest to each other at a moment."""

    link: int
    """Index of the link of the robot."""
    other: int
    """Index of the obstacle or of the other link."""
    distance: float
    """m; negative in penetration."""
    points: Array
    """The nearest points (2, 3) on the link and on the other, in the base frame, m."""


def closest_pairs(
    robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array
) -> tuple[tuple[ClosestPair, ...], tuple[ClosestPair, ...]]:
    """Return the closest link and obstacle and the closest two links at each of some moments.

    A pair remains the closest until another is closer by more than rounding: some links are always equally far from
    each other.

    Args:
        robot: The robot.
        obstacles: What may move, from t = 0.
        t: The moments (K,), in order, s.
        q: The configurations then (K, n), m and rad.

    Returns:
        The pairs (K,) of links and obstacles, empty without obstacles, and the pairs (K,) of links, empty where there
        are none to check.

    Raises:
        EngineMissing: If there is no native engine.
    """
    found = engine().closest_pairs(native_robot(robot), native_obstacles(obstacles), t, q)
    with_obstacles, of_links = (tuple(ClosestPair(*pair) for pair in kind) for kind in found)
    return with_obstacles, of_links
