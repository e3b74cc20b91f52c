"""Waypoints: where a spline does tasks on its way, without stopping, at moments that the optimisation chooses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.task import Task
from humanoid_rail.optimisation.program import Program
from humanoid_rail.optimisation.rows import Pass
from humanoid_rail.optimisation.spline import as_cubic, knots, refined, weights
from humanoid_rail.search.exact_end import EXACT
from humanoid_rail.timing.bspline import samples_between

if TYPE_CHECKING:
    from humanoid_rail.optimisation.least_time import Surroundings

NO_MOMENTS: Array = frozen(np.zeros(0))
"""Of a spline that passes no waypoints."""
LARGEST_SHIFT = 0.5
"""A step moves the moment at which a waypoint is passed by at most this, in intervals."""
APART = 1.0
"""Waypoints are passed at least so many intervals after each other: else one control point would have to serve two."""
FROM_ENDS = 0.5
"""They are passed at least so many intervals less than the degree after the start and before the goal, which stay."""


ROUNDS = 6
"""A spline is brought exactly onto waypoints at most so often."""
CLOSE_TO_SAMPLE = 0.05
"""A waypoint that is passed so near to a sample is passed there, as a share of the time between samples."""


class Waypoint(NamedTuple):
    """Tasks that are done in passing."""

    tasks: Sequence[Task]
    solver: InverseKinematics
    """Of the robot with the hands that have tasks here."""


def margin(degree: int) -> float:
    """Return how long after the start and before the goal waypoints are passed at least, in intervals."""
    return degree - FROM_ENDS


def spread(moments: Array, degree: int, intervals: int) -> Array | None:
    """Return moments (P,) in intervals far enough apart, as near to given ones as may be; None if there is no room."""
    first, count = margin(degree), len(moments)
    last = intervals - first - APART * (count - 1)
    if last < first:
        return None
    # Without the least time between them they only have to be in order.
    steps = APART * np.arange(count)
    apart: Array = np.clip(np.maximum.accumulate(moments - steps), first, last) + steps
    return apart


def passes_at(around: Surroundings, form: Program, control: Array, moments: Array) -> list[Pass]:
    """Return the tasks at the waypoints that a spline (M + d, m) passes at moments (P,), linear in its change."""
    if not around.waypoints:
        return []
    rows = weights(form.degree, form.intervals, moments)
    # The derivative of a uniform spline is one of a degree less, of the differences of the control points.
    rate = weights(form.degree - 1, form.intervals, moments) @ np.diff(control, axis=0)
    ends = margin(form.degree)
    room = np.diff(moments, prepend=ends, append=form.intervals - ends)
    room[1:-1] = (room[1:-1] - APART) / 2.0
    room = np.clip(room, 0.0, LARGEST_SHIFT)
    passes = []
    for number, (waypoint, q) in enumerate(zip(around.waypoints, around.configurations(rows @ control), strict=True)):
        error, jacobian = waypoint.solver.evaluate(q, waypoint.tasks)
        slope = jacobian[:, around.moving] * around.units
        row = rows[number] @ form.free
        passes.append(Pass(row, error, slope, slope @ rate[number], -float(room[number]), float(room[number + 1])))
    return passes


def onto_waypoints(around: Surroundings, control: Array, rows: Array) -> Array | None:
    """Return a spline brought onto the tasks at its waypoints, within the position limits; None where it cannot be.

    Its change is the smoothest that does it: the one with the least second differences. Both ends stay.

    Args:
        around: The waypoints.
        control: Control points (M + d, m), s.
        rows: The weights (P, M + d) of the control points where the waypoints are passed.
    """
    points = rows @ control
    wanted = np.empty_like(points)
    for number, (waypoint, q) in enumerate(zip(around.waypoints, around.configurations(points), strict=True)):
        found = waypoint.solver.solve(q, waypoint.tasks, -np.inf)
        if not found.reached:
            return None
        wanted[number] = around.points(found.q)
    return within_limits(around, control + smoothest(rows, around.degree) @ (wanted - points))


def smoothest(rows: Array, degree: int) -> Array:
    """Return changes (M + d, P) of control points, each of 1 at one of the moments and of 0 at the others and the ends.

    They are those with the least second differences.

    Args:
        rows: The weights (P, M + d) of the control points at the moments.
        degree: d.
    """
    count = rows.shape[1]
    free = slice(degree, count - degree)
    bends = np.diff(np.eye(count)[:, free], 2, axis=0)
    towards = np.linalg.solve(bends.T @ bends, rows[:, free].T)
    changes = np.zeros((count, len(rows)))
    changes[free] = towards @ np.linalg.inv(rows[:, free] @ towards)
    return changes


class Exact(NamedTuple):
    """A spline whose motion is exactly at its waypoints."""

    control: Array
    """Control points (M + d, m), s."""
    places: Array
    """Where its motion is at them (P,), as numbers of its samples."""


def exactly_at_waypoints(around: Surroundings, control: Array, moments: Array, dt: float) -> Exact | None:
    """Return a spline whose motion is exactly at its waypoints; None where that cannot be had.

    Args:
        around: The waypoints.
        control: Control points (M + d, m), s, of a spline that is at its waypoints nearly.
        moments: When it passes them (P,), in intervals.
        dt: The most time between samples, s.
    """
    if not around.waypoints:
        return Exact(control, NO_MOMENTS)
    degree = around.degree
    for _ in range(ROUNDS):
        _, parts = knots(control, around.limits, dt)
        # The motion is half an interval between its knots behind the quadratic spline.
        places = moments * parts + (0.5 if degree == 2 else 0.0)
        nearest = np.rint(places)
        places = np.where(abs(places - nearest) < CLOSE_TO_SAMPLE, nearest, places)
        fine = as_cubic(refined(np.eye(len(control)), degree, parts), degree)
        rows, _, _ = samples_between(fine, 1.0, places)
        if errors_at(around, around.configurations(rows @ control)).max() <= EXACT / 2.0:
            return Exact(control, places)
        moved = onto_waypoints(around, control, rows)
        if moved is None:
            return None
        control = moved
    return None


def errors_at(around: Surroundings, q: Array) -> Array:
    """Return the norms (P,) of the errors of the tasks at configurations (P, n) where waypoints are passed, m."""
    return np.array(
        [
            float(np.linalg.norm(waypoint.solver.evaluate(there, waypoint.tasks)[0]))
            for waypoint, there in zip(around.waypoints, q, strict=True)
        ]
    )


def within_limits(around: Surroundings, control: Array) -> Array:
    """Return a spline whose control points between both ends are within the position limits."""
    moved, degree = control.copy(), around.degree
    moved[degree:-degree] = np.clip(control[degree:-degree], *around.box)
    return moved
