"""Paths between configurations by sampling, with OMPL (Sucan, Moll and Kavraki 2012).

RRT-Connect (Kuffner and LaValle 2000) grows a tree from the start and one from the goals until they meet. The path that
it finds is shortened by OMPL's shortcutting. Configurations are measured in units of the speed limits, so that the
length of a path is the time it takes at them.

The same seed gives the same path, whatever other threads plan: OMPL draws its seeds from one generator of the process,
which is set before each call and kept for it. The setup of a space of configurations draws from it too, so it is done
in the call. Threads wait for each other here; processes do not.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from ompl import base, geometric, util

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.path_metric import speed_units
from humanoid_rail.model.robot import Robot

SHORTCUTS = 100
"""Shortcutting tries this often to join two points of a path by a straight edge."""
SHORTCUT_SHARE = 0.33
"""Two points that are joined by a shortcut are at most this share of the path apart."""
SNAP_SHARE = 0.005
"""A point this near to a corner, as a share of the path, is taken to be the corner."""
ROPE_PIECE = 0.2
"""The pass that tightens a path like a rope looks at pieces of this length, s."""
ROPE_TOLERANCE = 0.1
"""A path that the rope pass takes for equally long may differ by this."""

START_TREE = 1
"""OMPL's RRT-Connect marks what grew from the start with this number."""

_lock = threading.Lock()


class _Checks:
    """What OMPL asks. It must not know the `Sampler`: through OMPL's own pointers neither would ever be freed."""

    def __init__(self, checker: EdgeChecker, units: Array, lower: Array, upper: Array, deadline: float) -> None:
        self.checker, self.units, self.lower, self.upper, self.deadline = checker, units, lower, upper, deadline
        self.count = 0

    def point(self, state: base.RealVectorStateType) -> Array:
        # Scaling there and back may have led over a limit, by rounding.
        point: Array = np.clip(np.array(state[0 : self.units.size]) * self.units, self.lower, self.upper)
        return point

    def is_over(self) -> bool:
        return time.perf_counter() > self.deadline

    def is_valid(self, state: base.RealVectorStateType) -> bool:
        return self.checker.is_valid(self.point(state))

    def is_edge_valid(self, a: base.RealVectorStateType, b: base.RealVectorStateType) -> bool:
        self.count += 1
        return not self.is_over() and self.checker.is_edge_valid(self.point(a), self.point(b))


class _Motions(base.MotionValidator):  # type: ignore[misc]
    def __init__(self, information: base.SpaceInformation, checks: _Checks) -> None:
        super().__init__(information)
        self._checks = checks

    def checkMotion(self, a: base.RealVectorStateType, b: base.RealVectorStateType) -> bool:
        return self._checks.is_edge_valid(a, b)


@contextmanager
def _ompl(information: base.SpaceInformation, seed: int, deadline: float) -> Iterator[bool]:
    """Set up a space, and have OMPL draw from a seed and log nothing; False if it is in use until a deadline."""
    left = deadline - time.perf_counter()
    if not _lock.acquire(timeout=min(max(left, 0.0), threading.TIMEOUT_MAX)):
        yield False
        return
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        # This draws random numbers too, for a projection of the space, and so it comes before the seed.
        if not information.isSetup():
            information.setup()
        util.RNG.setSeed(seed)
        yield True
    finally:
        util.setLogLevel(level)
        _lock.release()


class Sampler:
    """A box of configurations in which paths are looked for. Not to be shared between threads."""

    def __init__(
        self, robot: Robot, checker: EdgeChecker, lower: Array, upper: Array, deadline: float = np.inf
    ) -> None:
        """Set up the box.

        Args:
            robot: The robot.
            checker: What tells whether an edge is valid.
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
        self._checks = _Checks(checker, units, lower, upper, deadline)
        self._information.setMotionValidator(_Motions(self._information, self._checks))
        self._information.setStateValidityChecker(self._checks.is_valid)
        self.explored: Array | None = None
        """Configurations (K, n) that the last search that failed has paths to from the start; None before one."""

    @property
    def checks(self) -> int:
        """The number of edges that have been checked."""
        return self._checks.count

    def connect(self, start: Array, goals: Sequence[Array], seed: int, longest: float, max_checks: int) -> Array | None:
        """Return a path (K, n) from a start to one of some goals by RRT-Connect; None if there was none in time.

        Args:
            start: Configuration (n,), m and rad.
            goals: Configurations (n,).
            seed: Seed of the random numbers.
            longest: The longest edge of the trees, s.
            max_checks: The most edges to check.
        """
        checks, last = self._checks, self.checks + max_checks
        # OMPL would wait for a goal that is not valid.
        states = [state for state in map(self._state, goals) if checks.is_valid(state)]
        if not states:
            return None
        problem = base.ProblemDefinition(self._information)
        problem.addStartState(self._state(start))
        region = base.GoalStates(self._information)
        for state in states:
            region.addState(state)
        problem.setGoal(region)
        with _ompl(self._information, seed, checks.deadline) as mine:
            if not mine:
                return None
            planner = geometric.RRTConnect(self._information)
            planner.setRange(longest)
            planner.setProblemDefinition(problem)
            planner.setup()
            planner.solve(base.PlannerTerminationCondition(lambda: checks.count >= last or checks.is_over()))
            if problem.hasExactSolution():
                return self._points(problem.getSolutionPath())
            self.explored = self._from_start(planner)
            return None

    def shorten(self, path: Array, seed: int) -> Array:
        """Return a path (K, n) with the same ends that is shorter, or as long.

        Args:
            path: Configurations (K, n), joined by valid edges.
            seed: Seed of the random numbers.
        """
        shorter = geometric.PathGeometric(self._information)
        for q in path:
            shorter.append(self._state(q))
        with _ompl(self._information, seed, self._checks.deadline) as mine:
            if not mine:
                return path
            simplifier = geometric.PathSimplifier(self._information)
            simplifier.partialShortcutPath(shorter, SHORTCUTS, SHORTCUTS, SHORTCUT_SHARE, SNAP_SHARE)
            simplifier.ropeShortcutPath(shorter, ROPE_PIECE, ROPE_TOLERANCE)
            simplifier.reduceVertices(shorter)
            simplifier.collapseCloseVertices(shorter)
        return self._points(shorter)

    def _from_start(self, planner: geometric.RRTConnect) -> Array:
        """Return the configurations (K, n) of the tree that grew from the start."""
        data = base.PlannerData(self._information)
        planner.getPlannerData(data)
        vertices = [data.getVertex(i) for i in range(data.numVertices())]
        return np.array([self._checks.point(v.getState()) for v in vertices if v.getTag() == START_TREE])

    def _state(self, q: Array) -> base.RealVectorStateType:
        state = self._information.allocState()
        state[0 : q.size] = (q / self._checks.units).tolist()
        return state

    def _points(self, path: geometric.PathGeometric) -> Array:
        return np.array([self._checks.point(state) for state in path.getStates()])
