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


def limit_violations(robot: Robot, t: Array, q: Array) -> tuple[Violation, ...]:
    """Return for each joint the worst excess over its position limits and over its velocity limit.

    A sampled motion is linear between its samples, so its velocities are the difference quotients. Accelerations are
    not judged: a piecewise linear motion has none.

    Args:
        robot: The robot whose limits count.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
    """
    velocity = np.diff(q, axis=0) / np.diff(t)[:, None]
    found = []
    for j, joint in enumerate(robot.joint_names):
        found.append(_worst(joint, "position", t, q[:, j], robot.lower[j], robot.upper[j]))
        limit = robot.velocity_limit[j]
        found.append(_worst(joint, "velocity", t, velocity[:, j], -limit, limit))
    return tuple(violation for violation in found if violation)


def _worst(joint: str, quantity: str, t: Array, values: Array, lower: float, upper: float) -> Violation | None:
    if values.size == 0:
        return None
    excess = np.maximum(values - upper, lower - values)
    i = int(excess.argmax())
    if excess[i] <= ROUNDING:
        return None
    limit = upper if values[i] > upper else lower
    return Violation(joint, quantity, float(values[i]), float(limit), float(t[i]))
