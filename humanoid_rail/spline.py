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

from humanoid_rail.arrays import Array
from humanoid_rail.certificate import Certificate
from humanoid_rail.obstacles import Obstacle
from humanoid_rail.robot import Robot
from humanoid_rail.travel import Travel

PIECE = 2.5e-3
"""Length of the pieces that a spline is replaced by to certify it, s, or less."""

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


def peaks(velocity: Array, acceleration: Array, dt: float) -> tuple[Array, Array, Array]:
    """Return the largest velocity, acceleration and jerk (n,) in size, at all times, of a spline from its samples."""
    jerk = np.diff(acceleration, axis=0) / dt
    # The velocity of a piece is a parabola: largest at an end, or where the acceleration, which is linear, is 0.
    a, b = acceleration[:-1], acceleration[1:]
    turns = a * b < 0
    vertex = velocity[:-1] - np.divide(a**2, 2.0 * jerk, out=np.zeros_like(a), where=turns)
    fastest = np.maximum(abs(velocity).max(axis=0), np.where(turns, abs(vertex), 0.0).max(axis=0, initial=0.0))
    return fastest, abs(acceleration).max(axis=0), abs(jerk).max(axis=0, initial=0.0)


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
    pieces = max(1, int(np.ceil(np.diff(t).max() / PIECE - 1e-9)))
    share = np.arange(pieces) / pieces
    fine = np.append((t[:-1, None] + np.diff(t)[:, None] * share).ravel(), t[-1])
    spline = CubicHermiteSpline(t, q, velocity)
    certificate = certify(robot, obstacles, fine, spline(fine))
    if certificate.clearance_bound is None:
        return certificate
    bound = certificate.clearance_bound - 2.0 * straying(robot, fine, spline(fine), spline(fine, 2))
    return replace(certificate, clearance_bound=bound, certified=certificate.certified and bound > 0)


def straying(robot: Robot, t: Array, q: Array, acceleration: Array) -> float:
    """Return how far a point of a link of a spline can be from where straight pieces between samples have it, m.

    A cubic is at most max |q''| dt^2 / 8 from its chord; its second derivative is linear. Each joint is moved by that
    in turn.

    Args:
        robot: The robot.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
        acceleration: At the samples (N, n), m/s^2 and rad/s^2.
    """
    sagitta = np.maximum(abs(acceleration[:-1]), abs(acceleration[1:])) * np.diff(t)[:, None] ** 2 / 8.0
    travel = Travel(robot)
    slide = abs(robot.coupling) @ (abs(q).max(axis=0) + sagitta.max(axis=0)) + abs(robot.offset)
    levers = np.array([travel.reach(column, slide, 0).travel.max() for column in robot.coupling.T])
    return float((sagitta @ levers).max())
