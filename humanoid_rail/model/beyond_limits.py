"""Robots whose motions leave the position limits: there, limits no longer keep neighbours apart.

Pairs of neighbours that cannot meet within the limits are left out of checks (:mod:`humanoid_rail.model.pairs`). A
motion that leaves these limits is checked with a robot in which the far parts of all such pairs are bodies.
"""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.far_parts import SLACK, FarParts, far_parts
from humanoid_rail.model.pairs import NO_MEETING, UncheckedPair, checked_in_part, reason_of
from humanoid_rail.model.robot import Robot

_extended: WeakKeyDictionary[Robot, tuple[Robot, Array]] = WeakKeyDictionary()


def robot_of_motion(robot: Robot, t: Array, q: Array, velocity: Array | None) -> Robot:
    """Return the robot to check a motion with: with more bodies if it leaves the limits that keep neighbours apart.

    Args:
        robot: The robot.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
        velocity: Velocities (N, n) of the cubic spline that the motion is; None for one that is linear between samples.
    """
    if not any(NO_MEETING in pair.why for pair in robot.left_out):
        return robot
    if robot not in _extended:
        _extended[robot] = _with_all_far_parts(robot)
    extended, matters = _extended[robot]
    full = _extremes(t, q, velocity) @ robot.coupling.T + robot.offset
    low, high = robot.model.lowerPositionLimit - SLACK, robot.model.upperPositionLimit + SLACK
    return extended if (((full < low) | (full > high)) & matters).any() else robot


def _extremes(t: Array, q: Array, velocity: Array | None) -> Array:
    """Return configurations (M, n) between whose least and largest coordinates a motion stays at all times."""
    if velocity is None or len(t) == 1:
        return q
    # A cubic stays within its Bezier control points.
    third = np.diff(t)[:, None] / 3.0
    return np.vstack([q, q[:-1] + third * velocity[:-1], q[1:] - third * velocity[1:]])


def _with_all_far_parts(robot: Robot) -> tuple[Robot, Array]:
    """Return a robot with the far parts that its limits keep apart as bodies, and whose limits (nq,) those are."""
    bodies = robot.collision_model.copy()
    pairs, left_out = list(robot.self_collision_pairs), list[UncheckedPair]()
    matters = np.zeros(robot.model.nq, bool)
    for pair in robot.left_out:
        found = _parts_of(robot, pair) if NO_MEETING in pair.why else []
        for parts in found:
            pairs.append((bodies.addGeometryObject(parts.first), bodies.addGeometryObject(parts.second)))
            matters[[robot.model.joints[joint].idx_q for joint in parts.joints]] = True
        left_out.append(replace(pair, why=f"{reason_of(pair)}; {checked_in_part(found[0])}") if found else pair)
    more = replace(robot, collision_model=bodies, self_collision_pairs=tuple(pairs), left_out=tuple(left_out))
    return more, matters


def _parts_of(robot: Robot, pair: UncheckedPair) -> list[FarParts]:
    """Return the far parts of two links that cannot meet within the limits, of each two of their bodies."""
    bodies = [body.copy() for body in robot.collision_model.geometryObjects]
    names = robot.link_names
    one, other = (
        [b for b, name in zip(bodies, names, strict=True) if name == link] for link in (pair.link, pair.other)
    )
    return [parts for a in one for b in other if (parts := far_parts(robot.model, a, b)) is not None]
