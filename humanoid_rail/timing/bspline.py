"""Uniform cubic B-splines in time, whose limits hold at all times.

A uniform cubic B-spline lies in the convex hull of its control points, and its derivatives in those of theirs, which
are their first, second and third differences (de Boor 1978). So a motion whose control points keep within the limits of
position, and their differences within those of velocity, acceleration and jerk, keeps within all of them at all times.
"""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array


def samples(control: Array, dt: float) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations (N, n) of a spline at its knots, from its N + 2 control points.

    Args:
        control: Control points (N + 2, n), m and rad.
        dt: Time between knots, s.
    """
    before, here, after = control[:-2], control[1:-1], control[2:]
    # Written as deviations, so that where nothing moves not even rounding does.
    q: Array = here + ((before - here) + (after - here)) / 6.0
    velocity: Array = (after - before) / (2.0 * dt)
    acceleration: Array = ((after - here) - (here - before)) / dt**2
    return q, velocity, acceleration


def samples_between(control: Array, dt: float, places: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations (P, n) of a spline at places (P,), as numbers of its knots.

    See :func:`samples` for the other arguments.
    """
    first = np.clip(places.astype(int), 0, len(control) - 4)
    u = (places - first)[:, None]
    a, b, c, d = (control[first + k] for k in range(4))
    ab, bc, cd = b - a, c - b, d - c
    bent, bends = bc - ab, cd - bc
    q: Array = b + (bc - ab) / 6.0 + u * ((ab + bc) / 2.0 + u * (bent / 2.0 + u * (bends - bent) / 6.0))
    velocity: Array = ((ab + bc) / 2.0 + u * (bent + u * (bends - bent) / 2.0)) / dt
    acceleration: Array = (bent + u * (bends - bent)) / dt**2
    return q, velocity, acceleration


def fastest_in_between(velocity: Array, acceleration: Array, dt: float | Array) -> Array:
    """Return the velocity (N, n) that is largest in size from each sample to before the next, from the samples.

    The time between samples is one, or (N - 1, 1), s.
    """
    # The velocity of a piece is a parabola: largest at an end, or where the acceleration, which is linear, is 0.
    a, b = acceleration[:-1], acceleration[1:]
    vertex = velocity[:-1] - np.divide(dt * a**2, 2.0 * (b - a), out=np.zeros_like(a), where=a * b < 0)
    larger = abs(vertex) > abs(velocity[:-1])
    return np.vstack([np.where(larger, vertex, velocity[:-1]), velocity[-1:]])


def peaks(velocity: Array, acceleration: Array, dt: float | Array) -> tuple[Array, Array, Array]:
    """Return the largest velocity, acceleration and jerk (n,) in size, at all times, of a spline from its samples.

    The time between samples is one, or (N - 1, 1), s.
    """
    jerk = np.diff(acceleration, axis=0) / dt
    fastest = fastest_in_between(velocity, acceleration, dt)
    return abs(fastest).max(axis=0), abs(acceleration).max(axis=0), abs(jerk).max(axis=0, initial=0.0)
