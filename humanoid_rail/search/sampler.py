"""Paths between configurations by sampling: RRT-Connect and shortcuts, in the native engine.

RRT-Connect (Kuffner and LaValle 2000) grows a tree from the start and one from the goals until they meet. What it finds
is shortened: random points of the path are joined by straight edges, and its corners are drawn in. Configurations are
measured in units of the speed limits, so that the length of a path is the time it takes at them.

Both ask of an edge only whether samples of it keep the distance, eight at once (`engine/search/edge_filter.cpp`). Then
each edge of the path is proven (`collision/edge_checker.py`). One that cannot be is replaced by a short path of proven
edges; where none is found, the path counts as not found.

With constraints, trees and shortcuts grow by short steps, each brought back onto the constraints
(`engine/search/manifold.cpp`; Berenson, Srinivasa, Ferguson and Kuffner 2009).

The same seed gives the same path on every machine, whatever other threads do.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.kinematics.path_metric import speed_units
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Obstacle


class Sampler:
    """A robot among obstacles where they are at t = 0. Threads may share it: calls wait for one another.

    Raises:
        EngineMissing: If there is no native engine.
    """

    def __init__(
        self,
        robot: Robot,
        obstacles: tuple[Obstacle, ...],
        distance: float,
        deadline: float = np.inf,
        constraints: Sequence[Task] = (),
    ) -> None:
        """Set up the search.

        Args:
            robot: The robot.
            obstacles: What it keeps clear of, beside its own links.
            distance: The distance that links keep from obstacles and from each other, m.
            deadline: When to stop, on the clock of `time.perf_counter`, s.
            constraints: What holds on paths, up to what short edges between configurations where it does deviate.
        """
        kept = native_tasks(robot, constraints, NativeKinematics(robot).state) if constraints else None
        self._is_constrained = kept is not None
        self._native = engine().Sampler(
            native_robot(robot), native_obstacles(obstacles), distance, 1.0, speed_units(robot), kept
        )
        self._deadline = deadline
        self.checks = 0
        """The number of edges that have been checked."""
        self.explored: Array | None = None
        """Configurations (K, n) to which the last search that failed seems to have paths; None before one."""

    def straight(self, checker: EdgeChecker, start: Array, goal: Array) -> Array | None:
        """Return the straight path (K, n) between two configurations (n,) if it is proven; None if it is not.

        Args:
            checker: Proves edges.
            start: Where it begins, m and rad.
            goal: Where it ends. With constraints they hold in both, and the path takes short steps along them.
        """
        self.checks += 1
        if not self._is_constrained:
            return np.array([start, goal]) if checker.is_edge_valid(start, goal) else None
        path, _, checks = self._native.walk(start, goal)
        self.checks += checks
        found: Array | None = path
        return found

    def connect(
        self,
        start: Array,
        goals: Sequence[Array],
        box: tuple[Array, Array],
        seed: int,
        longest: float,
        max_checks: int,
    ) -> Array | None:
        """Return a path (K, n) from a start to one of some goals by RRT-Connect; None if there was none in time.

        Its edges are not proven: `shorten` does that.

        Args:
            start: Configuration (n,), m and rad.
            goals: Configurations (n,).
            box: Two opposite corners (n,) of the box in which to look.
            seed: Seed of the random numbers.
            longest: The longest edge of the trees, s.
            max_checks: The most edges to check.
        """
        path, explored, checks = self._native.connect(
            start, np.array(goals), *box, longest, seed, max_checks, self._seconds()
        )
        self.checks += checks
        if path is None:
            self.explored = explored
        found: Array | None = path
        return found

    def shorten(self, path: Array, seed: int, max_checks: int, shorter_than: float = np.inf) -> Array | None:
        """Return a path (K, n) with the same ends that is shorter, or as long, and proven; None if that fails.

        Args:
            path: Configurations (K, n), joined by edges that seem to be free.
            seed: Seed of the random numbers.
            max_checks: The most edges to check before the proof.
            shorter_than: A path that takes no less than this at the speed limits is not worth proving, s.
        """
        shorter, _, checks = self._native.shorten(path, shorter_than, seed, max_checks, self._seconds())
        self.checks += checks
        found: Array | None = shorter
        return found

    def _seconds(self) -> float:
        return max(0.0, self._deadline - time.perf_counter())
