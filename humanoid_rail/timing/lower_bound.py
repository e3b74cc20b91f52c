"""How long motions take at least: as long as each joint alone needs for its way, from rest to rest."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.result import Motion


def least_times(way: Array, velocity: Array, acceleration: Array) -> Array:
    """Return how long each joint takes at least (...), s, from rest to rest.

    The fastest is to accelerate as long as the limits let it, and to brake as long: a trapezoid, or a triangle where
    the velocity limit is not reached.

    Args:
        way: How far it goes (...), m and rad.
        velocity: Limits (...), m/s and rad/s; may be infinite.
        acceleration: Limits (...), m/s^2 and rad/s^2; may be infinite.
    """
    way = np.abs(way)
    velocity, acceleration = (np.broadcast_to(limit, way.shape) for limit in (velocity, acceleration))
    with np.errstate(divide="ignore", invalid="ignore"):  # no way, or no limit
        triangle = 2.0 * np.sqrt(way / acceleration)
        rise = np.where(np.isfinite(velocity), velocity / acceleration, np.inf)
        trapezoid = np.where(np.isfinite(velocity), way / velocity + np.where(np.isfinite(rise), rise, 0.0), 0.0)
        found: Array = np.where(way > 0.0, np.where(way > velocity * rise, trapezoid, triangle), 0.0)
    return found


def least_duration(stops: Array, velocity: Array, acceleration: Array) -> float:
    """Return how long a motion takes at least, s, that rests at configurations (K, n) in turn."""
    return float(least_times(np.diff(stops, axis=0), velocity, acceleration).max(axis=1, initial=0.0).sum())


def least_duration_of(motion: Motion, arrivals: Sequence[float], velocity: Array | None) -> float | None:
    """Return how long a motion takes at least that is at its targets, and rests at them, as this one does, s.

    None if it is unknown.

    Args:
        motion: The motion. If it has a timing, that has the limits.
        arrivals: When it is at its targets, s.
        velocity: The limits of one without a timing (n,), whose accelerations have none.
    """
    if motion.timing is not None:
        limits = np.array([(peak.velocity_limit, peak.acceleration_limit) for peak in motion.timing.peaks])
    elif velocity is not None:
        limits = np.column_stack([velocity, np.full(len(velocity), np.inf)])
    else:
        return None
    if len(limits) != len(motion.joint_names):
        return None
    stops = [0, *(int(np.argmin(abs(motion.t - arrival))) for arrival in arrivals), len(motion.t) - 1]
    still = 0.0 if motion.timing is None else abs(motion.timing.velocity[stops]).max(axis=1)
    rests = np.broadcast_to(still == 0.0, len(stops))
    return least_duration_through(motion.q[stops], rests, *limits.T)


def least_duration_through(points: Array, rests: NDArray[np.bool_], velocity: Array, acceleration: Array) -> float:
    """Return how long a motion takes at least, s, that is at configurations in turn and rests at some of them.

    Args:
        points: The configurations (K, n), m and rad. It rests at the first and at the last.
        rests: At which ones it rests (K,).
        velocity: Limits (n,), m/s and rad/s.
        acceleration: Limits (n,), m/s^2 and rad/s^2.
    """
    at = np.flatnonzero(rests)
    ends = np.unique([0, *at, len(points) - 1])
    if len(ends) == len(points):
        return least_duration(points, velocity, acceleration)
    return sum(
        max(
            least_duration_along(points[a : b + 1], velocity, acceleration, np.zeros_like(velocity)),
            # At full speed all the way, but from each one to the next as long as the slowest joint needs.
            least_duration(points[a : b + 1], velocity, np.full_like(acceleration, np.inf)),
        )
        for a, b in pairwise(ends)
    )


def least_duration_along(path: Array, velocity: Array, acceleration: Array, stray: Array) -> float:
    """Return how long a motion from rest to rest takes at least, s, that stays near a path.

    A joint that turns back on its way rests there for a moment, so its ways between count one by one.

    Args:
        path: Configurations (K, n), m and rad.
        velocity: Limits (n,), m/s and rad/s.
        acceleration: Limits (n,), m/s^2 and rad/s^2.
        stray: How far each joint may be from the path (n,), m and rad.
    """
    ways, joints = [np.abs(path[-1] - path[0])], [np.arange(path.shape[1])]
    for j, column in enumerate(path.T):
        moves = column[np.flatnonzero(np.diff(column, append=np.inf))]
        steps = np.diff(moves)
        turns = np.concatenate([moves[:1], moves[1:-1][steps[:-1] * steps[1:] < 0.0], moves[-1:]])
        ways.append(np.maximum(np.abs(np.diff(turns)) - 2.0 * stray[j], 0.0))
        joints.append(np.full(len(turns) - 1, j))
    joint = np.concatenate(joints)
    times = least_times(np.concatenate(ways), velocity[joint], acceleration[joint])
    count = path.shape[1]
    direct, along = times[:count], np.bincount(joint[count:], times[count:], count)
    return float(np.maximum(direct, along).max())
