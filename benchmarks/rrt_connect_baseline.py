"""A textbook baseline for comparisons: multi-start inverse kinematics and OMPL's RRT-Connect.

Goals are found by damped least squares from random configurations, and rejected if anything touches. RRT-Connect tries
one after the other. Edges are sampled, as OMPL does by itself, and so are the shortcuts that OMPL makes of the path.
There is no safety distance, and nothing between two samples is looked at.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from ompl import base, geometric, util

from humanoid_rail._arrays import Array
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.path_metric import PathQuality, path_quality, speed_units
from humanoid_rail.model.robot import Robot
from humanoid_rail.result import Status
from humanoid_rail.scene.scene import Scene, start_of_scene, target_points
from humanoid_rail.search.smoothing import time_path

GOALS = 10
"""This many goals are tried."""
GOAL_TIME = 1.0
"""RRT-Connect tries a goal for this long, s."""
RESOLUTION = 0.009
"""The samples of an edge are this far apart, rad; with 0.07 paths lead through shelves."""
DAMPING, LONGEST_STEP = 1e-3, 0.5
"""The inverse kinematics has this damping lambda^2 in m^2, and this longest step in rad."""
ITERATIONS, ARRIVED = 100, 1e-4
"""The inverse kinematics takes at most so many steps, until the hands are at their targets up to this, m."""
MOST_STARTS = 2000
"""After so many random starts no more goals are looked for."""


@dataclass(frozen=True)
class Baseline:
    """What came of a scene."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    status: str
    """A :class:`humanoid_rail.Status`."""
    reason: str
    """The status in a sentence."""
    sampled: PathQuality | None
    """The path as RRT-Connect found it, if it did."""


class Goals:
    """Configurations with the hands at the targets in which nothing touches, by inverse kinematics."""

    def __init__(self, robot: Robot, scene: Scene, checker: EdgeChecker, seed: int) -> None:
        self._robot, self._checker = robot, checker
        self._kinematics = NativeKinematics(robot, scene.obstacles)
        self._targets = target_points(robot, scene).ravel()
        self._random = np.random.default_rng(seed)

    def look(self) -> Array | None:
        """Return a goal (n,), or None if a random configuration leads to none."""
        robot = self._robot
        q = self._random.uniform(robot.lower, robot.upper)
        for _ in range(ITERATIONS):
            state = self._kinematics.state(q)
            error = self._targets - state.hands.ravel()
            if np.linalg.norm(error) < ARRIVED:
                return q if self._checker.is_valid(q) else None
            J = state.jacobian
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(error)), error)
            q = np.clip(q + step * min(1.0, LONGEST_STEP / abs(step).max()), robot.lower, robot.upper)
        return None


class Space:
    """The robot's configurations in units of the speed limits, as OMPL has them."""

    def __init__(self, robot: Robot, checker: EdgeChecker) -> None:
        self.units, self.n = speed_units(robot), robot.n
        space = base.RealVectorStateSpace(robot.n)
        bounds = base.RealVectorBounds(robot.n)
        for i, (low, high) in enumerate(zip(robot.lower / self.units, robot.upper / self.units, strict=True)):
            bounds.setLow(i, low)
            bounds.setHigh(i, high)
        space.setBounds(bounds)
        # OMPL must not know this object: through its own pointers neither would ever be freed.
        n, units = self.n, self.units
        self.information = base.SpaceInformation(space)
        self.information.setStateValidityChecker(lambda state: checker.is_valid(np.array(state[0:n]) * units))
        self.information.setStateValidityCheckingResolution(RESOLUTION / units.max() / space.getMaximumExtent())
        self.information.setup()

    def connect(self, start: Array, goal: Array, seconds: float) -> geometric.PathGeometric | None:
        """Return a path between two configurations (n,) if RRT-Connect finds one in time."""
        problem = base.ProblemDefinition(self.information)
        problem.setStartAndGoalStates(self._state(start), self._state(goal))
        planner = geometric.RRTConnect(self.information)
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(seconds)
        return problem.getSolutionPath() if problem.hasExactSolution() else None

    def points(self, path: geometric.PathGeometric) -> Array:
        """Return the configurations (K, n) of a path, m and rad."""
        return np.array([state[0 : self.n] for state in path.getStates()]) * self.units

    def _state(self, q: Array) -> base.RealVectorStateType:
        state = self.information.allocState()
        state[0 : self.n] = (q / self.units).tolist()
        return state


def plan_by_rrt_connect(
    robot: Robot, scene: Scene, seed: int = 0, dt: float = 0.01, max_time: float = 20.0
) -> Baseline:
    """Plan from the start of a scene to its targets.

    Args:
        robot: The robot.
        scene: The scene; its obstacles are taken to rest.
        seed: Of the random numbers.
        dt: Time between samples, s.
        max_time: How long to look, s.
    """
    began = time.perf_counter()
    start = np.array(start_of_scene(robot, scene))
    textbook = _Textbook(robot, scene, seed)
    tried = 0
    for _ in range(MOST_STARTS):
        left = began + max_time - time.perf_counter()
        if tried == GOALS or left <= 0:
            break
        goal = textbook.goal()
        if goal is None:
            continue
        tried += 1
        path = textbook.connect(start, goal, min(GOAL_TIME, left))
        if path is not None:
            found = path_quality(robot, textbook.points(path))
            geometric.PathSimplifier(textbook.information).simplifyMax(path)
            t, q = time_path(robot, textbook.points(path), dt)
            return Baseline(t, q, Status.REACHED, f"a path to goal {tried} was found", found)
    return Baseline(np.zeros(1), start[None], Status.STUCK, f"no path to any of {tried} goals was found", None)


class _Textbook:
    """A robot in a scene, as OMPL and damped least squares see it."""

    def __init__(self, robot: Robot, scene: Scene, seed: int) -> None:
        self.robot, self._random = robot, np.random.default_rng(seed)
        self._kinematics = NativeKinematics(robot, scene.obstacles)
        self._checker = EdgeChecker(robot, scene.obstacles, 0.0)
        self._targets = target_points(robot, scene).ravel()
        self._units = units = speed_units(robot)
        util.setLogLevel(util.LOG_NONE)
        util.RNG.setSeed(seed + 1)
        space = base.RealVectorStateSpace(robot.n)
        bounds = base.RealVectorBounds(robot.n)
        for i, (low, high) in enumerate(zip(robot.lower / units, robot.upper / units, strict=True)):
            bounds.setLow(i, low)
            bounds.setHigh(i, high)
        space.setBounds(bounds)
        self.information = base.SpaceInformation(space)
        self.information.setStateValidityChecker(lambda state: self._checker.is_valid(self._point(state)))
        self.information.setStateValidityCheckingResolution(RESOLUTION / units.max() / space.getMaximumExtent())
        self.information.setup()

    def goal(self) -> Array | None:
        """Return a configuration at the targets in which nothing touches, if a random start leads to one."""
        robot = self.robot
        q = self._random.uniform(robot.lower, robot.upper)
        for _ in range(ITERATIONS):
            state = self._kinematics.state(q)
            error = self._targets - state.hands.ravel()
            if np.linalg.norm(error) < ARRIVED:
                return q if self._checker.is_valid(q) else None
            J = state.jacobian
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(error)), error)
            q = np.clip(q + step * min(1.0, LONGEST_STEP / abs(step).max()), robot.lower, robot.upper)
        return None

    def connect(self, start: Array, goal: Array, seconds: float) -> geometric.PathGeometric | None:
        """Return a path by RRT-Connect, if there is one in time."""
        problem = base.ProblemDefinition(self.information)
        problem.setStartAndGoalStates(self._state(start), self._state(goal))
        planner = geometric.RRTConnect(self.information)
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(seconds)
        return problem.getSolutionPath() if problem.hasExactSolution() else None

    def points(self, path: geometric.PathGeometric) -> Array:
        """Return the configurations (K, n) of a path."""
        return np.array([self._point(state) for state in path.getStates()])

    def _point(self, state: base.RealVectorStateType) -> Array:
        return np.array(state[0 : self.robot.n]) * self._units

    def _state(self, q: Array) -> base.RealVectorStateType:
        state = self.information.allocState()
        state[0 : q.size] = (q / self._units).tolist()
        return state
