"""Motions of least time that pass the targets of some steps without stopping.

They begin with the path of a motion that stops there. A spline along it is shortened (`least_time.py`) with waypoints
at these targets. It is brought exactly onto them, and certified; the motion has samples there.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.path_metric import STANDSTILL, path_length
from humanoid_rail.optimisation.least_time import Surroundings, shorten, surroundings
from humanoid_rail.optimisation.motion import FINER, LONGEST_STEP, LOOKS, SPARE, movable, repaired, seed
from humanoid_rail.optimisation.spline import weights
from humanoid_rail.optimisation.waypoints import Waypoint, errors_at, onto_waypoints, spread
from humanoid_rail.problem import Problem
from humanoid_rail.search.exact_end import EXACT
from humanoid_rail.timing.time_optimal import limits_of
from humanoid_rail.timing.timed_motion import TimedMotion

CLOSE = 32
"""The moments at which a seed passes waypoints are looked for at so many in each interval."""


class Passing(NamedTuple):
    """A motion that passes targets, or why there is none."""

    motion: TimedMotion | None
    passed: list[int]
    """The samples at which it is at the targets of each step but the last."""
    steps: int
    """How many programs were solved."""
    reason: str = ""
    """Why there is no motion."""


def passing_motion(
    problems: Sequence[Problem],
    paths: Sequence[Array],
    dt: float,
    safety_distance: float,
    max_steps: int,
    deadline: float,
) -> Passing:
    """Return a motion of least time to the tasks of problems in turn, at rest only at both ends.

    Args:
        problems: One for each step; obstacles are at rest.
        paths: Configurations (N, n) along which a motion reaches the tasks of each, m and rad. Each begins where the
            one before ends; joints that move have limits to be timed by.
        dt: The most time between samples, s.
        safety_distance: What pairs keep, m.
        max_steps: The most programs to solve.
        deadline: When it is cut off, on the clock of `time.perf_counter`, s.
    """
    first, last = problems[0], problems[-1]
    robot, moving = last.robot, movable(last.robot)
    if max_steps == 0:
        return Passing(None, [], 0, "no step of optimisation is allowed (max_optimisation_steps)")
    if not (moving | (robot.velocity_limit == 0.0)).all():
        return Passing(None, [], 0, "some joints that can move have no acceleration limit")
    limits = limits_of(robot)
    degree = 3 if np.isfinite(limits.jerk[moving]).any() else 2
    path = np.vstack(paths)
    if path_length(robot, path) <= STANDSTILL:
        return Passing(None, [], 0, "nothing moves")
    around = replace(
        surroundings(replace(last, start=first.start), limits[:degree], moving, safety_distance + SPARE, paths[-1][-1]),
        waypoints=tuple(
            Waypoint(problem.tasks, InverseKinematics(problem.robot, problem.obstacles)) for problem in problems[:-1]
        ),
    )
    stops = np.array([path[-1] for path in paths[:-1]])
    if errors_at(around, stops).max() > EXACT:
        return Passing(None, [], 0, "only the tolerance can be reached")
    dt /= np.ceil(dt / LONGEST_STEP)
    return _found(around, path, stops, dt, max_steps, deadline)


def _found(around: Surroundings, path: Array, stops: Array, dt: float, max_steps: int, deadline: float) -> Passing:
    """Return a motion along a path (N, n) that passes waypoints where it would else stop (P, n)."""
    steps, reason = 0, ""
    for finer in FINER:
        if time.perf_counter() > deadline:
            return Passing(None, [], steps, "planning was cut off")
        control = seed(around, path, finer)
        intervals = len(control) - around.degree
        moments = _moments(around, control, stops)
        if moments is None:
            reason = "there are too many for so short a motion"
            continue
        started = onto_waypoints(around, control, weights(around.degree, intervals, moments))
        if started is None:
            reason = "no spline near the path is at all of them"
            continue
        times = np.arange(intervals * LOOKS + 1) / LOOKS
        course = shorten(around, started, times, max_steps, deadline, taken=steps, moments=moments)
        found = repaired(around, course, times, dt, deadline)
        steps = found.steps
        if found.motion is not None and errors_at(around, found.motion.q[found.passed]).max() <= EXACT:
            return Passing(found.motion, found.passed, steps)
        reason = "no motion that is exactly at all of them could be certified"
    return Passing(None, [], steps, reason)


def _moments(around: Surroundings, control: Array, stops: Array) -> Array | None:
    """Return when a spline passes configurations (P, n) in turn, in intervals (P,); None if they are too many."""
    degree, intervals = around.degree, len(control) - around.degree
    times = np.arange(intervals * CLOSE + 1) / CLOSE
    points = weights(degree, intervals, times) @ control
    away = np.linalg.norm(points[None] - around.points(stops)[:, None], axis=2)
    return spread(times[_in_turn(away)], degree, intervals)


def _in_turn(away: Array) -> Array:
    """Return which columns (P,) of distances (P, S), not decreasing, have the least sum of squares."""
    total, before = np.zeros(away.shape[1]), []
    for row in away:
        # The best of all up to each column.
        best = np.minimum.accumulate(total)
        before.append(np.maximum.accumulate(np.where(total <= best, np.arange(total.size), 0)))
        total = best + row**2
    column, chosen = int(total.argmin()), []
    for origin in reversed(before):
        chosen.append(column)
        column = int(origin[column])
    return np.array(chosen[::-1])
