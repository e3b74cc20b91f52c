"""Goal configurations: where their search begins, and how they are brought near to the start."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.inverse_kinematics import Posture
from humanoid_rail.kinematics.path_metric import speed_units
from humanoid_rail.model.robot import Robot

Solve = Callable[[Array], Posture]
"""Inverse kinematics that begins at a configuration (n,)."""

WIDEST = 10.0
"""Joints without position limits are sampled within this distance of the start, m and rad."""
PULLS = 8
"""A goal is pulled towards the start at most this often."""


def seeds(robot: Robot, start: Array, random: np.random.Generator) -> Iterator[Array]:
    """Yield the start (n,), and then without end random configurations on the straight lines from it to anywhere.

    Joints whose speed limit is 0 stay where they are.
    """
    moves = robot.velocity_limit > 0
    lower = np.where(moves, np.maximum(robot.lower, start - WIDEST), start)
    upper = np.where(moves, np.minimum(robot.upper, start + WIDEST), start)
    yield start
    while True:
        yield start + random.random() * (random.uniform(lower, upper) - start)


def pull(robot: Robot, goal: Array, start: Array, solve: Solve, deadline: float = np.inf) -> Array:
    """Return a goal (n,) nearer to a start (n,), or the same one, by looking again and again from between the two.

    Args:
        robot: The robot.
        goal: Configuration (n,), m and rad.
        start: Configuration (n,).
        solve: Inverse kinematics.
        deadline: When to stop, on the clock of `time.perf_counter`, s.
    """
    units = speed_units(robot)
    share, length = 0.5, float(np.linalg.norm((goal - start) / units))
    for _ in range(PULLS):
        if time.perf_counter() > deadline:
            break
        posture = solve(goal + share * (start - goal))
        nearer = float(np.linalg.norm((posture.q - start) / units))
        if posture.reached and nearer < length:
            goal, length = posture.q, nearer
        else:
            share /= 2
    return goal
