"""A profile that is always there: half of the acceleration for speeding up, half of it for turning.

Along a path q(s) a joint has the acceleration q' s_ddot + q'' s_dot^2. If the first part takes at most half of its
limit and the second the other half, what is possible at one place does not depend on the direction of s_ddot. So the
largest s_dot follows from a pass forwards and one backwards, and standing still is always within the limits.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from humanoid_rail._arrays import Array

SHARE = 0.5
"""Speeding up may take this share of the limit of acceleration, and turning the rest."""


def cautious_speed(path: BSpline, grid: Array, velocity: Array, acceleration: Array, turning: Array) -> Array:
    """Return s_dot (G,) at a grid, from rest to rest, larger than 0 in between.

    Args:
        path: q(s) (n,), m and rad, three times differentiable but for its knots.
        grid: s (G,), G not less than 3.
        velocity: Limits (n,), m/s and rad/s.
        acceleration: Limits (n,), m/s^2 and rad/s^2.
        turning: The part of limits of jerk (n,) that turning may take, m/s^3 and rad/s^3; may be infinite.
    """
    slope, bend, twist = (abs(path(grid, order)) for order in (1, 2, 3))
    squares = np.minimum.reduce(
        [
            _least(velocity, slope) ** 2,
            _least((1.0 - SHARE) * acceleration, bend),
            _least(turning, twist) ** (2.0 / 3.0),
        ]
    )
    rates = _least(SHARE * acceleration, slope)
    gains = 2.0 * np.diff(grid) * np.minimum(rates[1:], rates[:-1])
    squares[[0, -1]] = 0.0
    for i, gain in enumerate(gains):
        squares[i + 1] = min(squares[i + 1], squares[i] + gain)
    for i, gain in reversed(list(enumerate(gains))):
        squares[i] = min(squares[i], squares[i + 1] + gain)
    speed: Array = np.sqrt(squares)
    return speed


def _least(limit: Array, share: Array) -> Array:
    """Return the least limit (G,) in units of the shares (G, n) that joints have; large where none has one."""
    none = np.full(share.shape, np.finfo(float).max ** 0.25)
    found: Array = np.minimum(np.divide(limit, share, out=none, where=share > 0.0), none.max()).min(axis=1)
    return found
