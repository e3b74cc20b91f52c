"""Global planning where the local method gets stuck: the method `auto`.

1. The nearest of a few goals, configurations in which the tasks are done, is looked for by inverse kinematics. Where
   the straight edge to it is valid, that is the path.
2. More goals are looked for from many starts. Of the nearest, those are kept that the secondary objectives of eq. 4.9
   prefer. RRT-Connect looks for paths to all of them at once (`sampler.py`), again and again with more checks and in a
   larger box: one long search fails more often than many short ones.
3. Where that fails, or the start is too near to something, the safe velocity of `resolution/qp.py` is followed. Where
   it arrives, it gives a path; then the search goes on.
4. The path is shortened, and others are tried while that may pay. The shortest one is smoothed (`smoothing.py`).

Every edge of a path, sampled, shortened or rounded, is proven to keep the safety distance
(`collision/edge_checker.py`).
The steps of the safe velocity are proven free of contact, and keep the distance where they end.

Budgets are numbers of edge checks, never seconds: a seed gives the same plan. `max_planning_time` cuts planning off.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.deviation import name_of
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.task_stack import count_rows
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.rollout import rollout
from humanoid_rail.resolution.velocity import Gains, penalty
from humanoid_rail.result import Status
from humanoid_rail.search.blocked_targets import blocked_target, targets_inside
from humanoid_rail.search.clear_start import SPARE, clearance_at, first_clear
from humanoid_rail.search.exact_end import EXACT, error_at
from humanoid_rail.search.goal_sampler import seeds
from humanoid_rail.search.kept_path import FINE, on_constraints
from humanoid_rail.search.path_result import PathResult
from humanoid_rail.search.path_search import QP, PathSearch
from humanoid_rail.search.reachability import TimedOut, followed, out_of_reach
from humanoid_rail.search.sampler import Sampler
from humanoid_rail.search.smoothing import round_corners

STEP = 0.05
"""The safe velocity is held for this long, in time constants 1 / max(K): only its path matters."""
RESERVE = 0.03
"""This share of `max_planning_time` is left for what follows a search."""
QUICK_CHECKS = 2000
"""So many edges are checked before the safe velocity is followed."""
LOOSE_SHARE = 0.05
"""Smoothing may take at most this share of the distance that a path keeps."""
KEPT_STARTS = 200
"""Constraints and targets contradict each other if no configuration for both is found from this many starts."""
START_SHARE = 0.99
"""The part of a path that begins too near to something keeps this share of its own least clearance."""


@dataclass(frozen=True)
class Budget:
    """How much may be spent on a search."""

    max_edge_checks: int
    """The most edges to check; what is found depends on it."""
    random: np.random.Generator
    """The random numbers of goals and paths."""


def find_path(
    problem: Problem,
    gains: Gains,
    safety: Safety,
    settings: Settings,
    budget: Budget,
) -> PathResult:
    """Look for a path from a start to the targets among obstacles at rest.

    Args:
        problem: The robot, its tasks and the start, at which nothing touches.
        gains: Parameters of eq. 4.9.
        safety: Parameters of the constraints.
        settings: When a motion ends, and when planning is cut off.
        budget: How much may be spent.
    """
    searching = (1.0 - RESERVE) * settings.max_planning_time
    deadline = time.perf_counter() + searching
    distance = safety.safety_distance + SPARE
    search = None
    # Objectives of the user shape the safe velocity: it is followed first where there are some.
    if not gains.objectives and clearance_at(problem.native, problem.q) >= distance:
        search = _search(problem, problem.q, distance, settings, budget, deadline)
        search.go_to_nearest()
        if search.best is None:
            search.choose_goals(lambda q: _objective(problem.native, gains, q))
            search.go_straight()
            search.sample(QUICK_CHECKS)
        if search.best is not None:
            return _found(problem, search, 0, np.empty((0, problem.robot.n)), np.inf)
    given = problem
    # Where the safe velocity goes, and what is known of it, is about one choice.
    taken = given.nearest if search is None or not search.goals else search.choice_at(search.goals[0])
    problem = given.taking(taken)
    left = max(0.0, deadline - time.perf_counter())
    motion, found = _follow_safely(problem, gains, safety, replace(settings, max_planning_time=left))
    if found is not None:
        return replace(found, taken=taken)
    arrived = _has_arrived(problem, motion)
    if not arrived:
        faults = [_unreachable(given.taking(i), safety, settings, budget, deadline) for i in _order(given, taken)]
        if faults[0] is not None and None not in faults:
            return PathResult(*faults[0], motion.evaluations, taken=taken)
    first, distance, least = first_clear(problem.native, motion.q, distance)
    if search is None:
        search = _search(given, motion.q[first], distance, settings, budget, deadline)
    search.seeds = chain([motion.q[-1]], search.seeds)
    if arrived:
        search.arrive(QP, motion.q[first:])
    if not search.goals:
        search.choose_goals(lambda q: _objective(problem.native, gains, q), last=True)
        search.go_straight()
    search.sample()
    if search.best is not None:
        return _found(given, search, motion.evaluations, motion.q[:first], least)
    result = replace(_result(search, motion.evaluations), taken=taken)
    inside = [] if search.known else list(targets_inside(problem.tasks, problem.obstacles))
    return replace(result, reason="; ".join([result.reason, *inside]))


def _search(
    problem: Problem, start: Array, distance: float, settings: Settings, budget: Budget, deadline: float
) -> PathSearch:
    """Return a search from a configuration (n,) that keeps a distance in m."""
    return PathSearch(
        robot=problem.robot,
        checker=EdgeChecker(problem.robot, problem.obstacles, distance),
        sampler=Sampler(problem.robot, problem.obstacles, distance, deadline, problem.constraints),
        solver=InverseKinematics(problem.robot, problem.obstacles),
        choices=[(*tasks, *problem.constraints) for tasks in problem.choices],
        distance=distance,
        start=start,
        seeds=seeds(problem.robot, start, budget.random),
        random=budget.random,
        max_edge_checks=budget.max_edge_checks,
        deadline=deadline,
        time_option=settings.planning_time_option,
    )


def _found(problem: Problem, search: PathSearch, evaluations: int, beginning: Array, least: float) -> PathResult:
    """Return the path of a search, smoothed; `_smoothed` says what else is given."""
    path, checker = _smoothed(problem, search, beginning, least)
    return replace(
        _result(search, evaluations),
        status=Status.REACHED,
        reason="",
        path=path,
        checker=checker,
        found_by=search.found_by,
        taken=search.choice_at(path[-1]),
    )


def _order(problem: Problem, first: int) -> list[int]:
    """Return the numbers of the choices of a problem, a given one first."""
    return [first, *(i for i in range(len(problem.choices)) if i != first)]


def _has_arrived(problem: Problem, motion: Integration) -> bool:
    """Return whether a motion of the safe velocity, which turns no hand, does all tasks."""
    return motion.status is Status.REACHED and len(followed(problem.tasks)) == len(problem.tasks)


def _follow_safely(
    problem: Problem, gains: Gains, safety: Safety, settings: Settings
) -> tuple[Integration, PathResult | None]:
    """Return the motion of the safe velocity in long steps, and the result if no path has to be looked for."""
    tasks = followed(problem.tasks)
    # In whole steps, at least one.
    steps = max(1, int(STEP / gains.diagonal(count_rows(tasks)).max() / settings.dt))
    coarse = replace(settings, dt=steps * settings.dt)
    # It keeps as far away as a path has to, so that its motion is one.
    wider = replace(safety, safety_distance=safety.safety_distance + 2 * SPARE)
    began = time.perf_counter()
    motion = rollout(problem.native, problem.q, tasks, gains, wider, coarse, problem.constraints)
    if _has_arrived(problem, motion):
        stays = len(motion.q) == 1 and error_at(problem, motion.q[-1]) <= EXACT
        found = PathResult(Status.REACHED, motion.reason, motion.evaluations, motion.q, found_by=QP)
        return motion, found if stays else None
    # Nearer to things, it may still get there: then its motion is the plan, as it is.
    left = max(0.0, settings.max_planning_time - (time.perf_counter() - began))
    cut_off = replace(coarse, max_planning_time=left)
    nearer = rollout(problem.native, problem.q, tasks, gains, safety, cut_off, problem.constraints)
    if _has_arrived(problem, nearer):
        reason = "nothing but the safe velocity gets there without coming nearer to something"
        return motion, PathResult(Status.STUCK, reason, nearer.evaluations)
    return motion, None


def _unreachable(
    problem: Problem, safety: Safety, settings: Settings, budget: Budget, deadline: float
) -> tuple[Status, str] | None:
    """Return why no configuration does the tasks, whatever the path; None if one may."""
    robot, tasks = problem.robot, problem.tasks
    fault = blocked_target(robot, tasks, problem.obstacles, safety.safety_distance, settings.tolerance)
    if fault is not None:
        return Status.TARGET_IN_COLLISION, fault
    try:
        fault = out_of_reach(robot, tasks, problem.q, budget.random, settings.tolerance, deadline)
    except TimedOut:
        why = f"planning was cut off by {settings.planning_time_option} before the reach was known"
        return Status.PLANNING_TIMEOUT, why
    if fault is None and problem.constraints:
        fault = _contradiction(problem, budget.random)
    return None if fault is None else (Status.TARGET_OUT_OF_REACH, fault)


def _contradiction(problem: Problem, random: np.random.Generator) -> str | None:
    """Return that the constraints seem to hold nowhere at the targets; None if they do somewhere."""
    solver, tasks = InverseKinematics(problem.robot, ()), (*problem.tasks, *problem.constraints)
    starts = islice(seeds(problem.robot, problem.q, random), KEPT_STARTS)
    if any(solver.solve(start, tasks, -np.inf).reached for start in starts):
        return None
    kept = ", and ".join(map(name_of, problem.constraints))
    return f"the targets are in reach, but no configuration there was found that keeps {kept}"


def _result(search: PathSearch, evaluations: int) -> PathResult:
    """Return what is known of a search that may not have found a path."""
    return PathResult(
        Status.PLANNING_TIMEOUT if search.is_timed_out() else Status.STUCK,
        search.explain(),
        evaluations,
        raw=search.raw,
        goals=search.known,
        checks=search.checks,
        searches=search.searches,
        explored=None if search.best is not None else search.explored,
    )


def _smoothed(problem: Problem, search: PathSearch, beginning: Array, least: float) -> tuple[Array, EdgeChecker]:
    """Return the path with its corners rounded, and what checks the edges of a motion along it.

    Args:
        problem: The robot and its obstacles.
        search: The search that found the path.
        beginning: Configurations (K, n) that lead away from a start that is too near to something; often none.
        least: The least clearance of these, m.
    """
    robot, distance = problem.robot, search.distance
    assert search.best is not None
    loose = distance - min(SPARE / 2, LOOSE_SHARE * distance)
    checker = EdgeChecker(robot, problem.obstacles, loose, 1.0 - LOOSE_SHARE)
    if problem.constraints:
        path = np.vstack([beginning, search.best])
        return on_constraints(robot, problem.constraints, path, FINE), checker
    path = round_corners(robot, np.vstack([beginning, search.best]), checker.is_edge_valid)
    if len(beginning):
        # Corners are left there, where no more can be asked for.
        checker = EdgeChecker(robot, problem.obstacles, START_SHARE * least, START_SHARE)
        path = round_corners(robot, path, checker.is_edge_valid)
    return path, checker


def _objective(kinematics: NativeKinematics, gains: Gains, q: Array) -> float:
    """Return what the secondary objectives of eq. 4.8 climb: c_mu mu - c_kappa sum kappa(psi).

    Further objectives are velocities, which need not be gradients of anything, so they do not count here.
    """
    there = kinematics.measure(q, gains.epsilon)
    near = there.clearance[np.isfinite(there.clearance)]
    return gains.c_mu_of(kinematics.robot) * float(there.manipulability) - gains.c_kappa * float(
        penalty(near, gains.epsilon).sum()
    )
