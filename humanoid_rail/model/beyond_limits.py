"""Robots whose motions leave the position limits: there, limits no longer keep neighbours apart.

Pairs of neighbours that cannot meet within the limits are left out of checks (:mod:`humanoid_rail.model.pairs`). A
motion that leaves these limits is checked with a robot in which the far parts of all such pairs are bodies.
"""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.far_parts import AWAY, SLACK, FarParts
from humanoid_rail.model.pairs import NO_MEETING, UncheckedPair, checked_in_part, far_pair, reason_of, said
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
        _extended[robot] = _with_far_parts(robot, np.ones(robot.model.nq, bool))
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


def robot_beyond(robot: Robot, joint: int) -> Robot:
    """Return the robot to look for motions with in which an actuated joint, by number, leaves its position limits."""
    return _with_far_parts(robot, robot.coupling[:, joint] != 0.0)[0]


def _with_far_parts(robot: Robot, leaving: Array) -> tuple[Robot, Array]:
    """Return a robot with more far parts as bodies, and whose limits (nq,) keep these apart.

    Args:
        robot: The robot.
        leaving: Of each coordinate (nq,) whether it may leave its limits. Where none between two bodies may, their
            far parts are not added.
    """
    bodies = robot.collision_model.copy()
    pairs, left_out = list(robot.self_collision_pairs), list[UncheckedPair]()
    matters = np.zeros(robot.model.nq, bool)
    for pair in robot.left_out:
        known = _known(robot, pair) if NO_MEETING in pair.why else []
        whys = []
        for parts, why in known:
            between = [] if parts is None else [robot.model.joints[joint].idx_q for joint in parts.joints]
            if parts is None or not why.startswith(NO_MEETING) or not leaving[between].any():
                whys.append(why)
                continue
            pairs.append((bodies.addGeometryObject(parts.first), bodies.addGeometryObject(parts.second)))
            matters[between] = True
            whys.append(checked_in_part(parts))
        why = said(reason_of(pair), list(dict.fromkeys(whys))) if whys else pair.why
        left_out.append(replace(pair, why=why))
    more = replace(robot, collision_model=bodies, self_collision_pairs=tuple(pairs), left_out=tuple(left_out))
    return more, matters


def _known(robot: Robot, pair: UncheckedPair) -> list[tuple[FarParts | None, str]]:
    """Return what :func:`humanoid_rail.model.pairs.far_pair` says of each two bodies of two links."""
    whole = [
        (link, body.copy())
        for link, body in zip(robot.link_names, robot.collision_model.geometryObjects, strict=True)
        if AWAY not in body.name
    ]
    one, other = ([body for name, body in whole if name == link] for link in (pair.link, pair.other))
    start = robot.full_configuration(robot.initial)
    return [far_pair(robot.model, a, b, start) for a in one for b in other]
