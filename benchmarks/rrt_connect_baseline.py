"""What one puts together from a textbook: multi-start inverse kinematics and OMPL's RRT-Connect, for comparisons.

Goals are looked for by damped least squares from random configurations, and thrown away if anything touches.
RRT-Connect tries one after the other. Straight ways are sampled, as OMPL does by itself, and so are the shortcuts that
OMPL makes of what it finds. There is no safety distance, and nothing between two samples is looked at.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from ompl import base, geometric, util

from humanoid_rail._arrays import Array
from humanoid_rail.planning.engines import Engine
from humanoid_rail.search.smoothing import path_quality, speed_units, time_path
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene, target_points
from humanoid_rail.search.effort import PathQuality
from humanoid_rail.result import Status

GOALS = 10
"""How many goals are tried."""
GOAL_TIME = 1.0
"""How long RRT-Connect tries a goal, s."""
RESOLUTION = 0.009
"""How far apart the samples of a straight way are, rad; at 0.07 ways lead through shelves."""
DAMPING, LONGEST_STEP = 1e-3, 0.5
"""Of the inverse kinematics: lambda^2 in m^2, and the longest step in rad."""
ITERATIONS, ARRIVED = 100, 1e-4
"""At most so many steps; the hands are at their targets up to this, m."""
MOST_STARTS = 2000
"""After so many starts the inverse kinematics gives up."""


@dataclass(frozen=True)
class Baseline:
    """What came of a scene."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    status: str
    reason: str
    sampled: PathQuality | None
    """The way as RRT-Connect found it, if it did."""


def plan_by_rrt_connect(
    robot: Robot, scene: Scene, engine: Engine, seed: int = 0, dt: float = 0.01, max_time: float = 20.0
) -> Baseline:
    """Plan from the start of a scene to its targets.

    Args:
        robot: The robot.
        scene: The scene; its obstacles are taken to rest.
        engine: What tells where the hands are and whether anything touches.
        seed: Of the random numbers.
        dt: Time between samples, s.
        max_time: How long to look, s.
    """
    began = time.perf_counter()
    random = np.random.default_rng(seed)
    start = np.array(robot.initial if scene.initial is None else scene.initial, float)
    kinematics = engine.kinematics(robot, scene.obstacles)
    validity = engine.validity(robot, scene.obstacles, 0.0)
    targets = target_points(robot, scene).ravel()

    def posture() -> Array | None:
        q = random.uniform(robot.lower, robot.upper)
        for _ in range(ITERATIONS):
            state = kinematics.state(q)
            error = targets - state.hands.ravel()
            if np.linalg.norm(error) < ARRIVED:
                return q if validity.holds_at(q) else None
            J = state.jacobian
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(error)), error)
            q = np.clip(q + step * min(1.0, LONGEST_STEP / abs(step).max()), robot.lower, robot.upper)
        return None

    units = speed_units(robot)
    util.setLogLevel(util.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    space = base.RealVectorStateSpace(robot.n)
    bounds = base.RealVectorBounds(robot.n)
    for i, (low, high) in enumerate(zip(robot.lower / units, robot.upper / units, strict=True)):
        bounds.setLow(i, low)
        bounds.setHigh(i, high)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(lambda state: validity.holds_at(np.array(state[0 : robot.n]) * units))
    information.setStateValidityCheckingResolution(RESOLUTION / units.max() / space.getMaximumExtent())
    information.setup()

    def state_of(q: Array) -> base.RealVectorStateType:
        state = information.allocState()
        state[0 : robot.n] = (q / units).tolist()
        return state

    def points(path: geometric.PathGeometric) -> Array:
        return np.array([state[0 : robot.n] for state in path.getStates()]) * units

    tried = 0
    for _ in range(MOST_STARTS):
        left = began + max_time - time.perf_counter()
        if tried == GOALS or left <= 0:
            break
        goal = posture()
        if goal is None:
            continue
        tried += 1
        problem = base.ProblemDefinition(information)
        problem.setStartAndGoalStates(state_of(start), state_of(goal))
        planner = geometric.RRTConnect(information)
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(min(GOAL_TIME, left))
        if problem.hasExactSolution():
            path = problem.getSolutionPath()
            found = path_quality(robot, points(path))
            geometric.PathSimplifier(information).simplifyMax(path)
            t, q = time_path(robot, points(path), dt)
            return Baseline(t, q, Status.REACHED, f"the way to goal {tried} was found", found)
    return Baseline(np.zeros(1), start[None], Status.STUCK, f"no way to any of {tried} goals was found", None)
