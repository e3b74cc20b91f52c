"""Ways between configurations by sampling, from OMPL (Sucan, Moll and Kavraki 2012): the only import of it.

RRT-Connect (Kuffner and LaValle 2000) grows a tree from the start and one from the goals until they meet. What it finds
is made shorter by OMPL's shortcuts. Configurations are measured in units of the speed limits, so that the length of a
path is the time it takes at them.

The same seed gives the same path, whatever happens in other threads: OMPL draws its seeds from one generator of the
process, which is set before each call and kept to it meanwhile. So threads wait for each other here, until their time
is over; processes do not.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np
from ompl import base, geometric, util

from humanoid_rail._arrays import Array
from humanoid_rail.search.smoothing import speed_units
from humanoid_rail.model.robot import Robot

SHORTCUTS = 100
"""Attempts to join two points of a path by a straight line, and ..."""
SHARE = 0.33
"""... how far apart these are at most, as a share of the path."""
SNAP = 0.005
"""Such a point is a corner if it is that near to one, as a share of the path."""
ROPE_PIECE, ROPE_TOLERANCE = 0.2, 0.1
"""Of the pass that tightens a path like a rope: how long the pieces are that it looks at, s; what an equally long way
may differ by."""

_lock = threading.Lock()


class Validity(Protocol):
    """Tells where the robot may be and go: :class:`humanoid_rail.validity.Validity`, or the native one."""

    def holds_at(self, q: Array) -> bool:
        """Return whether a configuration (n,) is allowed."""
        ...

    def holds_between(self, a: Array, b: Array) -> bool:
        """Return whether the straight way between two configurations (n,) is."""
        ...


class _Checks:
    """What OMPL asks. It must not know the `Sampler`: through OMPL's own pointers neither would ever be freed."""

    def __init__(self, validity: Validity, units: Array, lower: Array, upper: Array, deadline: float) -> None:
        self.validity, self.units, self.lower, self.upper, self.deadline = validity, units, lower, upper, deadline
        self.count = 0

    def point(self, state: base.RealVectorStateType) -> Array:
        # The way there and back may have led over a limit, by rounding.
        point: Array = np.clip(np.array(state[0 : self.units.size]) * self.units, self.lower, self.upper)
        return point

    def is_over(self) -> bool:
        return time.perf_counter() > self.deadline

    def holds_at(self, state: base.RealVectorStateType) -> bool:
        return self.validity.holds_at(self.point(state))

    def holds_between(self, a: base.RealVectorStateType, b: base.RealVectorStateType) -> bool:
        self.count += 1
        return not self.is_over() and self.validity.holds_between(self.point(a), self.point(b))


class _Motions(base.MotionValidator):  # type: ignore[misc]
    def __init__(self, information: base.SpaceInformation, checks: _Checks) -> None:
        super().__init__(information)
        self._checks = checks

    def checkMotion(self, a: base.RealVectorStateType, b: base.RealVectorStateType) -> bool:
        return self._checks.holds_between(a, b)


@contextmanager
def _ompl(seed: int, deadline: float) -> Iterator[bool]:
    """Have OMPL draw its random numbers from a seed, and say nothing; False if others keep it until a deadline."""
    left = deadline - time.perf_counter()
    if not _lock.acquire(timeout=min(max(left, 0.0), threading.TIMEOUT_MAX)):
        yield False
        return
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        util.RNG.setSeed(seed)
        yield True
    finally:
        util.setLogLevel(level)
        _lock.release()


class Sampler:
    """A box of configurations in which ways are looked for. Not to be shared between threads."""

    def __init__(self, robot: Robot, validity: Validity, lower: Array, upper: Array, deadline: float = np.inf) -> None:
        """Set up the box.

        Args:
            robot: The robot.
            validity: What tells whether a straight way holds.
            lower: Corner of the box (n,), m and rad.
            upper: The opposite corner (n,).
            deadline: When to stop, on the clock of `time.perf_counter`, s.
        """
        units = speed_units(robot)
        space = base.RealVectorStateSpace(robot.n)
        bounds = base.RealVectorBounds(robot.n)
        for i, (low, high) in enumerate(zip(lower / units, upper / units, strict=True)):
            bounds.setLow(i, float(low))
            bounds.setHigh(i, float(high))
        space.setBounds(bounds)
        self._information = base.SpaceInformation(space)
        self._checks = _Checks(validity, units, lower, upper, deadline)
        self._information.setMotionValidator(_Motions(self._information, self._checks))
        self._information.setStateValidityChecker(self._checks.holds_at)
        self._information.setup()

    @property
    def checks(self) -> int:
        """How many straight ways have been checked."""
        return self._checks.count

    def connect(self, start: Array, goals: Sequence[Array], seed: int, longest: float, max_checks: int) -> Array | None:
        """Return a path (K, n) from a start to one of some goals by RRT-Connect; None if there was none in time.

        Args:
            start: Configuration (n,), m and rad.
            goals: Configurations (n,).
            seed: Of the random numbers.
            longest: The longest edge of the trees, s.
            max_checks: The most straight ways to check.
        """
        checks, last = self._checks, self.checks + max_checks
        # For a goal that is none OMPL would wait.
        states = [state for state in map(self._state, goals) if checks.holds_at(state)]
        if not states:
            return None
        problem = base.ProblemDefinition(self._information)
        problem.addStartState(self._state(start))
        region = base.GoalStates(self._information)
        for state in states:
            region.addState(state)
        problem.setGoal(region)
        with _ompl(seed, checks.deadline) as mine:
            if not mine:
                return None
            planner = geometric.RRTConnect(self._information)
            planner.setRange(longest)
            planner.setProblemDefinition(problem)
            planner.setup()
            planner.solve(base.PlannerTerminationCondition(lambda: checks.count >= last or checks.is_over()))
            return self._points(problem.getSolutionPath()) if problem.hasExactSolution() else None

    def shorten(self, path: Array, seed: int) -> Array:
        """Return a path (K, n) with the same ends that is shorter, or as long.

        Args:
            path: Configurations (K, n), whose pieces hold.
            seed: Of the random numbers.
        """
        shorter = geometric.PathGeometric(self._information)
        for q in path:
            shorter.append(self._state(q))
        with _ompl(seed, self._checks.deadline) as mine:
            if not mine:
                return path
            simplifier = geometric.PathSimplifier(self._information)
            simplifier.partialShortcutPath(shorter, SHORTCUTS, SHORTCUTS, SHARE, SNAP)
            simplifier.ropeShortcutPath(shorter, ROPE_PIECE, ROPE_TOLERANCE)
            simplifier.reduceVertices(shorter)
            simplifier.collapseCloseVertices(shorter)
        return self._points(shorter)

    def _state(self, q: Array) -> base.RealVectorStateType:
        state = self._information.allocState()
        state[0 : q.size] = (q / self._checks.units).tolist()
        return state

    def _points(self, path: geometric.PathGeometric) -> Array:
        return np.array([self._checks.point(state) for state in path.getStates()])
