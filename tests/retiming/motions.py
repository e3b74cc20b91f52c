"""What the tests of retiming look at motions with."""

from __future__ import annotations

import numpy as np
from conftest import changed
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import Robot, Trajectory

MS = 1e-3
EXCESS = 1.0 + 1e-6


def sampled(trajectory: Trajectory, dt: float = MS) -> np.ndarray:
    """Return configurations every millisecond, by SciPy."""
    assert trajectory.timing is not None
    spline = CubicHermiteSpline(trajectory.t, trajectory.q, trajectory.timing.velocity)
    return spline(np.arange(0.0, trajectory.duration, dt))


def rates(trajectory: Trajectory, order: int, dt: float = MS) -> np.ndarray:
    """Return the largest velocity, acceleration or jerk of each joint by differences of samples."""
    return abs(np.diff(sampled(trajectory, dt), order, axis=0)).max(axis=0) / dt**order


def distance_from(path: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return how far points (N, n) are from a polyline (K, n)."""
    begins, ways = path[:-1], np.diff(path, axis=0)
    squares = np.maximum((ways**2).sum(axis=1), 1e-300)
    share = np.clip(((points[:, None] - begins) * ways).sum(axis=2) / squares, 0.0, 1.0)
    return np.linalg.norm(points[:, None] - begins - share[:, :, None] * ways, axis=2).min(axis=1)


def straight(trajectory: Trajectory, robot: Robot, joint: str, way: float) -> Trajectory:
    """Return a motion of one joint alone, in place of another."""
    q = np.tile(robot.initial, (3, 1))
    q[:, robot.joint_names.index(joint)] += [0.0, 0.3 * way, way]
    return changed(trajectory, t=np.array([0.0, 1.0, 2.0]), q=q, arrivals=(2.0,))
