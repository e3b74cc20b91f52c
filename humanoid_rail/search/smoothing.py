"""Smoothing: rounds the corners of a path and times it within the speed limits.

Lengths and angles are those of `kinematics/path_metric.py`, in joint coordinates in units of their speed limits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.path_metric import speed_units, turns, without_standstill
from humanoid_rail.model.robot import Robot

LONGEST_CUT = 0.2
"""A corner is cut off at most this far from it, s."""
SHORTEST_CUT = 1e-4
"""A corner that cannot be cut off at least this far from it stays as it is, s."""
MAX_TURN = np.deg2rad(15.0)
"""The most that a timed path turns from one sample interval to the next, rad, where corners are rounded."""
PIECE_TURN = np.deg2rad(6.0)
"""The pieces of a rounded corner turn by about this angle from one to the next, rad."""
SHORTEST = 1e-3
"""The shortest last interval between samples, as a share of dt: a shorter one would have a speed of rounding errors."""
SLOWER = 1.5
"""A part of a path whose samples stray from it gets this many times the time."""
SLOWDOWNS = 20
"""A part of a path is slowed down at most this often."""


def round_corners(robot: Robot, path: Array, is_edge_valid: Callable[[Array, Array], bool]) -> Array:
    """Return a path (K, n) whose corners are cut off by parabolas.

    Each begins and ends equally far from its corner, at most halfway to the next one, and nearer where the straight
    pieces it is drawn with are not valid edges.

    Args:
        robot: The robot.
        path: The corners and both ends.
        is_edge_valid: Whether the straight edge between two configurations (n,) keeps the distance.
    """
    units = speed_units(robot)
    points = without_standstill(robot, path) / units
    rounded = [points[0]]
    for before, corner, after in zip(points[:-2], points[1:-1], points[2:], strict=True):
        arriving, leaving = float(np.linalg.norm(corner - before)), float(np.linalg.norm(after - corner))
        into, out = (corner - before) / arriving, (after - corner) / leaving
        turn = 2 * float(np.arcsin(min(1.0, float(np.linalg.norm(out - into)) / 2)))
        cut = min(LONGEST_CUT, arriving / 2, leaving / 2)
        while turn > PIECE_TURN and cut >= SHORTEST_CUT:
            curve = _parabola(corner, into, out, turn, cut)
            reached = [rounded[-1], *curve]
            if all(is_edge_valid(a * units, b * units) for a, b in zip(reached, curve, strict=False)):
                rounded += curve
                break
            cut /= 2
        else:
            rounded.append(corner)
    return np.array([*rounded, points[-1]]) * units


def _parabola(corner: Array, into: Array, out: Array, turn: float, cut: float) -> list[Array]:
    """Return points on the parabola that leaves one straight line for another, turning equally between them.

    With s = sin(a) / (sin(a) + sin(turn - a)) its tangent, (1 - s) into + s out, has turned by a.
    """
    angles = np.linspace(0.0, turn, int(np.ceil(turn / PIECE_TURN)) + 1)
    ahead, behind = np.sin(angles), np.sin(turn - angles)
    s = np.divide(ahead, ahead + behind, out=np.linspace(0.0, 1.0, angles.size), where=ahead + behind > 1e-12)
    return [corner - cut * (1 - x) ** 2 * into + cut * x**2 * out for x in s]


def time_path(
    robot: Robot, path: Array, dt: float, is_edge_valid: Callable[[Array, Array], bool] | None = None
) -> tuple[Array, Array]:
    """Return times (N,) in s and configurations (N, n) at them: as fast as the speed limits let a path be followed.

    Where a path turns it is followed so slowly that it turns by no more than MAX_TURN in dt, and that the edges between
    the samples, which cut its curves short, are valid; where slowing down does not help, the certificate decides.
    Accelerations are not limited.

    Args:
        robot: The robot.
        path: Configurations (K, n), m and rad.
        dt: Time between samples, s.
        is_edge_valid: Whether the straight edge between two configurations (n,) keeps the distance.
    """
    path = without_standstill(robot, path)
    steps = np.diff(path, axis=0)
    if not steps.any():
        return np.zeros(1), path[:1]
    angles = np.concatenate([[0.0], turns(robot, path), [0.0]])
    # A rounded corner is shared by its pieces; one that could not be rounded is not slowed down for.
    shares = np.where(angles <= 2 * PIECE_TURN, angles, 0.0)
    durations = np.maximum(
        np.max(abs(steps) / speed_units(robot), axis=1), dt * (shares[:-1] + shares[1:]) / 2 / (MAX_TURN - PIECE_TURN)
    )
    # The shortest path has two samples too.
    durations *= max(1.0, SHORTEST * dt / durations.sum())
    for _ in range(SLOWDOWNS):
        arrival = np.concatenate([[0.0], np.cumsum(durations)])
        t = np.append(dt * np.arange(max(1, int(np.ceil(arrival[-1] / dt - SHORTEST)))), arrival[-1])
        q = np.column_stack([np.interp(t, arrival, column) for column in path.T])
        piece = np.clip(np.searchsorted(arrival, t, side="right") - 1, 0, len(steps) - 1)
        slower = set()
        for k in np.flatnonzero(np.diff(piece)):
            if is_edge_valid is not None and not is_edge_valid(q[k], q[k + 1]):
                slower |= set(range(piece[k], piece[k + 1] + 1))
        for k in np.flatnonzero(turns(robot, q) > MAX_TURN):
            if shares[piece[k] + 1 : piece[k + 2] + 1].any():
                slower |= set(range(piece[k], piece[k + 2] + 1))
        if not slower:
            break
        durations[list(slower)] *= SLOWER
    return t, q
