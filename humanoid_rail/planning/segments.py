"""The legs of a motion: each by the method that was asked for, from where the one before ended to the next targets."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.planning.engines import Engine
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.kinematics.joint_limits import Motion
from humanoid_rail.scene.obstacles import at_rest, moved
from humanoid_rail.search.smoothing import path_quality
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.search.effort import PathQuality, Search
from humanoid_rail.kinematics.task import Task, rows_of
from humanoid_rail.trajectory import Status
from humanoid_rail.search.auto import find_way, follow, go_as_far_as_qp


@dataclass(frozen=True, eq=False)
class Leg:
    """A motion to the targets of one step, or as far as it got."""

    motion: Integration
    """Its times begin at 0."""
    found_by: str
    """What found its path; empty if nothing did."""
    search: Search | None
    """What `auto` did to find it."""


@dataclass(frozen=True, eq=False)
class Journey:
    """Legs, one after the other."""

    motion: Integration
    found_by: str
    search: Search | None
    path: PathQuality
    arrivals: tuple[float, ...]
    """When each leg that reached its targets ends, s."""


def travel_legs(
    kinematics: Any,
    tasks: Iterable[Task],
    method: str,
    computing: Engine,
    start: Array,
    gains: Gains,
    safety: Safety,
    settings: Settings,
    seed: int,
) -> Journey:
    """Plan leg after leg until one does not reach its targets.

    Args:
        kinematics: The robot with all its hands among the obstacles where they are at t = 0, of the engine.
        tasks: What each leg has to reach.
        method: How a leg is planned; see :func:`humanoid_rail.plan`.
        computing: The engine.
        start: Configuration (n,), m and rad.
        gains: Parameters of eq. 4.9, for all hands.
        safety: Parameters of the constraints.
        settings: When the whole motion ends, and how long planning may take in all.
        seed: Of the random numbers.
    """
    robot, obstacles = kinematics.robot, kinematics.obstacles
    deadline = time.perf_counter() + settings.max_planning_time
    still = at_rest(obstacles)
    tasks, legs, begun = tuple(tasks), list[Leg](), 0.0
    for number, task in enumerate(tasks):
        left = replace(
            settings,
            max_time=settings.max_time - begun,
            max_planning_time=max(deadline - time.perf_counter(), 0.0),
        )
        if left.max_time <= 0:
            reason = f"the longest motion allowed, {settings.max_time:g} s, is over"
            legs.append(Leg(_standstill(start, Status.TIME_LIMIT, reason), "", None))
            break
        there = kinematics
        if task.robot is not robot or (begun and not still):
            there = computing.kinematics(task.robot, tuple(moved(obstacle, begun) for obstacle in obstacles))
        weights = gains
        if task.robot is not robot:
            weights = replace(gains, gain=gains.diagonal(3 * len(robot.hands))[rows_of(robot, task)])
        seeds = seed if number == 0 else (seed, number)
        if method == "auto" and still:
            legs.append(_find_leg(task, there, computing, start, weights, safety, left, seed, seeds))
        else:
            legs.append(_follow_velocity(task, there, method, computing, start, weights, safety, left))
        start, begun = legs[-1].motion.q[-1], begun + float(legs[-1].motion.t[-1])
        if legs[-1].motion.status is not Status.REACHED:
            break
    return _join(robot, legs, len(tasks))


def _follow_velocity(
    task: Task,
    kinematics: Any,
    method: str,
    computing: Engine,
    start: Array,
    gains: Gains,
    safety: Safety,
    settings: Settings,
) -> Leg:
    """Follow the velocity of eq. 4.9, or the safe one."""
    if method == "gradient-projection":
        motion = computing.integrate(kinematics, start, task.targets, gains, settings)
    else:
        motion = computing.rollout(kinematics, start, task.targets, gains, safety, settings)
    found_by = ("qp" if method == "auto" else method) if motion.status is Status.REACHED else ""
    return Leg(motion, found_by, None)


def _find_leg(
    task: Task,
    kinematics: Any,
    computing: Engine,
    start: Array,
    gains: Gains,
    safety: Safety,
    settings: Settings,
    seed: int,
    seeds: int | Sequence[int],
) -> Leg:
    """Look for a way among obstacles at rest."""
    started = time.perf_counter()
    random = np.random.default_rng(seeds)
    way = find_way(task, kinematics.obstacles, computing, kinematics, start, gains, safety, settings, random)
    raw = None if way.raw is None else path_quality(task.robot, way.raw)
    search = Search(seed, way.goals, way.searches, way.checks, raw)
    if way.path is not None:
        return Leg(follow(task.robot, way, settings), way.found_by, search)
    # What is left of the time, which is little where that is why there is no way.
    spent = time.perf_counter() - started
    rest = replace(settings, max_planning_time=max(settings.max_planning_time - spent, 0.0))
    motion = go_as_far_as_qp(way, computing.rollout(kinematics, start, task.targets, gains, safety, rest))
    if task.is_oriented and motion.status is Status.REACHED:
        # It turns no hand.
        motion = replace(motion, status=way.status, reason=f"{way.reason}; qp reaches the points alone")
    return Leg(motion, "qp" if motion.status is Status.REACHED else "", search)


def arrival(times: Sequence[float]) -> str:
    """Return the reason of a motion that reaches the targets of each step, at times in s."""
    return f"at the targets at t = {', '.join(f'{t:.4g}' for t in times)} s"


def _standstill(q: Array, status: Status, reason: str) -> Integration:
    visited = Motion(np.zeros(1), q[None, :], np.zeros((1, q.size)))
    return Integration(np.zeros(1), q[None, :], status, reason, 0, visited)


def _join(robot: Robot, legs: Sequence[Leg], count: int) -> Journey:
    """Return legs as one, of as many as there should be."""
    motions = [leg.motion for leg in legs]
    ends = np.cumsum([motion.t[-1] for motion in motions]).tolist()
    return Journey(
        motion=motions[0] if count == 1 else _joined_motion(motions, ends, count),
        found_by=", ".join(dict.fromkeys(leg.found_by for leg in legs if leg.found_by)),
        path=path_quality(robot, *(motion.q for motion in motions)),
        search=_joined_search([leg.search for leg in legs if leg.search is not None]),
        arrivals=tuple(end for motion, end in zip(motions, ends, strict=True) if motion.status is Status.REACHED),
    )


def _joined_motion(motions: Sequence[Integration], ends: Sequence[float], count: int) -> Integration:
    """Return motions that end at times in s as one."""
    last, begins = motions[-1], [0.0, *ends[:-1]]
    if len(motions) == count and last.status is Status.REACHED:
        reason = arrival(ends)
    else:
        reason = f"step {len(motions)} of {count}, begun at t = {begins[-1]:.4g} s: {last.reason}"
    visits = [motion.visited for motion in motions]
    return Integration(
        # Where a leg begins is where the one before ended.
        t=np.concatenate([motion.t[k > 0 :] + begins[k] for k, motion in enumerate(motions)]),
        q=np.vstack([motion.q[k > 0 :] for k, motion in enumerate(motions)]),
        status=last.status,
        reason=reason,
        evaluations=sum(motion.evaluations for motion in motions),
        visited=Motion(
            np.concatenate([visit.t + begin for visit, begin in zip(visits, begins, strict=True)]),
            np.vstack([visit.q for visit in visits]),
            np.vstack([visit.velocity for visit in visits]),
        ),
    )


def _joined_search(searches: Sequence[Search]) -> Search | None:
    """Return several searches as one."""
    if not searches:
        return None
    raws = [search.raw for search in searches if search.raw is not None]
    # Lengths are comparable if they are of all legs.
    complete = len(raws) == len(searches)
    return Search(
        seed=searches[0].seed,
        goals=sum(search.goals for search in searches),
        searches=sum(search.searches for search in searches),
        checks=sum(search.checks for search in searches),
        raw=PathQuality(sum(raw.length for raw in raws), max(raw.sharpest_turn for raw in raws)) if complete else None,
    )
