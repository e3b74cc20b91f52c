"""How fast a smooth path can be followed, from rest to rest, by toppra.

s(t), with s the parameter of the path, is looked for. Along it a joint has the velocity q' s_dot, the acceleration
q' s_ddot + q'' s_dot^2 and the jerk q' s_dddot + 3 q'' s_dot s_ddot + q''' s_dot^3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.timing.cautious_profile import cautious_speed

GRID_POINTS = (4, 6, 3)
"""Each piece of a path has this many grid points; the later numbers are used where toppra finds nothing before."""
TURNING_SHARE = 0.5
"""The turning of the path may take this share of the jerk limit."""


class Limits(NamedTuple):
    """What joints can do; infinite where there is no limit."""

    velocity: Array
    """(n,), m/s and rad/s."""
    acceleration: Array
    """(n,), m/s^2 and rad/s^2."""
    jerk: Array
    """(n,), m/s^3 and rad/s^3."""

    def without_jerk(self) -> Limits:
        """Return the same without those of jerk."""
        return self._replace(jerk=np.full_like(self.jerk, np.inf))


def limits_of(robot: Robot) -> Limits:
    """Return what the joints of a robot can do."""
    return Limits(robot.velocity_limit, robot.acceleration_limit, robot.jerk_limit)


class Progress(NamedTuple):
    """How a path is followed."""

    duration: float
    """s."""
    position: Callable[[Array], Array]
    """s at times (N,) in s."""


class Profile(NamedTuple):
    """How a path is followed with a constant s_ddot between any two points of a grid. G points."""

    grid: Array
    """s (G,)."""
    speed: Array
    """s_dot (G,)."""
    rate: Array
    """s_ddot (G - 1,)."""
    arrival: Array
    """When it is at the points of the grid (G,), s."""


def fastest_profile(path: BSpline, limits: Limits) -> Profile:
    """Return the fastest profile within limits of velocity and acceleration (Pham and Pham 2018).

    With a limit of jerk it is slower where the path turns, so that turning takes no more than its share of that limit.

    Args:
        path: q(s) (n,), m and rad, three times differentiable but for its knots.
        limits: Of velocity and acceleration, finite for the joints that move, and of jerk.

    Where toppra finds none, as where limits are out of all proportion to each other, it is the cautious one of
    :mod:`humanoid_rail.timing.cautious_profile`, which is a little slower.
    """
    knots = np.unique(path.t)
    for pieces in GRID_POINTS:
        grid = np.append((knots[:-1, None] + np.diff(knots)[:, None] * np.arange(pieces) / pieces).ravel(), knots[-1])
        speed = _speed(path, grid, limits)
        if speed is not None:
            return _profile(grid, speed)
    # Fine enough that in between nothing differs much.
    grid = np.unique(np.concatenate([grid, (grid[1:] + grid[:-1]) / 2.0]))
    # What does not move may have a limit of 0.
    moves = np.ptp(path(grid), axis=0) > 0
    velocity, acceleration, jerk = (np.where(moves, limit, np.inf) for limit in limits)
    return _profile(grid, cautious_speed(path, grid, velocity, acceleration, TURNING_SHARE * jerk))


def _profile(grid: Array, speed: Array) -> Profile:
    arrival = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(grid) / (speed[1:] + speed[:-1]))])
    return Profile(grid, speed, np.diff(speed**2) / (2.0 * np.diff(grid)), arrival)


def averaged(profile: Profile, window: float) -> Progress:
    """Return the mean of a profile over the `window` before each moment, s, so that accelerations do not jump.

    Before the start and after the end it rests.
    """
    grid, speed, rate, arrival = profile
    end, lengths = float(arrival[-1]), np.diff(arrival)
    areas = lengths * (grid[:-1] + lengths * (speed[:-1] / 2.0 + lengths * rate / 6.0))
    passed = np.concatenate([[0.0], np.cumsum(areas)])

    def place(t: Array) -> tuple[Array, Array]:
        """Return s at times, and its integral up to then."""
        k = np.clip(np.searchsorted(arrival, t, side="right") - 1, 0, len(rate) - 1)
        since = np.clip(t, 0.0, end) - arrival[k]
        s = grid[k] + since * (speed[k] + since * rate[k] / 2.0)
        return s, passed[k] + since * (grid[k] + since * (speed[k] / 2.0 + since * rate[k] / 6.0))

    def position(t: Array) -> Array:
        s, area = place(t)
        if window > 0.0:
            _, before = place(t - window)
            # Before the start it is at the start, and after the end at the end.
            waiting = grid[0] * np.clip(window - t, 0.0, None) + grid[-1] * np.clip(t - end, 0.0, None)
            s = (area - before + waiting) / window
        return np.clip(s, grid[0], grid[-1])

    return Progress(end + window, position)


def rise_time(path: BSpline, profile: Profile, limits: Limits) -> float:
    """Return how long joints take to come to the largest accelerations of a profile within limits of jerk, s."""
    slope, turning = path(profile.grid, 1)[:-1], path(profile.grid, 2)[:-1]
    peak = abs(slope * profile.rate[:, None] + turning * profile.speed[:-1, None] ** 2).max(axis=0)
    return float((peak / limits.jerk).max())


def _speed(path: BSpline, grid: Array, limits: Limits) -> Array | None:
    """Return the largest s_dot at the grid, within limits of velocity and acceleration (Pham and Pham 2018)."""
    # Imported here: it brings matplotlib, and planning does without it.
    from toppra.algorithm import TOPPRA
    from toppra.constraint import (
        DiscretizationType,
        JointAccelerationConstraint,
        JointVelocityConstraint,
        JointVelocityConstraintVarying,
    )
    from toppra.interpolator import AbstractGeometricPath

    class Path(AbstractGeometricPath):  # type: ignore[misc]
        dof = path.c.shape[1]
        path_interval = grid[[0, -1]]

        def __call__(self, s: Any, order: int = 0) -> Any:
            return path(s, order)

    velocity, acceleration, unit = _scaled(path, grid, limits)

    def speeds(s: float) -> Array:
        """Return limits of velocity (n, 2) at s, at which turning takes no more than its share of the limit of jerk."""
        slope, turning = abs(path(s, 1)), abs(path(s, 3))
        jerk = np.divide(TURNING_SHARE * limits.jerk, turning, out=np.full_like(turning, np.inf), where=turning > 0)
        limit = np.minimum(velocity, np.maximum(slope, 1e-3 * slope.max()) * np.cbrt(jerk.min()) * unit)
        return np.column_stack([-limit, limit])

    constraints = [
        JointVelocityConstraintVarying(speeds)
        if np.isfinite(limits.jerk).any()
        else JointVelocityConstraint(np.column_stack([-velocity, velocity])),
        # Held at both ends of each interval of the grid: in between the acceleration hardly differs from linear.
        JointAccelerationConstraint(np.column_stack([-acceleration, acceleration]), DiscretizationType.Interpolation),
    ]
    _, speed, _ = TOPPRA(constraints, Path(), gridpoints=grid).compute_parameterization(0.0, 0.0)
    if speed is None or not np.isfinite(speed).all() or (speed[1:] + speed[:-1] <= 0).any():
        return None
    found: Array = np.maximum(speed, 0.0) / unit
    return found


def _scaled(path: BSpline, grid: Array, limits: Limits) -> tuple[Array, Array, float]:
    """Return limits of velocity and acceleration that are finite and not 0, and the unit of time that they are in, s.

    Where there are none they are larger than what can be reached. In this unit of time numbers are neither large nor
    small: it is what the way takes, or less.
    """
    way = abs(np.diff(path(grid), axis=0)).sum(axis=0)
    moves = way > 0
    acceleration = np.where(moves, limits.acceleration, 1.0)
    # From rest to rest no joint gets faster than this; a limit far beyond what matters would spoil the numbers.
    reachable = 2.0 * np.sqrt(acceleration * np.where(moves, way, 1.0))
    velocity = np.where(moves, np.minimum(limits.velocity, reachable), 1.0)
    unit = float(np.maximum(way / velocity, np.sqrt(way / acceleration)).max())
    return unit * velocity, unit**2 * acceleration, unit
