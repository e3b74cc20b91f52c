"""What is kept on the segments of a motion, and how far the motion leaves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._native import why_no_engine
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import certify
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.kinematics.deviation import Deviation
from humanoid_rail.kinematics.deviation_bounds import deviations
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.keeping import constraints_of
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration
from humanoid_rail.result import Method, Status
from humanoid_rail.scene.scene import Scene
from humanoid_rail.search.exact_end import error_at
from humanoid_rail.search.kept_path import FINE, on_constraints
from humanoid_rail.timing.time_optimal import limits_of
from humanoid_rail.timing.timed_motion import TimedMotion, along_path, wanted_bound

LONGEST_STEP = 0.01
"""Samples of a motion that keeps constraints are at most this far apart, s."""


class KeptLimits(NamedTuple):
    """How far a motion may leave its constraints."""

    distance: float
    """m"""
    angle: float
    """rad"""

    def allow(self, deviation: Deviation) -> bool:
        """Return whether a motion may leave a constraint so far."""
        return deviation.bound <= (self.distance if deviation.unit == "m" else self.angle)

    def exceeded(self, found: Sequence[Deviation]) -> str | None:
        """Say which constraint is left too far, when and by how much; None if none is."""
        beyond = [deviation for deviation in found if not self.allow(deviation)]
        if not beyond:
            return None
        most = f"{1e3 * self.distance:g} mm" if beyond[0].unit == "m" else f"{np.rad2deg(self.angle):.3g} deg"
        return f"{beyond[0]}, more than the {most} that are allowed"


def allowed_by(method: Method) -> KeptLimits:
    """Return how far the motions of a method may leave their constraints."""
    return KeptLimits(method.max_deviation, method.max_tilt)


@dataclass(frozen=True, eq=False)
class Kept:
    """Constraints that hold on a part of a motion."""

    constraints: tuple[Task, ...]
    begin: float
    """s"""
    end: float
    """s"""


def deviations_of(
    robot: Robot, kept: Sequence[Kept], t: Array, q: Array, velocity: Array | None = None
) -> tuple[Deviation, ...]:
    """Return how far a motion leaves what it has to keep at the most.

    Args:
        robot: The robot.
        kept: What it keeps, and when.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
        velocity: Velocities (N, n) of a spline; without them the motion is linear between samples.
    """
    found: list[Deviation] = []
    for part in kept:
        a, b = (int(np.argmin(abs(t - time))) for time in (part.begin, part.end))
        there = slice(a, b + 1)
        found += deviations(robot, part.constraints, t[there], q[there], None if velocity is None else velocity[there])
    return tuple(found)


def recorded(certificate: Certificate | None) -> tuple[Kept, ...]:
    """Return what a motion keeps, and when, by its certificate."""
    found: dict[tuple[float, float], list[Task]] = {}
    for deviation in () if certificate is None else certificate.deviations:
        if deviation.task is not None:
            found.setdefault((deviation.begin, deviation.end), []).append(deviation.task)
    return tuple(Kept(tuple(tasks), begin, end) for (begin, end), tasks in found.items())


def kept_in_scene(robot: Robot, scene: Scene, t: Array, q: Array, arrivals: Sequence[float] | None) -> tuple[Kept, ...]:
    """Return what a scene keeps along a motion to its targets.

    Each step keeps things as they are when the targets of the step before were reached, until its own are.

    Args:
        robot: The robot.
        scene: The scene.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
        arrivals: When the targets of each step were reached, s; None where that is not known.

    Raises:
        InvalidInput: If that is not known and there are several steps.
    """
    if not any(step.keep for step in scene.steps):
        return ()
    if arrivals is None:
        if len(scene.steps) > 1:
            valid = "the times at which the targets of each step are reached: the scene keeps things on the way to them"
            raise InvalidInput("trajectory.arrivals", MISSING, valid)
        arrivals = ()
    times = [float(t[0]), *arrivals, float(t[-1])]
    found = list[Kept]()
    for step, begin, end in zip(scene.steps, times, times[1:], strict=False):
        start = q[int(np.argmin(abs(t - begin)))]
        if step.keep:
            found.append(Kept(constraints_of(robot, step.keep, start), begin, end))
    return tuple(found)


def brought_back(problem: Problem, motion: Integration, tolerance: float) -> Integration:
    """Return a motion with its samples brought back onto the constraints, as far as rounding and damping left them.

    Without a native engine it stays as it is, and so does a sample from which no configuration is found.

    Args:
        problem: What was planned.
        motion: The motion.
        tolerance: How far |e| may be from 0 where it reaches the tasks, m.
    """
    if why_no_engine():
        return motion
    q = on_constraints(problem.robot, problem.constraints, motion.q, np.inf)
    left, end = error_at(problem, q[-1], float(motion.t[-1])), float(motion.t[-1])
    if motion.status is not Status.REACHED:
        return replace(motion, q=q)
    is_there = left <= tolerance
    reason = f"|e| is {left:.3g} m at t = {end:.4g} s{'' if is_there else ', brought back onto what is kept'}"
    return replace(motion, q=q, status=Status.REACHED if is_there else Status.STALLED, reason=reason)


def kept_motion(problem: Problem, t: Array, path: Array, dt: float, distance: float, limits: KeptLimits) -> TimedMotion:
    """Return the motion along a path that is as fast as its limits allow and leaves the constraints as little as asked.

    It follows the path more closely where that is needed.

    Args:
        problem: The robot and what it keeps, among obstacles at rest.
        t: Times (N,) of the path, s.
        path: Its configurations (N, n), m and rad.
        dt: The most time between samples, s.
        distance: What pairs keep, m.
        limits: How far it may leave the constraints.
    """
    robot = problem.robot
    closely = on_constraints(robot, problem.constraints, path, FINE)

    def fits(motion: TimedMotion) -> bool:
        found = deviations(robot, problem.constraints, motion.t, motion.q, motion.velocity)
        return all(map(limits.allow, found))

    wanted = wanted_bound(certify(robot, problem.obstacles, t, path), distance)
    step = dt / np.ceil(dt / LONGEST_STEP)
    return along_path(robot, problem.obstacles, [closely], limits_of(robot), step, 0.0, wanted, fits)
