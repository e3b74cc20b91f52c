"""How long paths are and how sharply they turn.

A path is a polyline in q. Lengths and angles are in joint coordinates, each in units of its speed limit, so a length is
in seconds: at the speed limits no path takes longer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot

STANDSTILL = 1e-9
"""Pieces of a path that are shorter than this have no direction, and a shorter path is no path, s."""


@dataclass(frozen=True)
class PathQuality:
    """The length of a path and its sharpest turn, in joint coordinates in units of their speed limits."""

    length: float
    """Sum of the norms of dq / speed limit, s: at the speed limits no path takes longer."""
    sharpest_turn: float
    """The largest angle between two pieces, or two steps between samples, that follow each other, rad."""


def speed_units(robot: Robot) -> Array:
    """Return the unit of each joint coordinate (n,): its speed limit, or 1 where it has none."""
    return robot.speed_units


def path_length(robot: Robot, path: Array) -> float:
    """Return the length of a path (K, n), s."""
    _, lengths = _pieces(robot, path)
    return float(lengths.sum())


def least_travel_time(robot: Robot, path: Array) -> float:
    """Return how long a path (K, n) takes at least, s: in each of its pieces some joint moves at its speed limit."""
    return float(abs(np.diff(path, axis=0) / speed_units(robot)).max(axis=1).sum())


def turns(robot: Robot, path: Array) -> Array:
    """Return the angles between successive pieces of a path (K, n), rad; K - 2 of them if no piece stands still."""
    return _angles(*_pieces(robot, path))


def path_quality(robot: Robot, *paths: Array) -> PathQuality:
    """Return the quality of paths (K, n) that follow each other; turns where one ends do not count."""
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
