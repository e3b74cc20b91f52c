"""How near to its targets a motion ends, and how one that ends within the tolerance is led on to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.joint_limits import sampled
from humanoid_rail.kinematics.task_stack import stack_error
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.result import Status
from humanoid_rail.search.smoothing import time_path

EXACT = 1e-6
"""A motion that ends with an error of at most this ends exactly at its targets, m."""


def error_at(problem: Problem, q: Array, t: float = 0.0) -> float:
    """Return the norm of the error of all tasks at a configuration (n,) and a time in s, m."""
    return float(np.linalg.norm(stack_error(problem.native.state(q, t), problem.tasks)))


def error_left(left: float, tolerance: float) -> str:
    """Say how near to its targets a motion ends, with an error and a tolerance in m."""
    if left <= EXACT:
        return f"|e| is {left:.2g} m"
    return f"|e| is {left:.2g} m, within tolerance = {tolerance:g} m; no path to the exact targets was found"


def led_on(problem: Problem, motion: Integration, distance: float, settings: Settings) -> Integration:
    """Return a motion that ends within the tolerance, led on to the exact targets where a straight edge leads there.

    One that keeps constraints stays as it is.

    Args:
        problem: The robot, its tasks and the obstacles, which are at rest.
        motion: What the safe velocity does.
        distance: The distance that the edge keeps from everything, m.
        settings: How far apart samples are, how long the motion may take, and the tolerance.
    """
    end = motion.q[-1]
    if problem.constraints or motion.status is not Status.REACHED or (left := error_at(problem, end)) <= EXACT:
        return motion
    goal = InverseKinematics(problem.robot, problem.obstacles).solve(end, problem.tasks, distance)
    checker = EdgeChecker(problem.robot, problem.obstacles, distance)
    if goal.reached and checker.is_edge_valid(end, goal.q):
        t, q = time_path(problem.robot, np.array([end, goal.q]), settings.dt, checker.is_edge_valid)
        t = np.concatenate([motion.t, motion.t[-1] + t[1:]])
        if t[-1] <= settings.max_time:
            q = np.vstack([motion.q, q[1:]])
            reason = f"{error_left(error_at(problem, q[-1]), settings.tolerance)} at {settings.at(t[-1])}"
            return Integration(t, q, motion.status, reason, motion.evaluations, sampled(t, q))
    return replace(motion, reason=f"{error_left(left, settings.tolerance)}, at {settings.at(motion.t[-1])}")
