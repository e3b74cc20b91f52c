"""Smooth paths that follow polylines closely."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.path_metric import speed_units, without_standstill
from humanoid_rail.model.robot import Robot

DEGREE = 3
"""The spline is cubic."""
FEWEST = 8
"""A path has at least this many control points, so that a short path has a beginning, a middle and an end."""
CHECKS = 8
"""The distance of a smooth path from a polyline is checked at this many points on each piece."""


def smooth_path(robot: Robot, path: Array, spacing: float) -> BSpline:
    """Return the variation-diminishing spline of a path (Marsden and Schoenberg 1966).

    The control points of a cubic spline, which turns and accelerates continuously, are put on the path, at the averages
    of its knots. Straight parts of the path stay as they are, corners are rounded over about two spacings, and the ends
    stay. The parameter is the length of the path in s, joint coordinates in units of their speed limits.

    Args:
        robot: The robot.
        path: Configurations (K, n), m and rad, that do not all coincide.
        spacing: Length between control points, s, or less.
    """
    s, path = _by_length(robot, path)
    pieces = max(FEWEST - DEGREE, int(np.ceil(s[-1] / spacing)))
    inner = np.linspace(0.0, s[-1], pieces + 1)
    knots = np.concatenate([[0.0] * DEGREE, inner, [s[-1]] * DEGREE])
    averages = np.array([knots[i + 1 : i + 1 + DEGREE].mean() for i in range(len(knots) - DEGREE - 1)])
    control = np.column_stack([np.interp(averages, s, column) for column in path.T])
    control[[0, -1]] = path[[0, -1]]
    return BSpline(knots, control, DEGREE)


def deviation(robot: Robot, path: Array, smooth: BSpline) -> float:
    """Return how far a smooth path is from the path (K, n) it was made of, at the same lengths, in s.

    Joint coordinates are in units of their speed limits. No point is farther from the path.
    """
    s, path = _by_length(robot, path)
    looks = np.linspace(0.0, s[-1], CHECKS * len(smooth.c))
    there = np.column_stack([np.interp(looks, s, column) for column in path.T])
    return float((np.linalg.norm((smooth(looks) - there) / speed_units(robot), axis=1)).max())


def _by_length(robot: Robot, path: Array) -> tuple[Array, Array]:
    """Return lengths (k,) from the start and the points (k, n) of a path there, each farther than the one before."""
    path = without_standstill(robot, path)
    lengths = np.linalg.norm(np.diff(path, axis=0) / speed_units(robot), axis=1)
    return np.concatenate([[0.0], np.cumsum(lengths)]), path
