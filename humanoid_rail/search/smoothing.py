"""Paths, polylines in q: how long they are, how sharply they turn, how corners are rounded and how a path is timed.

Lengths and angles are in joint coordinates, each in units of its speed limit, so that a length is in seconds: at the
speed limits no path takes longer.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.search.effort import PathQuality

LONGEST_CUT = 0.2
"""A corner is cut off no farther than this from it, s."""
SHORTEST_CUT = 1e-4
"""Nor nearer, s: what cannot be cut off there stays as it is."""
MAX_TURN = np.deg2rad(15.0)
"""The most that a timed path turns from one sample interval to the next, rad, where corners are rounded."""
PIECE_TURN = np.deg2rad(6.0)
"""How much the pieces of a rounded corner turn from one to the next, about, rad."""
SHORTEST = 1e-3
"""The shortest last interval between samples, as a share of dt: a shorter one would have a speed of rounding errors."""
SLOWER, SLOWDOWNS = 1.5, 20
"""How much more time a part of a path gets where its samples stray from it, and how often."""
STANDSTILL = 1e-9
"""Shorter pieces of a path have no direction, and a shorter path is none, s."""


def speed_units(robot: Robot) -> Array:
    """Return what each joint coordinate is measured in (n,): its speed limit, 1 where it has none."""
    limit = robot.velocity_limit
    return np.where(np.isfinite(limit) & (limit > 0), limit, 1.0)


def path_length(robot: Robot, path: Array) -> float:
    """Return the length of a path (K, n), s."""
    _, lengths = _pieces(robot, path)
    return float(lengths.sum())


def turns(robot: Robot, path: Array) -> Array:
    """Return the angles between the pieces of a path (K, n) that follow each other, rad; K - 2 if none stands still."""
    return _angles(*_pieces(robot, path))


def _pieces(robot: Robot, path: Array) -> tuple[Array, Array]:
    """Return the pieces (K - 1, n) of a path in units of the speed limits, and their lengths (K - 1,), s."""
    pieces: Array = np.diff(path, axis=0) / speed_units(robot)
    return pieces, np.sqrt(np.einsum("kn,kn->k", pieces, pieces))


def _angles(pieces: Array, lengths: Array) -> Array:
    directions = pieces[lengths > STANDSTILL] / lengths[lengths > STANDSTILL, None]
    # More precise for small angles than an arc cosine.
    half = np.linalg.norm(np.diff(directions, axis=0), axis=1) / 2
    angles: Array = 2 * np.arcsin(np.clip(half, 0.0, 1.0))
    return angles


def path_quality(robot: Robot, *paths: Array) -> PathQuality:
    """Return what paths (K, n) that follow each other are like; turns where one ends do not count."""
    found = [_pieces(robot, path) for path in paths]
    return PathQuality(
        sum(float(lengths.sum()) for _, lengths in found),
        max(float(_angles(*pieces).max(initial=0.0)) for pieces in found),
    )


def without_standstill(robot: Robot, path: Array) -> Array:
    """Return a path (K, n) without the points at which it has not moved since the one before; its ends stay."""
    points = path / speed_units(robot)
    if (np.linalg.norm(np.diff(points, axis=0), axis=1) > STANDSTILL).all():
        return path
    kept = [0]
    for i in range(1, len(path)):
        if np.linalg.norm(points[i] - points[kept[-1]]) > STANDSTILL:
            kept.append(i)
    return path[[*kept[: max(1, len(kept) - 1)], len(path) - 1]]


def round_corners(robot: Robot, path: Array, holds_between: Callable[[Array, Array], bool]) -> Array:
    """Return a path (K, n) whose corners are cut off by parabolas.

    Each begins and ends equally far from its corner, at most halfway to the next one, and nearer where the straight
    pieces it is drawn with do not hold.

    Args:
        robot: The robot.
        path: The corners and both ends.
        holds_between: Whether the straight way between two configurations (n,) is one that the robot may go.
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
            if all(holds_between(a * units, b * units) for a, b in zip(reached, curve, strict=False)):
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
    robot: Robot, path: Array, dt: float, holds_between: Callable[[Array, Array], bool] | None = None
) -> tuple[Array, Array]:
    """Return times (N,) in s and configurations (N, n) at them: as fast as the speed limits let a path be followed.

    Where a path turns it is followed so slowly that it turns by no more than MAX_TURN in dt, and that the straight ways
    between the samples, which cut its curves short, hold. Accelerations are not limited.

    Args:
        robot: The robot.
        path: Configurations (K, n), m and rad.
        dt: Time between samples, s.
        holds_between: Whether the straight way between two configurations (n,) is one that the robot may go.
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
    for _ in range(SLOWDOWNS):
        arrival = np.concatenate([[0.0], np.cumsum(durations)])
        t = np.append(dt * np.arange(int(np.ceil(arrival[-1] / dt - SHORTEST))), arrival[-1])
        q = np.column_stack([np.interp(t, arrival, column) for column in path.T])
        piece = np.clip(np.searchsorted(arrival, t, side="right") - 1, 0, len(steps) - 1)
        slower = set()
        for k in np.flatnonzero(np.diff(piece)):
            if holds_between is not None and not holds_between(q[k], q[k + 1]):
                slower |= set(range(piece[k], piece[k + 1] + 1))
        for k in np.flatnonzero(turns(robot, q) > MAX_TURN):
            if shares[piece[k] + 1 : piece[k + 2] + 1].any():
                slower |= set(range(piece[k], piece[k + 2] + 1))
        if not slower:
            break
        durations[list(slower)] *= SLOWER
    return t, q
