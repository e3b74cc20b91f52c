"""A way to the targets whenever there is one: `method="auto"`.

1. The safe velocity of `safety.py` is followed first. Where it arrives, its path is a way.
2. Goals, configurations with the hands at their targets, are looked for by inverse kinematics from many starts. Of the
   nearest, those are kept that the secondary objectives of eq. 4.9 prefer.
3. Where the safe velocity did not arrive, RRT-Connect looks for ways to all of the goals at once (`sampling.py`), again
   and again with more checks and in a larger box: one long search fails more often than many short ones.
4. A way is made shorter, and others are tried while that may pay. The shortest one is rounded (`paths.py`).

Every straight piece of a way is proven to keep the safety distance (`validity.py`). Budgets are numbers of checks and
never seconds, so that a seed always gives the same plan; the time for planning only cuts it off.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.planning.engines import Engine
from humanoid_rail.search.goal_sampler import blocked_target, out_of_reach, seeds
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.kinematics.joint_limits import sampled
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.search.smoothing import round_corners, time_path
from humanoid_rail.resolution.velocity import Gains, penalty
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.search.rrt_connect import Validity
from humanoid_rail.kinematics.task import Task
from humanoid_rail.trajectory import Status
from humanoid_rail.search.path_search import QP, WaySearch

STEP = 0.05
"""How long the safe velocity is held, in time constants 1 / max(K): only its path matters."""
SPARE = 8e-4
"""How much more than the safety distance the corners of a way keep, so that there is room to round them, m."""
RESERVE = 0.03
"""The share of the time for planning that is left for what follows a search."""


@dataclass(frozen=True, eq=False)
class Way:
    """A way to the targets, or the reason why there is none."""

    status: Status
    reason: str
    evaluations: int
    """Of q_dot of the safe velocity."""
    path: Array | None = None
    """Configurations (K, n), m and rad; None if there is no way."""
    validity: Validity | None = None
    """What every straight piece of it holds by."""
    found_by: str = ""
    """`qp`, `straight line` or `rrt-connect`; empty if there is no way."""
    raw: Array | None = None
    """The first way of the sampling planner (K, n), as it was; None if that was not needed."""
    goals: int = 0
    """How many goals it had to choose from."""
    checks: int = 0
    """How many straight ways were checked."""
    searches: int = 0
    """How often the sampling planner was started."""


def find_way(
    task: Task,
    obstacles: tuple[Obstacle, ...],
    computing: Engine,
    kinematics: Any,
    start: Array,
    gains: Gains,
    safety: Safety,
    settings: Settings,
    random: np.random.Generator,
) -> Way:
    """Look for a way from a start to the targets among obstacles at rest.

    Args:
        task: The robot and its targets.
        obstacles: What it has to keep clear of.
        computing: The engine.
        kinematics: The robot among the obstacles, of that engine.
        start: Configuration (n,), m and rad, at which nothing touches.
        gains: Parameters of eq. 4.9.
        safety: Parameters of the constraints.
        settings: When a motion ends, and how long planning may take.
        random: For goals and ways.
    """
    robot, targets = task.robot, task.targets
    searching = (1.0 - RESERVE) * settings.max_planning_time
    deadline = time.perf_counter() + searching
    # In whole steps, at least one.
    steps = max(1, int(STEP / gains.diagonal(targets.size).max() / settings.dt))
    coarse = replace(settings, dt=steps * settings.dt, max_planning_time=searching)
    # It keeps as far away as a way has to, so that its path is one.
    wider = replace(safety, safety_distance=safety.safety_distance + 2 * SPARE)
    motion = computing.rollout(kinematics, start, targets, gains, wider, coarse)
    # It turns no hand.
    arrived = motion.status is Status.REACHED and not task.is_oriented
    if arrived and len(motion.q) == 1:
        return Way(Status.REACHED, motion.reason, motion.evaluations, motion.q, found_by=QP)
    if not arrived:
        # Nearer to things, it may still get there: then its motion is the plan, as it is.
        asked = computing.rollout(kinematics, start, targets, gains, safety, coarse)
        if asked.status is Status.REACHED and not task.is_oriented:
            reason = "nothing but the safe velocity gets there without coming nearer to something"
            return Way(Status.STUCK, reason, asked.evaluations)
        fault = blocked_target(robot, targets, obstacles, safety.safety_distance, settings.tolerance)
        if fault is not None:
            return Way(Status.TARGET_IN_COLLISION, fault, motion.evaluations)
        fault = out_of_reach(task, start, computing, random, settings.tolerance, deadline)
        if fault is not None:
            return Way(Status.TARGET_OUT_OF_REACH, fault, motion.evaluations)

    first, distance, least = _first_clear(kinematics, motion.q, safety.safety_distance + SPARE)
    validity = computing.validity(robot, obstacles, distance)
    points = task.points.ravel()
    solver, weights = computing.inverse_kinematics(task.posed, obstacles), np.ones(points.size)
    search = WaySearch(
        robot=robot,
        validity=validity,
        solve=lambda q: solver.solve(q, points, weights, distance),
        distance=distance,
        start=motion.q[first],
        seeds=chain([motion.q[-1]], seeds(robot, motion.q[first], random)),
        random=random,
        deadline=deadline,
    )
    if arrived:
        search.consider(QP, search.completed(motion.q[first:]))
    search.choose_goals(lambda q: _objective(kinematics, gains, q))
    search.go_straight()
    search.sample()
    way = Way(
        Status.STUCK,
        search.explain(settings.max_planning_time),
        motion.evaluations,
        raw=search.raw,
        goals=search.known,
        checks=search.checks,
        searches=search.searches,
    )
    if search.best is None:
        return way
    loose = computing.validity(robot, obstacles, distance - min(SPARE / 2, 0.05 * distance))
    path = round_corners(robot, np.vstack([motion.q[:first], search.best]), loose.holds_between)
    if first > 0:
        # Where it began too near, corners are left; there no more can be asked for.
        loose = computing.validity(robot, obstacles, 0.99 * least)
        path = round_corners(robot, path, loose.holds_between)
    left = float(np.linalg.norm(kinematics.measure(path[-1], 0.0).hands - targets))
    return replace(
        way, status=Status.REACHED, reason=f"|e| is {left:.2g} m", path=path, validity=loose, found_by=search.found_by
    )


def follow(robot: Robot, way: Way, settings: Settings) -> Integration:
    """Return the motion along a way, sampled: as fast as the speed limits let it, slower where it turns."""
    assert way.path is not None
    status, reason = way.status, way.reason
    t, q = time_path(robot, way.path, settings.dt, way.validity.holds_between if way.validity else None)
    if t[-1] > settings.max_time:
        status = Status.TIME_LIMIT
        reason = f"the way that was found takes {t[-1]:.4g} s, longer than {settings.max_time:g} s"
        t, q = t[t <= settings.max_time], q[t <= settings.max_time]
    else:
        reason += f" at t = {t[-1]:.4g} s"
    return Integration(t, q, status, reason, way.evaluations, sampled(t, q))


def go_as_far_as_qp(way: Way, motion: Integration) -> Integration:
    """Return what the safe velocity does where no way was found, with the reason for that.

    Args:
        way: What became of the search.
        motion: What the safe velocity does in steps of dt; where it arrives, that is the plan.
    """
    if motion.status is Status.REACHED:
        return motion
    return replace(motion, status=way.status, reason=f"{way.reason}; as far as qp gets, {motion.reason.split(':')[0]}")


def _first_clear(kinematics: Any, motion: Array, distance: float) -> tuple[int, float, float]:
    """Return where a motion (N, n) first keeps a distance in m from everything, that distance, and the least before.

    A start that is nearer to something is led away by the safe velocity. Where it never gets so far, the place where it
    is farthest, and a little less than how far that is.
    """
    farthest, place, least = -np.inf, 0, np.inf
    for i, q in enumerate(motion):
        there = kinematics.measure(q, 0.0)
        clearance = float(min(there.clearance.min(initial=np.inf), there.self_clearance.min(initial=np.inf)))
        if clearance >= distance:
            return i, distance, least
        least = min(least, clearance)
        if clearance > farthest:
            farthest, place = clearance, i
    return place, max(0.95 * farthest, min(farthest, distance - SPARE)), least


def _objective(kinematics: Any, gains: Gains, q: Array) -> float:
    """Return what the secondary objectives of eq. 4.8 climb: c_mu mu - c_kappa sum kappa(psi)."""
    there = kinematics.measure(q, gains.epsilon)
    near = there.clearance[np.isfinite(there.clearance)]
    return gains.c_mu * float(there.manipulability) - gains.c_kappa * float(penalty(near, gains.epsilon).sum())
