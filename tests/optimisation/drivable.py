"""Whether a drive can follow a motion, by SciPy."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import Robot, Trajectory

MS = 1e-3
EXCESS = 1e-6


def assert_within_limits(robot: Robot, motion: Trajectory) -> None:
    """Hold a motion against the limits at 1 ms, evaluated by SciPy; and it rests at both ends."""
    assert motion.timing is not None
    spline = CubicHermiteSpline(motion.t, motion.q, motion.timing.velocity)
    t = np.append(np.arange(0.0, motion.duration, MS), motion.duration)
    assert (spline(t) <= robot.upper + EXCESS).all()
    assert (spline(t) >= robot.lower - EXCESS).all()
    assert (abs(spline(t, 1)) <= robot.velocity_limit * (1.0 + EXCESS)).all()
    assert (abs(spline(t, 2)) <= robot.acceleration_limit * (1.0 + EXCESS)).all()
    ends = [0, -1]
    assert not motion.timing.velocity[ends].any()
    assert not motion.timing.acceleration[ends].any()
    # Accelerations are continuous: the cubics' at both sides of a sample are those of the timing.
    np.testing.assert_allclose(spline(motion.t[:-1] + 1e-9, 2), motion.timing.acceleration[:-1], atol=1e-4)
    np.testing.assert_allclose(spline(motion.t[1:] - 1e-9, 2), motion.timing.acceleration[1:], atol=1e-4)
