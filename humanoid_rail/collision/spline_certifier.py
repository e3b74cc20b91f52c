"""Proves a motion along a cubic spline free of contact, by the straight pieces that it is nearly made of."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import certify
from humanoid_rail.collision.motion_bound import MotionBound
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

SAGITTA = 4e-6
"""The straight pieces that a spline is replaced by may be this far from it, m and rad."""
SHORTEST_PIECE = 1e-3
"""A straight piece is not made shorter than this, s."""
MAX_PIECES = 10_000
"""An interval between samples is not cut into more pieces than this."""


def certify_spline(robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array, velocity: Array) -> Certificate:
    """Return what can be proven of the cubic spline through positions and velocities.

    The spline is replaced by short straight pieces. Of these the engine proves what it can; by how much a link of the
    spline strays from them is bounded, and taken off twice, because both bodies of a pair may stray.

    Args:
        robot: The robot.
        obstacles: What its links must not touch, beside each other.
        t: Times (N,), strictly increasing, s.
        q: Configurations (N, n), m and rad.
        velocity: Velocities (N, n), m/s and rad/s.
    """
    if len(t) < 2:
        return certify(robot, obstacles, t, q)
    # Imported here: it takes longer than the whole package.
    from scipy.interpolate import CubicHermiteSpline

    spline = CubicHermiteSpline(t, q, velocity)
    fine, change = _cut(t, spline)
    places = spline(fine)
    certificate = certify(robot, obstacles, fine, places)
    if certificate.clearance_bound is None:
        return certificate
    bound = certificate.clearance_bound - 2.0 * deviation_from_chords(robot, fine, places, change)
    return replace(certificate, clearance_bound=bound, certified=certificate.certified and bound > 0)


def _cut(t: Array, spline: CubicHermiteSpline) -> tuple[Array, Array]:
    """Return times (M,) between which a spline is nearly straight, and bounds (M - 1, n) of |q''| there."""
    lengths = np.diff(t)
    # In an interval q'' is linear, so that it is largest at an end; at a knot each side has its own.
    begins, slopes = 2.0 * spline.c[1], 6.0 * spline.c[0]
    largest = np.maximum(abs(begins), abs(begins + slopes * lengths[:, None]))
    pieces = np.ceil(lengths * np.sqrt(largest.max(axis=1) / (8.0 * SAGITTA)))
    pieces = np.clip(pieces, 1, np.clip(np.ceil(lengths / SHORTEST_PIECE), 1, MAX_PIECES)).astype(int)
    interval = np.repeat(np.arange(len(lengths)), pieces)
    within = np.arange(len(interval)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    fine = np.append(t[interval] + lengths[interval] * within / pieces[interval], t[-1])
    return fine, largest[interval]


def deviation_from_chords(robot: Robot, t: Array, q: Array, acceleration: Array) -> float:
    """Return how far a point of a link of a cubic spline can be from where straight pieces of it have it, m.

    A cubic is at most max |q''| dt^2 / 8 from its chord. Each joint is moved by that in turn.

    Args:
        robot: The robot.
        t: Times at which the pieces meet (N,), s.
        q: Configurations there (N, n), m and rad.
        acceleration: Bounds of |q''| on each piece (N - 1, n), m/s^2 and rad/s^2.
    """
    sagitta = acceleration * np.diff(t)[:, None] ** 2 / 8.0
    bound = MotionBound(robot)
    slide = abs(robot.coupling) @ (abs(q).max(axis=0) + sagitta.max(axis=0)) + abs(robot.offset)
    levers = np.array([bound.displacements(column, slide, 0).length.max() for column in robot.coupling.T])
    return float((sagitta @ levers).max())
