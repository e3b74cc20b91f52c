"""The motions of `auto` that reach their targets, made motions of least time that a drive can follow."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certifier import certify
from humanoid_rail.errors import told_apart
from humanoid_rail.kinematics.joint_limits import sampled
from humanoid_rail.model.robot import Robot
from humanoid_rail.optimisation.motion import Found, least_time_motion, movable
from humanoid_rail.planning.kept import KeptLimits, kept_motion
from humanoid_rail.planning.options import Planned
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.result import Optimisation, Status
from humanoid_rail.search.exact_end import error_at, error_left
from humanoid_rail.timing.timed_motion import TimedMotion


def with_least_time(
    planned: Planned,
    problem: Problem,
    safety_distance: float,
    kept: KeptLimits,
    max_steps: int,
    settings: Settings,
    deadline: float,
) -> Planned:
    """Return a planned motion with a timing that a drive can follow, in the least time that is found.

    One that does not reach its targets, or cannot be timed, stays as it is.

    Args:
        planned: The motion, among obstacles at rest.
        problem: What it was planned for.
        safety_distance: The distance that pairs keep, m.
        kept: How far the motion may leave what it keeps.
        max_steps: The most quadratic programs to solve.
        settings: How far apart samples are, how long the motion may take, and the tolerance.
        deadline: When planning is cut off, on the clock of `time.perf_counter`, s.
    """
    motion = planned.motion
    if motion.status is not Status.REACHED:
        return planned
    reason = _unfit(problem.robot, motion.q)
    if reason is None and time.perf_counter() > deadline:
        reason = f"planning was cut off by {settings.planning_time_option}"
    if reason is not None:
        return replace(planned, optimisation=Optimisation(0, 0, reason))
    if problem.constraints and len(motion.t) > 1:
        found = Found(kept_motion(problem, motion.t, motion.q, settings.dt, safety_distance, kept), False, 0)
    else:
        found = _found(problem, motion, settings.dt, safety_distance, max_steps, deadline)
    timed, duration = found.motion, found.motion.duration
    left = error_at(problem, timed.q[-1], duration)
    if left > settings.tolerance:
        reason = f"|e| would be {left:.3g} m at t = {duration:.4g} s, as tasks depend on time"
        return replace(planned, optimisation=Optimisation(found.steps, 0, reason))
    if duration > settings.max_time:
        return _cut(planned, found, settings)
    reached = Integration(
        timed.t,
        timed.q,
        motion.status,
        f"{error_left(left, settings.tolerance)} at t = {duration:.4g} s",
        motion.evaluations,
        sampled(timed.t, timed.q),
    )
    done = Optimisation(found.steps, int(found.is_optimised))
    return replace(planned, motion=reached, timed=timed, optimisation=done)


def _found(
    problem: Problem, motion: Integration, dt: float, safety_distance: float, max_steps: int, deadline: float
) -> Found:
    if len(motion.t) > 1:
        return least_time_motion(problem, motion.t, motion.q, dt, safety_distance, max_steps, deadline)
    began, still = time.perf_counter(), np.zeros_like(motion.q)
    certificate = certify(problem.robot, problem.obstacles, motion.t, motion.q)
    there = TimedMotion(motion.t, motion.q, still, still, [0], certificate, time.perf_counter() - began)
    return Found(there, False, 0)


def _unfit(robot: Robot, q: Array) -> str | None:
    """Return why a motion (N, n) cannot be timed; None if it can."""
    missing = (np.ptp(q, axis=0) > 0.0) & ~movable(robot)
    names = [name for name, lacks in zip(robot.joint_names, missing, strict=True) if lacks]
    return f"these joints have no acceleration limit: {', '.join(names)}" if names else None


def _cut(planned: Planned, found: Found, settings: Settings) -> Planned:
    """Return the motion as far as it gets in time; it would not come to rest there, so it keeps its own timing."""
    motion = planned.motion
    taken = told_apart(found.motion.duration, settings.max_time, 4)
    reason = f"the motion that was found takes {taken} s, longer than what {settings.time_option} leaves"
    kept = motion.t <= settings.max_time
    t, q = motion.t[kept], motion.q[kept]
    cut = Integration(t, q, Status.TIME_LIMIT, reason, motion.evaluations, sampled(t, q))
    return replace(planned, motion=cut, optimisation=Optimisation(found.steps, 0, "it takes too long"))
