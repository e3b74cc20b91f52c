"""How fast a motion moves, and how near that comes to the joints' limits: frozen data."""

from __future__ import annotations

from dataclasses import dataclass

from humanoid_rail._arrays import Array, FrozenArrays


@dataclass(frozen=True)
class Peak:
    """The largest velocity, acceleration and jerk of a joint, in size, and what limits them; m or rad, and s."""

    joint: str
    velocity: float
    velocity_limit: float
    """Infinite where there is none, as the other limits."""
    acceleration: float
    acceleration_limit: float
    jerk: float
    jerk_limit: float


@dataclass(frozen=True, eq=False)
class Timing(FrozenArrays):
    """The timing that :func:`humanoid_rail.retime` gives a motion. N samples, n joints.

    Between samples the motion is the cubic spline through positions and velocities. Its accelerations are continuous
    and linear between samples, so that the spline of degree five through positions, velocities and accelerations, which
    a controller may follow instead, is the same.
    """

    velocity: Array
    """At the samples (N, n), m/s and rad/s; 0 at both ends."""
    acceleration: Array
    """At the samples (N, n), m/s^2 and rad/s^2; 0 at both ends."""
    peaks: tuple[Peak, ...]
    """Of each joint, at all times and not at the samples alone."""
