"""Whether a robot keeps its distance from everything, at a configuration or all the way between two.

This is the reference; `engine/validity.cpp` has the same in C++.

A straight way in q is not sampled but proven: it is halved until the bounds of `sweep.py` show of every pair that it
keeps its distance. Where no two bodies can get farther than a millimetre relative to each other and the bounds still
leave it open, the answer is no. So a way is never wrongly said to hold, however thin an obstacle is.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.model.robot import Robot
from humanoid_rail.collision.swept_distance import Nearest, Pair, Snapshot, Sweep

SHORT = 1e-3
"""Where two bodies get no farther than this relative to each other, a way is not halved again, m."""


class Validity:
    """A robot among obstacles where they are at t = 0. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...], distance: float) -> None:
        """Set up the check.

        Args:
            robot: The robot.
            obstacles: What it keeps clear of, beside its own links.
            distance: What links keep from obstacles and from each other, m.
        """
        self.robot, self.distance = robot, distance
        self._sweep = Sweep(robot, obstacles)
        self._pairs = [*self._sweep.obstacle_pairs, *self._sweep.link_pairs]

    def holds_at(self, q: Array) -> bool:
        """Return whether a configuration (n,) is within the limits and every pair keeps its distance there."""
        return self._is_within_limits(q) and self._measure(self._sweep.take(0.0, q), self._pairs) is not None

    def holds_between(self, a: Array, b: Array) -> bool:
        """Return whether that is proven of the straight way between two configurations (n,), m and rad."""
        if not self._is_within_limits(a) or not self._is_within_limits(b):
            return False
        links, pairs = self._sweep.ways(a, b)
        start, end = self._sweep.take(0.0, a), self._sweep.take(0.0, b)
        here, there = self._measure(start, self._pairs), self._measure(end, self._pairs)
        if here is None or there is None:
            return False
        # The longer parts first: a way that does not hold mostly fails in its middle.
        parts = deque([(1.0, start, here, end, there)])
        while parts:
            length, start, here, end, there = parts.popleft()
            left = []
            for pair in here:
                reach, column = (pairs, pair.number) if pair.piece is None else (links, pair.link)
                travel, curvature = length * reach.travel[column], length**2 * reach.curvature[column]
                near = here[pair], there[pair]
                bound = self._sweep.least(pair, near[0], start, near[1], end, travel, curvature, self.distance)
                if bound >= self.distance:
                    continue
                if travel <= SHORT:
                    return False
                left.append(pair)
            if not left:
                continue
            middle = self._sweep.take(0.0, 0.5 * (start.q + end.q))
            between = self._measure(middle, left)
            if between is None:
                return False
            parts.append((0.5 * length, start, {pair: here[pair] for pair in left}, middle, between))
            parts.append((0.5 * length, middle, between, end, {pair: there[pair] for pair in left}))
        return True

    def _is_within_limits(self, q: Array) -> bool:
        return bool(np.all(q >= self.robot.lower) and np.all(q <= self.robot.upper))

    def _measure(self, at: Snapshot, pairs: list[Pair]) -> dict[Pair, Nearest] | None:
        """Return how near pairs are at a moment; None if one does not keep its distance."""
        near = {}
        for pair in pairs:
            near[pair] = self._sweep.measure(pair, at)
            if near[pair].distance < self.distance:
                return None
        return near
