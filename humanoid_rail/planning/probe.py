"""Tries out changed problems: is there a configuration at the targets, and is there a path to it?"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from humanoid_rail._arrays import Array, triple
from humanoid_rail.diagnosis import Vector
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics, Posture
from humanoid_rail.kinematics.task import DirectionTask, PointTask, Task
from humanoid_rail.kinematics.within_task import WithinTask, nominal
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import Auto
from humanoid_rail.problem import Problem
from humanoid_rail.result import Method, Status
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.search.clear_start import SPARE
from humanoid_rail.search.goal_sampler import seeds

MAX_SOLVES = 3000
"""Inverse kinematics is called at most this often for one diagnosis."""
MANY_BODIES = 5000
"""From so many pairs of a link and a convex obstacle on, it is called less often: a call takes longer."""
STARTS = 24
"""Configurations are looked for from this many places beside those that are near."""
PLAN_CHECKS = 1000
"""A plan that is tried out may check this many edges."""
MAX_PLANS = 12
"""At most this many plans are tried out for one diagnosis."""


class Probe:
    """Tries out changed problems within a budget. The same problem always gives the same answers."""

    def __init__(self, problem: Problem, method: Method, near: Sequence[Array], deadline: float) -> None:
        """Set up the budget.

        Args:
            problem: What was not solved. Its obstacles are at rest.
            method: What was to solve it. Changed problems are planned by `auto`.
            near: Configurations (n,) where others are looked for first, m and rad.
            deadline: When nothing more is tried, on the clock of `time.perf_counter`, s.
        """
        self.problem, self.robot, self.deadline = problem, problem.robot, deadline
        self.spare = SPARE
        self.has_distance = method.kept_distance is not None
        # Where the method keeps none, `auto` keeps its own.
        self.kept = Auto().safety_distance if method.kept_distance is None else method.kept_distance
        pairs = len(self.robot.link_names) * len(problem.obstacles)
        self.budget = max(100, int(MAX_SOLVES * min(1.0, MANY_BODIES / max(pairs, 1))))
        self.solves = self.plans = 0
        self.starts = [*near, *islice(seeds(self.robot, problem.q, np.random.default_rng(0)), STARTS)]
        chosen = method if isinstance(method, Auto) else Auto(safety_distance=self.kept, tolerance=0.01)
        # What counts is whether there is a path.
        self._method = replace(chosen, gain=1.0, optimise=False)
        self._solvers: dict[tuple[int, int], InverseKinematics] = {}

    @property
    def is_over(self) -> bool:
        """Whether nothing more may be tried."""
        return self.solves >= self.budget or time.perf_counter() > self.deadline

    def solve(
        self,
        q: Array,
        tasks: Sequence[Task],
        distance: float | None = None,
        *,
        robot: Robot | None = None,
        obstacles: tuple[Obstacle, ...] | None = None,
    ) -> Posture:
        """Look from a configuration (n,) for one in which tasks are done.

        Args:
            q: Where to begin, m and rad.
            tasks: What is to be reached.
            distance: What is kept from everything, m; that of the method and what its paths keep more if not given.
            robot: A changed robot.
            obstacles: Changed obstacles.
        """
        robot = self.robot if robot is None else robot
        obstacles = self.problem.obstacles if obstacles is None else obstacles
        key = id(robot), id(obstacles)
        if key not in self._solvers:
            self._solvers[key] = InverseKinematics(robot, obstacles)
        self.solves += 1
        return self._solvers[key].solve(q, tasks, self.kept + self.spare if distance is None else distance)

    def posture(
        self,
        tasks: Sequence[Task],
        distance: float | None = None,
        *,
        robot: Robot | None = None,
        obstacles: tuple[Obstacle, ...] | None = None,
        near: Sequence[Array] = (),
    ) -> Array | None:
        """Return a configuration (n,) in which tasks are done, from some of many starts; None if none was found."""
        for q in (*near, *self.starts):
            if self.is_over:
                return None
            found = self.solve(q, tasks, distance, robot=robot, obstacles=obstacles)
            if found.reached:
                return found.q
        return None

    def is_planned(
        self,
        tasks: Sequence[Task],
        safety_distance: float | None = None,
        *,
        robot: Robot | None = None,
        obstacles: tuple[Obstacle, ...] | None = None,
        max_edge_checks: int = PLAN_CHECKS,
    ) -> bool:
        """Return whether `auto` finds a path to tasks from where the problem starts, within so many edge checks."""
        if self.plans >= MAX_PLANS or time.perf_counter() > self.deadline:
            return False
        self.plans += 1
        problem, method = self.problem, replace(self._method, max_edge_checks=max_edge_checks)
        scene = problem.scene if obstacles is None else problem.scene.model_copy(update={"obstacles": obstacles})
        if safety_distance is not None:
            method = replace(method, safety_distance=safety_distance)
        changed = Problem(self.robot if robot is None else robot, scene, tuple(tasks), problem.q, problem.constraints)
        return method.plan(changed).motion.status is Status.REACHED


def hand_of(task: Task) -> str | None:
    """Return the hand that a task is about; None if it is about none, or several."""
    return task.hand if isinstance(task, PointTask | DirectionTask | WithinTask) else None


def hands_with_targets(tasks: Sequence[Task]) -> list[str]:
    """Return the hands whose own points have a target."""
    return [task.hand for task in nominal(tasks) if isinstance(task, PointTask) and not any(task.offset)]


def target_of(tasks: Sequence[Task], hand: str) -> Vector:
    """Return the target of a hand, m; the middle of one with a tolerance."""
    points = (task for task in nominal(tasks) if isinstance(task, PointTask) and not any(task.offset))
    return next(task.target for task in points if task.hand == hand)


def shifted(tasks: Sequence[Task], hand: str, shift: Array) -> tuple[Task, ...]:
    """Return tasks with all points of a hand shifted by (3,), m."""
    return tuple(_shifted(task, shift) if hand_of(task) == hand else task for task in tasks)


def _shifted(task: Task, shift: Array) -> Task:
    if isinstance(task, WithinTask) and isinstance(task.task, PointTask):
        inner = _shifted(task.task, shift)
        assert isinstance(inner, PointTask)
        return replace(task, task=inner)
    if isinstance(task, PointTask):
        return replace(task, target=triple(np.add(task.target, shift)))
    return task
