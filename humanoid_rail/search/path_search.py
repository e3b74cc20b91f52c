"""Looks for ways: goals by inverse kinematics, straight ways, sampled ways, shorter ones.

`way_out.py` says how these follow each other.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.search.goal_sampler import Solve, pull
from humanoid_rail.search.smoothing import path_length, speed_units
from humanoid_rail.model.robot import Robot
from humanoid_rail.search.rrt_connect import Sampler, Validity

SEEDS = 16
"""Starts of the inverse kinematics, ..."""
MORE_SEEDS = 48
"""... of which there are more if few of them lead to goals, ..."""
MOST_SEEDS = 4096
"""... and how many at most, if none does."""
NEAREST, GOALS = 8, 4
"""Of so many goals nearest to the start, so many are kept."""
FIRST_CHECKS, GROWTH = 600, 1.2
"""Checks of the first search, and how many times as many each of the next gets."""
MOST_CHECKS = 1e6
"""Nor does any get more checks than this."""
EDGES = (0.7, 0.3, 0.15)
"""The longest edge of the trees, s, in turns: short ones find narrow ways, long ones are quick."""
FIRST_MARGIN, MARGIN_GROWTH = 0.6, 1.1
"""How far the box of the first search reaches beyond start and goals, s, and how many times as far that of the next."""
GOOD = 1.05
"""A way is short enough if it is no longer than this, in units of the distance to the nearest goal."""
EFFORT_AFTER_QP = 250
"""Checks spent on a shorter way than that of the safe velocity."""
EFFORT, LEAST_EFFORT, MOST_EFFORT = 10.0, 1500, 8000
"""Checks spent on a shorter way than the first that was sampled: as many times what that one took, within bounds."""
FEW = 50
"""It is not worth while to start a search with fewer checks."""
QP, STRAIGHT, RRT_CONNECT = "qp", "straight line", "rrt-connect"
"""What finds ways."""


@dataclass(eq=False)
class WaySearch:
    """What is known while a way is looked for. Paths are (K, n), configurations (n,), m and rad; lengths in s."""

    robot: Robot
    validity: Validity
    solve: Solve
    """Inverse kinematics."""
    distance: float
    """What a goal keeps from everything, m."""
    start: Array
    seeds: Iterator[Array]
    """Where the inverse kinematics begins."""
    random: np.random.Generator
    deadline: float
    goals: list[Array] = field(default_factory=list)
    """Those nearest to the start."""
    tried: int = 0
    """From how many configurations goals were looked for."""
    known: int = 0
    """How many goals there are in all."""
    best: Array | None = None
    found_by: str = ""
    raw: Array | None = None
    checks: int = 0
    searches: int = 0

    def _is_over(self) -> bool:
        return time.perf_counter() > self.deadline

    def _length(self, path: Array) -> float:
        return path_length(self.robot, path)

    def _from_start(self, q: Array) -> float:
        return self._length(np.array([self.start, q]))

    def consider(self, found_by: str, path: Array) -> None:
        """Keep a way if it is the shortest so far."""
        if self.best is None or self._length(path) < self._length(self.best):
            self.best, self.found_by = path, found_by

    def completed(self, path: Array) -> Array:
        """Return a path that ends within the tolerance of the targets, led on to a goal if there is a straight way."""
        posture = self.solve(path[-1])
        exact = posture.reaches(self.distance) and self.validity.holds_between(path[-1], posture.q)
        return np.vstack([path, posture.q]) if exact else path

    def find_goals(self, count: int, most: int) -> list[Array]:
        """Return goals that are found from `count` starts, or from up to `most` as long as there are few."""
        found: list[Array] = []
        for i, seed in enumerate(islice(self.seeds, most)):
            if self._is_over() or (i >= count and len(found) >= GOALS):
                break
            self.tried += 1
            posture = self.solve(seed)
            if posture.reaches(self.distance):
                found.append(posture.q)
        return found

    def choose_goals(self, objective: Callable[[Array], float]) -> None:
        """Of the goals nearest to the start, keep the first, and those of the others whose objective is largest."""
        found = self.find_goals(SEEDS, MORE_SEEDS)
        if not found and self.best is None:
            found = self.find_goals(0, MOST_SEEDS)
        nearest = sorted(found, key=self._from_start)[:NEAREST]
        kept = [*nearest[:1], *sorted(nearest[1:], key=objective, reverse=True)[: GOALS - 1]]
        pulled = (pull(self.robot, q, self.start, self.solve, self.distance, self.deadline) for q in kept)
        self.goals = sorted(pulled, key=self._from_start)
        if not self.goals and self.best is not None:
            self.goals = [self.best[-1]]
        self.known = len(self.goals)

    def go_straight(self) -> None:
        """Look for a straight way to a goal."""
        for goal in self.goals:
            self.checks += 1
            if self.validity.holds_between(self.start, goal):
                self.consider(self.found_by or STRAIGHT, np.array([self.start, goal]))
                return

    def sample(self) -> None:
        """Look for ways by sampling until there is one, and for shorter ones while that may pay."""
        margin, most, effort = FIRST_MARGIN, float(FIRST_CHECKS), float(EFFORT_AFTER_QP)
        goals, others = self.goals, list[Array]()
        shortened = self.best is None or len(self.best) == 2
        while self.goals and not self._is_over():
            left = np.inf
            if self.best is not None:
                left = effort - self.checks
                if self._length(self.best) <= GOOD * self._from_start(self.goals[0]) or left < FEW:
                    break
            sampler = Sampler(self.robot, self.validity, *self._box(goals, margin), self.deadline)
            if self.best is not None and not shortened:
                self.consider(self.found_by, sampler.shorten(self.best, self._seed()))
                shortened = True
            else:
                edge = EDGES[self.searches % len(EDGES)]
                self.searches += 1
                path = sampler.connect(self.start, goals, self._seed(), edge, int(min(most, left)))
                if path is not None:
                    if self.best is None:
                        effort = min(max(EFFORT * (self.checks + sampler.checks), LEAST_EFFORT), MOST_EFFORT)
                        goals = [*self.goals, path[-1]]
                    self.raw = path if self.raw is None else self.raw
                    self.consider(RRT_CONNECT, sampler.shorten(path, self._seed()))
                elif self.best is None:
                    # Perhaps these goals are where nothing leads to: others are tried, then all, and so on.
                    if self.searches % 2:
                        found = self.find_goals(SEEDS, MORE_SEEDS)
                        others += found
                        goals = found or self.goals
                    else:
                        goals = [*self.goals, *others]
                    margin, most = margin * MARGIN_GROWTH, min(most * GROWTH, MOST_CHECKS)
            # A search that ends at once has to end too.
            self.checks += max(1, sampler.checks)
        self.known = len(self.goals) + len(others)

    def explain(self, max_planning_time: float) -> str:
        """Say why there is no way."""
        if not self.goals and self._is_over():
            return f"{max_planning_time:g} s did not suffice to find a configuration at the targets, let alone a way"
        if not self.goals:
            what = f"no configuration at the targets that keeps {self.distance:.3g} m from everything"
            return f"{what} was found by inverse kinematics from {self.tried} starts"
        return (
            f"no way to any of {self.known} configurations at the targets was found in {max_planning_time:g} s "
            f"({self.searches} searches, {self.checks} straight ways checked); what is in the way may leave none"
        )

    def _box(self, goals: list[Array], margin: float) -> tuple[Array, Array]:
        ends = np.array([self.start, *goals, *([] if self.best is None else self.best)])
        beyond = np.where(self.robot.velocity_limit > 0, margin * speed_units(self.robot), 0.0)
        lower = np.maximum(self.robot.lower, ends.min(axis=0) - beyond)
        return lower, np.minimum(self.robot.upper, ends.max(axis=0) + beyond)

    def _seed(self) -> int:
        return int(self.random.integers(1, 2**31))
