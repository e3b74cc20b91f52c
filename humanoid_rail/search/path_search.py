"""Looks for paths: goals by inverse kinematics, straight edges, sampled paths, shortcuts.

`auto.py` says how these follow each other.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.path_metric import least_travel_time, speed_units
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.search.sampler import Sampler

SEEDS = 10
"""Goals are looked for from this many starts of the inverse kinematics."""
FEW_SEEDS = 4
"""A straight edge is looked for to the nearest of the goals from this many starts before others are looked for."""
TOGETHER = 8
"""Goals are looked for from this many starts before the clock is looked at."""
MORE_SEEDS = 48
"""Goals are looked for from up to this many starts if few of them lead to goals."""
MAX_SEEDS = 4096
"""Goals are looked for from up to this many starts if none leads to one."""
NEAREST = 8
"""The goals to choose from are this many, those nearest to the start."""
GOALS = 3
"""The search goes to this many goals at once."""
FIRST_CHECKS = 600
"""The first search of RRT-Connect may check this many edges."""
GROWTH = 1.2
"""Each further search may check this many times as many edges."""
MAX_CHECKS = 1e6
"""No single search may check more edges than this."""
LONGEST_EDGES = (0.7, 0.3, 0.15)
"""The longest edges of the trees in turn, s: short ones find narrow passages, long ones are quick."""
FIRST_MARGIN = 0.6
"""The box of the first search reaches this far beyond start and goals, s."""
MARGIN_GROWTH = 1.1
"""The box of each further search reaches this many times as far."""
GOOD = 1.05
"""A path is short enough if it is no longer than this, in units of the distance to the nearest goal."""
EFFORT_AFTER_QP = 250
"""This many edge checks are spent on a shorter path than that of the safe velocity."""
EFFORT = 4.0
"""A shorter path than the first sampled one is looked for with this many times the checks that one took."""
LEAST_EFFORT = 300
"""At least this many edge checks are spent on a shorter path than the first sampled one."""
MOST_EFFORT = 8000
"""At most this many edge checks are spent on a shorter path than the first sampled one."""
FEW = 50
"""A search with fewer edge checks than this is not worth starting."""
QP, STRAIGHT, RRT_CONNECT = "qp", "straight line", "rrt-connect"
"""These find paths: the safe velocity, a straight edge, sampling."""


@dataclass(eq=False)
class PathSearch:
    """What is known while a path is looked for. Paths are (K, n), configurations (n,), m and rad.

    The length of a path is the least time that it takes at the speed limits, s.
    """

    robot: Robot
    checker: EdgeChecker
    sampler: Sampler
    solver: InverseKinematics
    choices: Sequence[Sequence[Task]]
    """What may be reached, of which one has to be."""
    distance: float
    """The distance that a goal keeps from everything, m."""
    start: Array
    seeds: Iterator[Array]
    """Where the inverse kinematics begins."""
    random: np.random.Generator
    max_edge_checks: int
    """The budget that decides when there is no path."""
    deadline: float
    """When planning is cut off, on the clock of `time.perf_counter`, s."""
    time_option: str
    """The option that cuts planning off, with its value."""
    goals: list[Array] = field(default_factory=list)
    """The goals nearest to the start."""
    pulled: list[Array] = field(default_factory=list)
    """The goals that are as near to the start as they get."""
    tried: int = 0
    """The number of configurations from which goals were looked for."""
    known: int = 0
    """The number of goals in all."""
    best: Array | None = None
    found_by: str = ""
    inexact: tuple[str, Array] | None = None
    """What found a path that ends near its targets, and this path; it counts where there is no path to a goal."""
    raw: Array | None = None
    checks: int = 0
    searches: int = 0
    explored: Array | None = None
    """Configurations (K, n) that the last sampling that failed has paths to from the start."""

    def choice_at(self, q: Array) -> int:
        """Return the number of the choice whose error is smallest at a configuration (n,)."""
        if len(self.choices) == 1:
            return 0
        return int(np.argmin([np.linalg.norm(self.solver.evaluate(q, tasks)[0]) for tasks in self.choices]))

    def is_timed_out(self) -> bool:
        """Return whether planning has to be cut off."""
        return time.perf_counter() > self.deadline

    def _length(self, path: Array) -> float:
        return least_travel_time(self.robot, path)

    def _from_start(self, q: Array) -> float:
        return self._length(np.array([self.start, q]))

    def consider(self, found_by: str, path: Array) -> None:
        """Keep a path if it is the shortest so far."""
        if self.best is None or self._length(path) < self._length(self.best):
            self.best, self.found_by = path, found_by

    def arrive(self, found_by: str, path: Array) -> None:
        """Keep a path that ends within the tolerance of its targets, continued to a goal where that edge is valid.

        Where it is not, other paths to goals are looked for first, but not for long.
        """
        posture = self.solver.solve(path[-1], self.choices[self.choice_at(path[-1])], self.distance)
        last = self.sampler.straight(self.checker, path[-1], posture.q) if posture.reached else None
        if last is not None:
            self.consider(found_by, np.vstack([path, last[1:]]))
        else:
            self.inexact = found_by, path

    def find_goals(self, count: int, most: int) -> list[Array]:
        """Return goals that are found from `count` starts, or from up to `most` as long as there are few."""
        found: list[Array] = []
        tried = 0
        while tried < most and not self.is_timed_out() and (tried < count or len(found) < GOALS):
            starts = list(islice(self.seeds, min(TOGETHER, (count if tried < count else most) - tried)))
            for tasks in self.choices:
                found += self.solver.reached(starts, tasks, self.distance)
            tried += len(starts)
        self.tried += tried
        return found

    def _pulled(self, goal: Array) -> Array:
        """Return a goal pulled towards the start, once."""
        if self.is_timed_out() or any(goal is one for one in self.pulled):
            return goal
        self.pulled.append(self.solver.pulled(goal, self.start, self.choices[self.choice_at(goal)], self.distance))
        return self.pulled[-1]

    def choose_goals(self, objective: Callable[[Array], float], last: bool = False) -> None:
        """Of the goals nearest to the start, keep the first, and those of the others whose objective is largest.

        Args:
            objective: Of a goal (n,).
            last: Whether to go on for long where there seems to be none.
        """
        found = [*self.goals, *self.find_goals(SEEDS, MORE_SEEDS)]
        if last and not found and self.best is None and self.inexact is None:
            found = self.find_goals(0, MAX_SEEDS)
        nearest = sorted(found, key=self._from_start)[:NEAREST]
        kept = [*nearest[:1], *sorted(nearest[1:], key=objective, reverse=True)[: GOALS - 1]]
        self.goals = sorted(map(self._pulled, kept), key=self._from_start)
        if not self.goals and self.best is not None:
            self.goals = [self.best[-1]]
        self.known = len(self.goals)

    def go_to_nearest(self) -> None:
        """Look for a straight edge to the nearest goal of those that are found from the start and a few others."""
        found = self.find_goals(FEW_SEEDS, FEW_SEEDS)
        self.goals = [self._pulled(min(found, key=self._from_start))] if found else []
        self.known = len(self.goals)
        self.go_straight()

    def go_straight(self) -> None:
        """Look for a straight edge to a goal."""
        for goal in self.goals:
            before = self.sampler.checks
            path = self.sampler.straight(self.checker, self.start, goal)
            self.checks += self.sampler.checks - before
            if path is not None:
                self.consider(self.found_by or STRAIGHT, path)
                return

    def sample(self, budget: int | None = None) -> None:
        """Look for paths by sampling until there is one, and for shorter ones while that may pay.

        Args:
            budget: The most edges to check, with those before; the whole budget if not given.
        """
        most = self.max_edge_checks if budget is None else min(budget, self.max_edge_checks)
        if self.best is None and self.inexact is not None:
            self._sample(min(self.checks + LEAST_EFFORT, most), 0)
            if self.best is not None:
                return
            self.consider(*self.inexact)
            self.goals = [self.inexact[1][-1]]
        self._sample(most, self.checks + EFFORT_AFTER_QP)

    def _sample(self, budget: float, effort: float) -> None:
        """Look for paths until there is one or so many edges are checked, and then for shorter ones.

        Args:
            budget: The most edges to check, with those before.
            effort: The most edges to check for a shorter path than the one there is, with those before.
        """
        margin, most = FIRST_MARGIN, float(FIRST_CHECKS)
        goals, others = self.goals, list[Array]()
        shortened = self.best is None or len(self.best) == 2
        while self.goals and not self.is_timed_out() and self.checks < budget:
            before, left = self.sampler.checks, budget - self.checks
            if self.best is not None:
                left = min(left, effort - self.checks)
                if self._length(self.best) <= GOOD * self._from_start(self.goals[0]) or left < FEW:
                    break
            if self.best is not None and not shortened:
                self._shorten(self.found_by, self.best, left)
                shortened = True
            else:
                longest = LONGEST_EDGES[self.searches % len(LONGEST_EDGES)]
                self.searches += 1
                box, first = self._box(goals, margin), self.best is None
                raw = self.sampler.connect(self.start, goals, box, self._seed(), longest, int(min(most, left)))
                if raw is not None and self._shorten(RRT_CONNECT, raw, left):
                    self.raw = raw if self.raw is None else self.raw
                    if first:
                        spent = self.checks + self.sampler.checks - before
                        effort = min(max(EFFORT * spent, LEAST_EFFORT), MOST_EFFORT)
                        goals = [*self.goals, raw[-1]]
                elif first:
                    self.explored = self.sampler.explored
                    goals = self._other_goals(others)
                    margin, most = margin * MARGIN_GROWTH, min(most * GROWTH, MAX_CHECKS)
            # A search that ends at once has to count too.
            self.checks += max(1, self.sampler.checks - before)
        self.known = len(self.goals) + len(others)

    def _shorten(self, found_by: str, path: Array, left: float) -> bool:
        """Consider a path, shortened and proven; False if that fails, or it is not the shortest."""
        least = np.inf if self.best is None else self._length(self.best)
        shorter = self.sampler.shorten(path, self._seed(), int(left), least)
        if shorter is not None:
            self.consider(found_by, shorter)
        return shorter is not None

    def _other_goals(self, others: list[Array]) -> list[Array]:
        """Return what to search for next: nothing may lead to these goals, so others are tried, then all, and so on."""
        if self.searches % 2:
            found = self.find_goals(SEEDS, MORE_SEEDS)
            others += found
            return found or self.goals
        return [*self.goals, *others]

    def explain(self) -> str:
        """Say why there is no path."""
        if self.is_timed_out():
            what = "no path was found" if self.goals else "no configuration at the targets was found"
            return f"{what} before planning was cut off by {self.time_option} ({self._effort()})"
        if not self.goals:
            what = f"no configuration at the targets that keeps {self.distance:.3g} m from everything"
            return (
                f"{what} (safety_distance and a little more) was found by inverse kinematics from {self.tried} starts"
            )
        return (
            f"no path to any of {self.known} configurations at the targets was found ({self._effort()}); the obstacles "
            "may leave none"
        )

    def _effort(self) -> str:
        return f"{self.searches} searches, {self.checks} edges checked, max_edge_checks = {self.max_edge_checks}"

    def _box(self, goals: list[Array], margin: float) -> tuple[Array, Array]:
        """Return two corners (n,) of a box that reaches beyond everything known by a margin in s."""
        ends = np.array([self.start, *goals, *([] if self.best is None else self.best)])
        beyond = np.where(self.robot.velocity_limit > 0, margin * speed_units(self.robot), 0.0)
        lower, upper = ends.min(axis=0) - beyond, ends.max(axis=0) + beyond
        return np.maximum(self.robot.lower, lower), np.minimum(self.robot.upper, upper)

    def _seed(self) -> int:
        return int(self.random.integers(1, 2**31))
