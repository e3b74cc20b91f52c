"""Paths along which constraints hold, closely followed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.path_metric import speed_units
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.robot import Robot

FINE = 0.006
"""Points of a path on which constraints hold exactly are this far apart, s, joint coordinates in units of their speed
limits."""


def on_constraints(robot: Robot, constraints: Sequence[Task], path: Array, spacing: float) -> Array:
    """Return a path (K, n) with points so close that it deviates little from its constraints, which hold at them.

    Points from which no configuration is found in which they hold stay where they are.

    Args:
        robot: The robot.
        constraints: What holds.
        path: Configurations (K, n) near to such ones, m and rad.
        spacing: How far apart points are at the most, s, joint coordinates in units of their speed limits.
    """
    lengths = np.linalg.norm(np.diff(path, axis=0) / speed_units(robot), axis=1)
    solver, points = InverseKinematics(robot, ()), [path[0]]
    for a, b, length in zip(path[:-1], path[1:], lengths, strict=True):
        count = max(1, int(np.ceil(length / spacing)))
        points += [a + share * (b - a) for share in np.arange(1, count + 1) / count]
    found = [solver.solve(point, constraints, -np.inf) for point in points]
    return np.array([there.q if there.reached else point for there, point in zip(found, points, strict=True)])
