"""Joint limits: what a sampled motion does beyond them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot

ROUNDING = 1e-9
"""Excesses up to this are rounding and do not count, m, rad, m/s and rad/s."""


@dataclass(frozen=True)
class Violation:
    """The worst excess of one joint over one of its limits."""

    joint: str
    quantity: str
    """`position` (m or rad), `velocity` (m/s or rad/s) or `acceleration` (m/s^2 or rad/s^2)."""
    value: float
    """The value farthest beyond the limit."""
    limit: float
    """The limit it is beyond."""
    t: float
    """When, in s."""


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Positions and velocities of the joints at some times."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    velocity: Array
    """(N, n), m/s and rad/s."""
    acceleration: Array | None = None
    """(N, n), m/s^2 and rad/s^2; None for a motion that is linear between its samples, and has none."""


def sampled(t: Array, q: Array) -> JointMotion:
    """Return a motion that is linear between its samples, with the velocity of the interval that begins at each."""
    velocity = np.diff(q, axis=0) / np.diff(t)[:, None]
    return JointMotion(t, q, np.vstack([velocity, np.zeros((1, q.shape[1]))]))


def limit_violations(robot: Robot, *motions: JointMotion) -> tuple[Violation, ...]:
    """Return for each joint the worst excess over its limits of position, velocity and acceleration."""
    t = np.concatenate([motion.t for motion in motions])
    q = np.vstack([motion.q for motion in motions])
    velocity = np.vstack([motion.velocity for motion in motions])
    found = [
        *_worst(robot, "position", t, q, robot.lower, robot.upper),
        *_worst(robot, "velocity", t, velocity, -robot.velocity_limit, robot.velocity_limit),
    ]
    for motion in motions:
        if motion.acceleration is not None:
            limit = robot.acceleration_limit
            found += _worst(robot, "acceleration", motion.t, motion.acceleration, -limit, limit)
    return tuple(sorted(found, key=lambda violation: robot.joint_names.index(violation.joint)))


def _worst(robot: Robot, quantity: str, t: Array, values: Array, lower: Array, upper: Array) -> list[Violation]:
    """Return for each joint beyond its limits where it is farthest beyond them."""
    excess = np.maximum(values.max(axis=0) - upper, lower - values.min(axis=0))
    found = []
    for j in np.flatnonzero(excess > ROUNDING):
        i = int(np.maximum(values[:, j] - upper[j], lower[j] - values[:, j]).argmax())
        limit = upper[j] if values[i, j] > upper[j] else lower[j]
        found.append(Violation(robot.joint_names[j], quantity, float(values[i, j]), float(limit), float(t[i])))
    return found
