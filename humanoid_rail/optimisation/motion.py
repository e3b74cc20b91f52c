"""Motions of least time to the tasks of a problem, certified, and never longer than along the path that was found.

1. A spline along the path (`seed.py`) is shortened (`least_time.py`), its goal with it.
2. It becomes a cubic spline with continuous accelerations, and is certified. Where it comes too near to something
   between the moments that were looked at, it is looked at more closely there and repaired.
3. Unless it is shorter than any motion along the path can be, such a motion (`timing/`) is compared with it.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certifier import bound_resolution, certify
from humanoid_rail.kinematics.path_metric import STANDSTILL, path_length
from humanoid_rail.model.robot import Robot
from humanoid_rail.optimisation.least_time import (
    Course,
    Surroundings,
    lacking_at,
    on_tasks,
    shorten,
    surroundings,
)
from humanoid_rail.optimisation.seed import along
from humanoid_rail.optimisation.spline import as_cubic, knots, refined
from humanoid_rail.optimisation.waypoints import exactly_at_waypoints
from humanoid_rail.problem import Problem
from humanoid_rail.timing.lower_bound import least_duration_along
from humanoid_rail.timing.time_optimal import Limits, limits_of
from humanoid_rail.timing.timed_motion import (
    CUT,
    DEVIATION,
    TimedMotion,
    along_path,
    certified_motion,
    wanted_bound,
)

SPARE = 3e-4
"""Pairs keep this much more than the safety distance at the moments that are looked at, m."""
INTERVAL = 0.15
"""Knots are about this far apart, s, ..."""
FEWEST, MOST = 10, 16
"""... but there are so many intervals between them, ..."""
FEWEST_MORE = 3
"""... and at least so many more for each waypoint; at most as many times more as there are waypoints."""
FINER = (1, 2)
"""A spline that finds no way out of an obstacle begins again, with so many times as many intervals: it cuts the path's
curves less."""
LOST = 0.01
"""It does not find one if it lacks more than this, m."""
LOOKS, CLOSE_LOOKS = 8, 32
"""Each interval is looked at this often, and where something is lacking this often."""
REPAIRS = 3
"""A spline is repaired at most so often."""
REPAIR_STEPS = 3
"""By at most so many steps each, from one stop or waypoint to the next."""
REPAIR_TRUST = 0.05
"""The first step of a repair moves control points at most this far, s."""
LONGEST_STEP = 0.02
"""Samples are at most this far apart, however far they may be, s: over as long accelerations set in."""


class Found(NamedTuple):
    """A motion with a timing, and how it came about."""

    motion: TimedMotion
    is_optimised: bool
    """Whether it is the optimised one; if not, it follows the path."""
    steps: int
    """How many programs were solved."""


def movable(robot: Robot) -> NDArray[np.bool_]:
    """Return which joints (n,) the optimisation can move: those with limits to be timed by."""
    moving: NDArray[np.bool_] = (robot.velocity_limit > 0.0) & np.isfinite(robot.acceleration_limit)
    return moving & (robot.acceleration_limit > 0.0)


def least_time_motion(
    problem: Problem, t: Array, path: Array, dt: float, safety_distance: float, max_steps: int, deadline: float
) -> Found:
    """Return the shortest motion that is found to the tasks of a problem, at rest at both ends.

    Args:
        problem: The robot, its tasks and the start; obstacles are at rest.
        t: Times (N,) of the path that was found, s; it is linear between them.
        path: Its configurations (N, n), m and rad. Joints that move along it have limits to be timed by.
        dt: The most time between samples, s.
        safety_distance: What pairs keep, m.
        max_steps: The most programs to solve.
        deadline: When it is cut off, on the clock of `time.perf_counter`, s.
    """
    robot = problem.robot
    limits = limits_of(robot)
    dt /= np.ceil(dt / LONGEST_STEP)
    motion, steps = _optimised(problem, path, limits, dt, safety_distance, max_steps, deadline)
    stray = (DEVIATION + CUT) * robot.speed_units
    if motion is not None and motion.duration <= least_duration_along(path, *limits[:2], stray):
        return Found(motion, True, steps)
    wanted = wanted_bound(certify(robot, problem.obstacles, t, path), safety_distance)
    plain = along_path(robot, problem.obstacles, [path], limits, dt, 0.0, wanted)
    if motion is not None and motion.duration <= plain.duration:
        return Found(motion, True, steps)
    return Found(plain, False, steps)


def _optimised(
    problem: Problem, path: Array, limits: Limits, dt: float, distance: float, max_steps: int, deadline: float
) -> tuple[TimedMotion | None, int]:
    """Return an optimised motion that keeps a distance in m, None if there is none, and the steps taken for it."""
    robot, moving = problem.robot, movable(problem.robot)
    if max_steps == 0 or path_length(robot, path) <= STANDSTILL:
        return None, 0
    degree = 3 if np.isfinite(limits.jerk[moving]).any() else 2
    around = surroundings(problem, limits[:degree], moving, distance + SPARE, path[-1])
    steps = 0
    for finer in FINER:
        control = seed(around, path, finer)
        times = np.arange((len(control) - degree) * LOOKS + 1) / LOOKS
        course = shorten(around, control, times, max_steps, deadline, taken=steps)
        motion, _, steps = repaired(around, course, times, dt, deadline)
        if motion is not None or time.perf_counter() > deadline:
            return motion, steps
    return None, steps


class Repaired(NamedTuple):
    """The motion of a spline, if there is one."""

    motion: TimedMotion | None
    passed: list[int]
    """The samples at which it is at its waypoints."""
    steps: int
    """How many programs were solved."""


def repaired(around: Surroundings, course: Course, times: Array, dt: float, deadline: float) -> Repaired:
    """Return the motion of a spline, repaired where it comes too near to something; none if that fails.

    Args:
        around: What it is shortened within.
        course: The spline.
        times: Moments at which it was looked at, in intervals (S,).
        dt: The most time between samples, s.
        deadline: When it is cut off, on the clock of `time.perf_counter`, s.
    """
    distance = around.distance - SPARE
    if course.lacking > LOST:
        return Repaired(None, [], course.steps)
    for repair in range(REPAIRS + 1):
        ended = on_tasks(around, course.control, distance, course.moments)
        exact = None if ended is None else exactly_at_waypoints(around, ended, course.moments, dt)
        if exact is None:
            break
        motion, passed = _as_motion(around, exact.control, dt, exact.places)
        if motion.bound >= distance - bound_resolution():
            return Repaired(motion, passed, course.steps)
        if repair == REPAIRS or time.perf_counter() > deadline:
            break
        if around.waypoints:
            course = course._replace(control=exact.control)
        times, is_lacking = _closer(around, course, times, len(course.control) - around.degree)
        if not is_lacking:
            break
        steps = REPAIR_STEPS * (1 + len(around.waypoints))
        course = shorten(around, course.control, times, steps, deadline, REPAIR_TRUST, course.steps, course.moments)
    return Repaired(None, [], course.steps)


def seed(around: Surroundings, path: Array, finer: int) -> Array:
    """Return control points (M + d, m) along a path (N, n), so many times closer than they mostly are."""
    points = around.points(path)
    # Limits of speed are 1 in these units, where there are any.
    rise = float((1.0 / around.limits[1])[np.ptp(points, axis=0) > 0.0].max())
    duration = float(abs(np.diff(points, axis=0)).max(axis=1).sum()) + rise
    passed = len(around.waypoints)
    fewest, most = FEWEST + FEWEST_MORE * passed, MOST * (1 + passed)
    intervals = finer * int(np.clip(np.ceil(duration / INTERVAL), fewest, most))
    return along(points, rise, around.degree, intervals)


def _closer(around: Surroundings, course: Course, times: Array, intervals: int) -> tuple[Array, bool]:
    """Return times (S,) with more where a spline comes too near to something, and whether it does."""
    close = np.arange(intervals * CLOSE_LOOKS + 1) / CLOSE_LOOKS
    lacking = lacking_at(around, course.control, close) > 0.0
    return np.union1d(times, close[lacking]), bool(lacking.any())


def _as_motion(around: Surroundings, control: Array, dt: float, places: Array) -> tuple[TimedMotion, list[int]]:
    """Return the motion of control points (M + d, m), and at which of its samples it is at its waypoints.

    It is a cubic spline with knots that are at most dt apart. There are samples at these, and where it is at waypoints:
    at places (P,), as numbers of these samples.
    """
    interval, parts = knots(control, around.limits, dt)
    fine = as_cubic(around.configurations(refined(control, around.degree, parts)), around.degree)
    robot, between = around.problem.robot, places[places % 1.0 != 0.0]
    motion = certified_motion(
        robot, around.problem.obstacles, fine, interval / parts, [len(fine) - 3], between.tolist()
    )
    return motion, [int(np.ceil(place)) + int((between < place).sum()) for place in places]
