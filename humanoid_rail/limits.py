"""Joint limits: what a sampled motion does beyond them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from humanoid_rail.arrays import Array
from humanoid_rail.robot import Robot

# Rounding of a configuration that an integrator or a file has been through, in m, rad, m/s and rad/s.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Violation:
    """The worst excess of one joint over one of its limits."""

    joint: str
    quantity: str
    """`position` (m or rad) or `velocity` (m/s or rad/s)."""
    value: float
    """The value farthest beyond the limit."""
    limit: float
    """The limit it is beyond."""
    t: float
    """When, in s."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Where and how fast a motion is at some times."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    velocity: Array
    """(N, n), m/s and rad/s."""


def sampled(t: Array, q: Array) -> Motion:
    """Return a motion that is linear between its samples, with the velocity of the interval that begins at each."""
    velocity = np.diff(q, axis=0) / np.diff(t)[:, None]
    return Motion(t, q, np.vstack([velocity, np.zeros((1, q.shape[1]))]))


def limit_violations(robot: Robot, *motions: Motion) -> tuple[Violation, ...]:
    """Return for each joint the worst excess over its position limits and over its velocity limit.

    Accelerations are not judged: a motion that is linear between its samples has none.
    """
    t = np.concatenate([motion.t for motion in motions])
    q = np.vstack([motion.q for motion in motions])
    velocity = np.vstack([motion.velocity for motion in motions])
    found = []
    for j, joint in enumerate(robot.joint_names):
        limit = robot.velocity_limit[j]
        found.append(_worst(joint, "position", t, q[:, j], robot.lower[j], robot.upper[j]))
        found.append(_worst(joint, "velocity", t, velocity[:, j], -limit, limit))
    return tuple(violation for violation in found if violation)


def _worst(joint: str, quantity: str, t: Array, values: Array, lower: float, upper: float) -> Violation | None:
    excess = np.maximum(values - upper, lower - values)
    i = int(excess.argmax())
    if excess[i] <= ROUNDING:
        return None
    limit = upper if values[i] > upper else lower
    return Violation(joint, quantity, float(values[i]), float(limit), float(t[i]))
