"""Cubic splines in time whose limits hold at all times, and what is proven of them.

A uniform cubic B-spline lies in the convex hull of its control points, and its derivatives in those of theirs, which
are their first, second and third differences (de Boor 1978). So a motion whose control points keep within the limits of
position, and their differences within those of velocity, acceleration and jerk, keeps within all of them at all times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.model.robot import Robot
from humanoid_rail.collision.motion_bound import Travel

SAGITTA = 4e-6
"""How far the straight pieces that a spline is replaced by to certify it may be from it, m and rad ..."""
SHORTEST, MOST = 1e-3, 10_000
"""... unless they were shorter than this, s, or more in an interval than this."""

Certify = Callable[[Robot, tuple[Obstacle, ...], Array, Array], Certificate]
"""Certifies a motion that is linear in q between its samples (:func:`humanoid_rail.certification.certify`)."""


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


def fastest_in_between(velocity: Array, acceleration: Array, dt: float) -> Array:
    """Return the velocity (N, n) that is largest in size from each sample to before the next, from the samples."""
    # The velocity of a piece is a parabola: largest at an end, or where the acceleration, which is linear, is 0.
    a, b = acceleration[:-1], acceleration[1:]
    vertex = velocity[:-1] - np.divide(dt * a**2, 2.0 * (b - a), out=np.zeros_like(a), where=a * b < 0)
    larger = abs(vertex) > abs(velocity[:-1])
    return np.vstack([np.where(larger, vertex, velocity[:-1]), velocity[-1:]])


def peaks(velocity: Array, acceleration: Array, dt: float) -> tuple[Array, Array, Array]:
    """Return the largest velocity, acceleration and jerk (n,) in size, at all times, of a spline from its samples."""
    jerk = np.diff(acceleration, axis=0) / dt
    fastest = fastest_in_between(velocity, acceleration, dt)
    return abs(fastest).max(axis=0), abs(acceleration).max(axis=0), abs(jerk).max(axis=0, initial=0.0)


def certify_spline(
    robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array, velocity: Array, certify: Certify
) -> Certificate:
    """Return what can be proven of the cubic spline through positions and velocities.

    The spline is replaced by short straight pieces. Of these the engine proves what it can; by how much a link of the
    spline strays from them is bounded, and taken off twice, because both bodies of a pair may stray.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        t: Times (N,), ever later, s.
        q: Configurations (N, n), m and rad.
        velocity: Velocities (N, n), m/s and rad/s.
        certify: The engine's certificate of straight pieces.
    """
    if len(t) < 2:
        return certify(robot, obstacles, t, q)
    spline = CubicHermiteSpline(t, q, velocity)
    fine, change = _cut(t, spline)
    places = spline(fine)
    certificate = certify(robot, obstacles, fine, places)
    if certificate.clearance_bound is None:
        return certificate
    bound = certificate.clearance_bound - 2.0 * straying(robot, fine, places, change)
    return replace(certificate, clearance_bound=bound, certified=certificate.certified and bound > 0)


def _cut(t: Array, spline: CubicHermiteSpline) -> tuple[Array, Array]:
    """Return times (M,) between which a spline is nearly straight, and bounds (M - 1, n) of |q''| there."""
    lengths = np.diff(t)
    # In an interval q'' is linear, so that it is largest at an end; at a knot each side has its own.
    begins, slopes = 2.0 * spline.c[1], 6.0 * spline.c[0]
    largest = np.maximum(abs(begins), abs(begins + slopes * lengths[:, None]))
    pieces = np.ceil(lengths * np.sqrt(largest.max(axis=1) / (8.0 * SAGITTA)))
    pieces = np.clip(pieces, 1, np.clip(np.ceil(lengths / SHORTEST), 1, MOST)).astype(int)
    interval = np.repeat(np.arange(len(lengths)), pieces)
    within = np.arange(len(interval)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    fine = np.append(t[interval] + lengths[interval] * within / pieces[interval], t[-1])
    return fine, largest[interval]


def straying(robot: Robot, t: Array, q: Array, acceleration: Array) -> float:
    """Return how far a point of a link of a cubic spline can be from where straight pieces of it have it, m.

    A cubic is at most max |q''| dt^2 / 8 from its chord. Each joint is moved by that in turn.

    Args:
        robot: The robot.
        t: Times at which the pieces meet (N,), s.
        q: Configurations there (N, n), m and rad.
        acceleration: Bounds of |q''| on each piece (N - 1, n), m/s^2 and rad/s^2.
    """
    sagitta = acceleration * np.diff(t)[:, None] ** 2 / 8.0
    travel = Travel(robot)
    slide = abs(robot.coupling) @ (abs(q).max(axis=0) + sagitta.max(axis=0)) + abs(robot.offset)
    levers = np.array([travel.reach(column, slide, 0).travel.max() for column in robot.coupling.T])
    return float((sagitta @ levers).max())
