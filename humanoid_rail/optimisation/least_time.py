"""The fastest spline near a given one, by sequential quadratic programming in a trust region.

Each step solves a quadratic program (`program.py`) in which clearances and tasks are linear. After it the goal is
brought back onto the tasks by a shift that the whole spline shares, and the interval between knots is the shortest that
the limits allow. A step counts by what it makes of the merit: the duration, and a penalty for the clearance that is
lacking most. Waypoints, which are passed without stopping, have equations of their own in the program, and the spline
is brought back onto them after each step (`waypoints.py`).
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.optimisation.looks import Looks, clearances, looks_at, within
from humanoid_rail.optimisation.program import PENALTY, Program, program
from humanoid_rail.optimisation.rows import Clearances, Goal
from humanoid_rail.optimisation.spline import ramp, shortest_interval, weights
from humanoid_rail.optimisation.waypoints import (
    NO_MOMENTS,
    Waypoint,
    onto_waypoints,
    passes_at,
    within_limits,
)
from humanoid_rail.problem import Problem
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.search.exact_end import EXACT

if TYPE_CHECKING:
    from humanoid_rail import _engine

FIRST_TRUST = 0.3
"""The first step moves control points at most this far, s, joint coordinates in units of their speed limits."""
LARGEST_TRUST = 0.4
"""No step moves them farther, s."""
LEAST_TRUST = 1e-3
"""Where nothing better is found within this, the optimisation ends, s."""
SHARES = (1.0, 0.4, 0.16)
"""These shares of a step are tried in turn."""
WORTHWHILE = 0.1
"""A step is made if it gains this share of what the program promised."""
GOOD, POOR = 0.6, 0.3
"""The trust region grows after steps that gain more than this share, and shrinks after those that gain less."""
GROWTH, SHRINK = 2.0, 0.5
"""So many times."""
ENOUGH = 0.01
"""The optimisation ends with a step that gains less than this share of the duration, or of its mean part from one stop
or waypoint to the next."""
DEEPEST = 0.02
"""No step leads to where a clearance lacks more than this, m, unless it was lacking before: there may be no way out."""
LEAST_GAIN = 1e-5
"""Where clearances lack more than they may, it ends where a program promises less than this."""
LACKING = 3e-4
"""A clearance may lack this at the end, m."""


class Course(NamedTuple):
    """A spline on the way to the fastest one."""

    control: Array
    """Control points (M + d, m), s."""
    interval: float
    """The shortest between knots, s."""
    lacking: float
    """By how much some pair is too near at the moments that were looked at, m."""
    steps: int
    """How many programs were solved for it."""
    moments: Array = NO_MOMENTS
    """When it passes the waypoints (P,), in intervals."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What a spline is shortened within."""

    problem: Problem
    moving: NDArray[np.bool_]
    """Which of the joints move (n,)."""
    limits: tuple[Array, ...]
    """Of the derivatives of order 1, 2 and so on (m,), joint coordinates in units of their speed limits."""
    distance: float
    """What pairs keep, m."""
    is_goal_free: bool
    clearance: _engine.MotionClearance
    solver: InverseKinematics
    waypoints: tuple[Waypoint, ...] = ()
    """What is passed on the way."""

    @property
    def box(self) -> tuple[Array, Array]:
        """Lower and upper position limits (m,), s."""
        return self.points(self.problem.robot.lower), self.points(self.problem.robot.upper)

    @property
    def degree(self) -> int:
        """Of the splines, d."""
        return len(self.limits)

    @property
    def units(self) -> Array:
        """Of the coordinates of the joints that move (m,)."""
        return self.problem.robot.speed_units[self.moving]

    def configurations(self, points: Array) -> Array:
        """Return configurations (K, n), m and rad, from points (K, m), s."""
        q = np.tile(self.problem.q, (len(points), 1))
        q[:, self.moving] = points * self.units
        return q

    def points(self, q: Array) -> Array:
        """Return points (..., m), s, from configurations (..., n), m and rad."""
        there: Array = q[..., self.moving] / self.units
        return there


def surroundings(
    problem: Problem, limits: tuple[Array, ...], moving: NDArray[np.bool_], distance: float, goal: Array
) -> Surroundings:
    """Return what a motion to the tasks of a problem is shortened within.

    Args:
        problem: The robot, its tasks and the start; obstacles are at rest.
        limits: Of the derivatives of order 1, 2 and so on (n,), in SI units; finite for the joints that move, but that
            of order 3.
        moving: Which of the joints move (n,).
        distance: What pairs keep, m.
        goal: Where the motion ends (n,), m and rad. It may move where the tasks stay done, if they are done there.
    """
    robot, solver = problem.robot, InverseKinematics(problem.robot, problem.obstacles)
    # Inverse kinematics moves all joints that can move.
    is_goal_free = bool((moving | (robot.velocity_limit == 0.0)).all())
    is_goal_free = is_goal_free and float(np.linalg.norm(solver.evaluate(goal, problem.tasks)[0])) <= EXACT
    return Surroundings(
        problem,
        moving,
        tuple((limit / robot.speed_units)[moving] for limit in limits),
        distance,
        is_goal_free,
        engine().MotionClearance(native_robot(robot), native_obstacles(problem.obstacles)),
        solver,
    )


def shorten(
    around: Surroundings,
    control: Array,
    times: Array,
    max_steps: int,
    deadline: float,
    trust: float = FIRST_TRUST,
    taken: int = 0,
    moments: Array = NO_MOMENTS,
) -> Course:
    """Return the fastest spline that is found from a given one.

    Args:
        around: What it is shortened within.
        control: Control points (M + d, m), s.
        times: Moments at which it keeps clear, in intervals (S,).
        max_steps: The most programs to solve.
        deadline: When it is cut off, on the clock of `time.perf_counter`, s.
        trust: How far the first step may go, s.
        taken: How many programs were solved before.
        moments: When it passes the waypoints (P,), in intervals.
    """
    form = _form(around, len(control) - around.degree)
    looks = looks_at(form, times)
    here, rows = _look(around, looks, Course(control, np.inf, np.inf, taken, moments), trust)
    enough = ENOUGH / (1 + len(around.waypoints))
    while here.steps < taken + max_steps and time.perf_counter() < deadline:
        passes = passes_at(around, form, here.control, here.moments)
        step = form.step(here.control, here.interval, rows, _goal(around, here.control), trust, passes)
        here = here._replace(steps=here.steps + 1)
        if step is None:
            break
        expected = 1.0 + PENALTY * here.lacking - step.merit
        if expected < (enough if here.lacking <= LACKING else LEAST_GAIN):
            break
        for share in SHARES:
            later = here.moments + share * step.shift
            moved = on_tasks(around, here.control + share * step.change, -np.inf, later)
            if moved is None:
                continue
            reach = min(GROWTH * share * trust, LARGEST_TRUST)
            there, there_rows = _look(around, looks, here._replace(control=moved, moments=later), reach)
            gain = 1.0 - there.interval / here.interval + PENALTY * (here.lacking - there.lacking)
            ratio = gain / (share * expected)
            if ratio > WORTHWHILE and there.lacking <= max(here.lacking, DEEPEST):
                break
        else:
            trust *= SHARES[-1]
            rows = within(rows, trust)
            if trust < LEAST_TRUST:
                break
            continue
        trust = reach if ratio > GOOD else trust * share * (SHRINK if ratio < POOR else 1.0)
        here, rows = there, within(there_rows, trust)
        if gain < enough and share == 1.0 and here.lacking <= LACKING:
            break
    return here


def _form(around: Surroundings, intervals: int) -> Program:
    return program(around.degree, intervals, around.limits, around.box, around.is_goal_free, len(around.waypoints))


def on_tasks(around: Surroundings, control: Array, distance: float, moments: Array = NO_MOMENTS) -> Array | None:
    """Return a spline within the position limits that is brought onto the tasks, or None where it cannot be.

    Its goal takes the whole spline with it; a waypoint takes as much of it as keeps it smooth.

    Args:
        around: The tasks.
        control: Control points (M + d, m), s.
        distance: The distance that pairs keep at the goal, m; minus infinity to leave clearances alone.
        moments: When it passes the waypoints (P,), in intervals.
    """
    degree, moved = around.degree, control
    if around.is_goal_free:
        found = around.solver.solve(around.configurations(control[-1:])[0], around.problem.tasks, distance)
        if not found.reached:
            return None
        goal = around.points(found.q)
        moved = control + ramp(degree, len(control) - degree)[:, None] * (goal - control[-1])
        moved[-degree:] = goal
    moved = within_limits(around, moved)
    if not around.waypoints:
        return moved
    return onto_waypoints(around, moved, weights(degree, len(control) - degree, moments))


def lacking_at(around: Surroundings, control: Array, times: Array) -> Array:
    """Return by how much some pair is too near at times (S,) in intervals, m; negative where none is."""
    q = around.configurations(weights(around.degree, len(control) - around.degree, times) @ control)
    lacking: Array = -around.clearance.rows(q, around.distance, around.distance, np.zeros(q.shape[1])).least
    return lacking


def _look(around: Surroundings, looks: Looks, course: Course, trust: float) -> tuple[Course, Clearances]:
    """Return a spline with what is known of it, and the rows for a step within a trust region."""
    robot, moving = around.problem.robot, around.moving
    q = around.configurations(looks.weights @ course.control)
    rows, spare = clearances(around.clearance, looks, q, robot.speed_units, moving, around.distance, trust)
    interval = shortest_interval(course.control, around.limits)
    return course._replace(interval=interval, lacking=max(0.0, -float(spare.min()))), rows


def _goal(around: Surroundings, control: Array) -> Goal | None:
    """Return the tasks at the goal; None for one that stays."""
    if not around.is_goal_free:
        return None
    error, jacobian = around.solver.evaluate(around.configurations(control[-1:])[0], around.problem.tasks)
    return Goal(error, jacobian[:, around.moving] * around.units)
