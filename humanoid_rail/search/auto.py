"""Global planning where the local method gets stuck: the method `auto`.

1. The safe velocity of `resolution/qp.py` is followed first. Where it arrives, it gives a path.
2. Goals, configurations in which the tasks are done, are looked for by inverse kinematics from many starts. Of the
   nearest, those are kept that the secondary objectives of eq. 4.9 prefer.
3. Where the safe velocity did not arrive, RRT-Connect looks for paths to all of the goals at once (`rrt_connect.py`),
   again and again with more checks and in a larger box: one long search fails more often than many short ones.
4. The path is shortened, and others are tried while that may pay. The shortest one is smoothed (`smoothing.py`).

Every edge that is sampled, shortened or rounded is proven to keep the safety distance (`collision/edge_checker.py`).
The steps of the safe velocity are proven free of contact, and keep the distance where they end.

Budgets are numbers of edge checks, never seconds: a seed gives the same plan. `max_planning_time` cuts planning off.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.errors import told_apart
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.joint_limits import sampled
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.task_stack import count_rows
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.rollout import rollout
from humanoid_rail.resolution.velocity import Gains, penalty
from humanoid_rail.result import Status
from humanoid_rail.search.blocked_targets import blocked_target, targets_inside
from humanoid_rail.search.exact_end import EXACT, error_at, error_left
from humanoid_rail.search.goal_sampler import seeds
from humanoid_rail.search.path_search import QP, PathSearch
from humanoid_rail.search.reachability import TimedOut, followed, out_of_reach
from humanoid_rail.search.smoothing import round_corners, time_path

STEP = 0.05
"""The safe velocity is held for this long, in time constants 1 / max(K): only its path matters."""
SPARE = 8e-4
"""The corners of a path keep this much more than the safety distance, so that there is room to round them, m."""
RESERVE = 0.03
"""This share of `max_planning_time` is left for what follows a search."""
LOOSE_SHARE = 0.05
"""Smoothing may take at most this share of the distance that a path keeps."""
RETREAT_SHARE = 0.95
"""A path that begins too near to something keeps this share of the largest clearance of its beginning."""
START_SHARE = 0.99
"""The part of a path that begins too near to something keeps this share of its own least clearance."""


@dataclass(frozen=True)
class Budget:
    """How much may be spent on a search."""

    max_edge_checks: int
    """The most edges to check; what is found depends on it."""
    random: np.random.Generator
    """The random numbers of goals and paths."""


@dataclass(frozen=True, eq=False)
class PathResult:
    """A path to the targets, or the reason why there is none."""

    status: Status
    reason: str
    evaluations: int
    """Number of evaluations of q_dot of the safe velocity."""
    path: Array | None = None
    """Configurations (K, n), m and rad; None if there is no path."""
    checker: EdgeChecker | None = None
    """Checks the edges of a motion along the path."""
    found_by: str = ""
    """`qp`, `straight line` or `rrt-connect`; empty if there is no path."""
    raw: Array | None = None
    """The first path of the sampling planner (K, n), as it was; None if that was not needed."""
    goals: int = 0
    """The number of goals to choose from."""
    checks: int = 0
    """The number of edges that were checked."""
    searches: int = 0
    """The number of times the sampling planner was started."""
    explored: Array | None = None
    """Configurations (K, n) to which the last sampling has paths from the start; None where a path was found."""


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
    kinematics = problem.native
    searching = (1.0 - RESERVE) * settings.max_planning_time
    deadline = time.perf_counter() + searching
    motion, found = _follow_safely(problem, gains, safety, replace(settings, max_planning_time=searching))
    if found is not None:
        return found
    arrived = _has_arrived(problem, motion)
    if not arrived:
        fault = _unreachable(problem, safety, settings, budget, deadline)
        if fault is not None:
            return PathResult(*fault, motion.evaluations)
    first, distance, least = _first_clear(kinematics, motion.q, safety.safety_distance + SPARE)
    solver = InverseKinematics(problem.robot, problem.obstacles)
    search = PathSearch(
        robot=problem.robot,
        checker=EdgeChecker(problem.robot, problem.obstacles, distance),
        solve=lambda q: solver.solve(q, problem.tasks, distance),
        distance=distance,
        start=motion.q[first],
        seeds=chain([motion.q[-1]], seeds(problem.robot, motion.q[first], budget.random)),
        random=budget.random,
        max_edge_checks=budget.max_edge_checks,
        deadline=deadline,
        time_option=settings.planning_time_option,
    )
    if arrived:
        search.arrive(QP, motion.q[first:])
    search.choose_goals(lambda q: _objective(kinematics, gains, q))
    search.go_straight()
    search.sample()
    result = _result(search, motion.evaluations)
    if search.best is None:
        inside = [] if search.known else list(targets_inside(problem.tasks, problem.obstacles))
        return replace(result, reason="; ".join([result.reason, *inside]))
    path, checker = _smoothed(problem, search, motion.q[:first], least)
    return replace(result, status=Status.REACHED, reason="", path=path, checker=checker, found_by=search.found_by)


def follow(problem: Problem, found: PathResult, settings: Settings) -> Integration:
    """Return the motion along a path, sampled: as fast as the speed limits allow, slower where it turns."""
    assert found.path is not None
    status, reason = found.status, found.reason
    t, q = time_path(
        problem.robot, found.path, settings.dt, found.checker.is_edge_valid if found.checker is not None else None
    )
    if t[-1] > settings.max_time:
        status = Status.TIME_LIMIT
        taken = told_apart(float(t[-1]), settings.max_time, 4)
        reason = f"the path that was found takes {taken} s, longer than what {settings.time_option} leaves"
        t, q = t[t <= settings.max_time], q[t <= settings.max_time]
    elif (left := error_at(problem, q[-1], float(t[-1]))) > settings.tolerance:
        status = Status.STUCK
        reason = f"|e| is {left:.3g} m at {settings.at(t[-1])}: goals are looked for at t = 0, and tasks depend on time"
    else:
        reason = f"{reason or error_left(left, settings.tolerance)} at {settings.at(t[-1])}"
    return Integration(t, q, status, reason, found.evaluations, sampled(t, q))


def as_far_as_qp(found: PathResult, motion: Integration, settings: Settings) -> Integration:
    """Return the motion of the safe velocity where no path was found, with the reason for that.

    Args:
        found: What became of the search.
        motion: What the safe velocity does in steps of dt; where it arrives, that is the plan.
        settings: When it begins.
    """
    if motion.status is Status.REACHED:
        return motion
    reason = f"{found.reason}; the motion is as far as qp gets, until {settings.at(motion.t[-1])}"
    return replace(motion, status=found.status, reason=reason)


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
    motion = rollout(problem.native, problem.q, tasks, gains, wider, coarse)
    if _has_arrived(problem, motion):
        stays = len(motion.q) == 1 and error_at(problem, motion.q[-1]) <= EXACT
        found = PathResult(Status.REACHED, motion.reason, motion.evaluations, motion.q, found_by=QP)
        return motion, found if stays else None
    # Nearer to things, it may still get there: then its motion is the plan, as it is.
    left = max(0.0, settings.max_planning_time - (time.perf_counter() - began))
    nearer = rollout(problem.native, problem.q, tasks, gains, safety, replace(coarse, max_planning_time=left))
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
    return None if fault is None else (Status.TARGET_OUT_OF_REACH, fault)


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
    path = round_corners(robot, np.vstack([beginning, search.best]), checker.is_edge_valid)
    if len(beginning):
        # Corners are left there, where no more can be asked for.
        checker = EdgeChecker(robot, problem.obstacles, START_SHARE * least, START_SHARE)
        path = round_corners(robot, path, checker.is_edge_valid)
    return path, checker


def _first_clear(kinematics: NativeKinematics, motion: Array, distance: float) -> tuple[int, float, float]:
    """Return where a motion (N, n) first keeps a distance in m from everything, that distance, and the least before.

    A start that is nearer to something is led away by the safe velocity. Where it never gets so far, the place where it
    is farthest is returned, and a little less than how far that is.
    """
    clearances: list[float] = []
    own = own_distances(kinematics.robot)
    for q in motion:
        there = kinematics.measure(q, 0.0)
        # Links that are as far apart as they themselves have to be do not hold up the others.
        lacking = there.self_clearance[there.self_clearance < own]
        clearance = float(min(there.clearance.min(initial=np.inf), lacking.min(initial=np.inf)))
        if clearance >= distance:
            return len(clearances), distance, min(clearances, default=np.inf)
        clearances.append(clearance)
    place = int(np.argmax(clearances))
    kept = max(RETREAT_SHARE * clearances[place], min(clearances[place], distance - SPARE))
    return place, kept, min(clearances[:place], default=np.inf)


def _objective(kinematics: NativeKinematics, gains: Gains, q: Array) -> float:
    """Return what the secondary objectives of eq. 4.8 climb: c_mu mu - c_kappa sum kappa(psi).

    Further objectives are velocities, which need not be gradients of anything, so they do not count here.
    """
    there = kinematics.measure(q, gains.epsilon)
    near = there.clearance[np.isfinite(there.clearance)]
    return gains.c_mu_of(kinematics.robot) * float(there.manipulability) - gains.c_kappa * float(
        penalty(near, gains.epsilon).sum()
    )
