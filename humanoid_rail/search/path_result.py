"""A path that was found, or the reason why there is none, and the motion that follows from it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.errors import told_apart
from humanoid_rail.kinematics.joint_limits import sampled
from humanoid_rail.problem import Problem
from humanoid_rail.resolution.integrate import Integration, Settings
from humanoid_rail.result import Status
from humanoid_rail.search.exact_end import error_at, error_left
from humanoid_rail.search.smoothing import time_path


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
    taken: int = 0
    """The number of the choice, from 0, that the path reaches, or that the reason is about."""
    goals: int = 0
    """The number of goals to choose from."""
    checks: int = 0
    """The number of edges that were checked."""
    searches: int = 0
    """The number of times the sampling planner was started."""
    explored: Array | None = None
    """Configurations (K, n) to which the last sampling has paths from the start; None where a path was found."""


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
