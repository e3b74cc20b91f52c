"""Segments of `auto` made one motion of least time that passes targets without stopping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from humanoid_rail.kinematics.joint_limits import sampled
from humanoid_rail.optimisation.passing import passing_motion
from humanoid_rail.planning.options import Planned
from humanoid_rail.problem import Problem
from humanoid_rail.result import Optimisation
from humanoid_rail.search.exact_end import EXACT, error_at, error_left
from humanoid_rail.timing.timed_motion import TimedMotion, parts_of

KEPT = "something is kept on the way to them or from them"
"""Why a motion rests at targets that it could pass otherwise."""


def without_stopping(
    planned: Sequence[Planned],
    problems: Sequence[Problem],
    dt: float,
    safety_distance: float,
    max_steps: int,
    deadline: float,
) -> list[Planned]:
    """Return segments that pass the targets of all but the last, or that stop there as they did where that is faster.

    Those without a timing that a drive can follow stay as they are: they rest nowhere.

    Args:
        planned: The segments, which reach their targets.
        problems: What each was planned for.
        dt: The most time between samples, s.
        safety_distance: The distance that pairs keep, m.
        max_steps: The most quadratic programs to solve.
        deadline: When planning is cut off, on the clock of `time.perf_counter`, s.
    """
    if any(one.timed is None for one in planned):
        return list(planned)
    if any(problem.constraints for problem in problems):
        done = planned[-1].optimisation or Optimisation(0, 0)
        return [*planned[:-1], replace(planned[-1], optimisation=replace(done, stopped=KEPT))]
    paths = [one.motion.q for one in planned]
    found = passing_motion(problems, paths, dt, safety_distance, max_steps, deadline)
    stopping = sum(float(one.motion.t[-1]) for one in planned)
    if found.motion is None or found.motion.duration >= stopping:
        done = planned[-1].optimisation or Optimisation(0, 0)
        reason = found.reason or "a motion that passes them takes no less time"
        said = replace(done, steps=done.steps + found.steps, stopped=reason)
        return [*planned[:-1], replace(planned[-1], optimisation=said)]
    parts = parts_of(found.motion, found.passed)
    passing = [_passing(*of_step) for of_step in zip(planned, problems, parts, strict=True)]
    last = passing[-1].optimisation
    assert last is not None
    # The last targets are rested at, and what the motion took is counted once.
    passing[-1] = replace(passing[-1], optimisation=replace(last, steps=last.steps + found.steps, passed=0))
    return passing


def _passing(planned: Planned, problem: Problem, timed: TimedMotion) -> Planned:
    """Return a segment with its part of a motion that passes targets."""
    left = error_at(problem, timed.q[-1])
    motion = replace(
        planned.motion,
        t=timed.t,
        q=timed.q,
        reason=f"{error_left(left, EXACT)} at t = {timed.duration:.4g} s",
        visited=sampled(timed.t, timed.q),
    )
    steps = 0 if planned.optimisation is None else planned.optimisation.steps
    return replace(planned, motion=motion, timed=timed, optimisation=Optimisation(steps, 1, passed=1))
