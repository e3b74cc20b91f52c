"""How far the points of links can get while the joints move at constant rates.

This is the reference; `engine/travel.cpp` has the same in C++.

Seen from the body of a joint further in, the origin of joint j is x_j = x_i + R_i c for the joint i before it, with a
constant offset c. With the rates constant, |w_i| <= turn_i and |w_dot_i| <= twist_i,

    |x_j'|  <= |x_i'|  + turn_i |c|
    |x_j''| <= |x_i''| + (twist_i + turn_i^2) |c|

and so on to the points of a link. Turns about parallel axes add up with their signs (a chest that stays level does not
turn); the others at most in size: w = sum_r w_r a_r, where each axis a_r is carried by the turns before it, so that
turn = sum_r |w_r| and twist = sum_r |w_r| sum_{s < r} |w_s|. A sliding joint, c + a q, adds |q'| and 2 turn |q'|.

Source: bounds of this kind are those of conservative advancement (Mirtich 1996; Zhang, Lee and Kim 2006).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot

# Angles between axes that are parallel up to rounding, rad.
PARALLEL = 1e-9


class Reach(NamedTuple):
    """For the points of all links (L,), when the joints move at constant rates for a unit of time."""

    travel: Array
    """The longest way, m."""
    curvature: Array
    """The largest second derivative by that time, m."""


class _Joint(NamedTuple):
    parent: int
    slides: bool
    offset: float
    """From the parent's origin, at 0, m."""
    parallel: float
    """1 or -1 where the axis is parallel to that of the parent's turn, else 0."""


@dataclass
class _Motion:
    """What is known of the body of a joint."""

    travel: float = 0.0
    curvature: float = 0.0
    turn: float = 0.0
    twist: float = 0.0
    turn_before: float = 0.0
    """Without the latest run of turns about parallel axes."""
    twist_before: float = 0.0
    run: float = 0.0
    """That run, with its sign."""


class Travel:
    """Bounds from the lengths of the links and the rates of the joints alone, valid in every configuration."""

    def __init__(self, robot: Robot) -> None:
        model = robot.model
        data = model.createData()
        pin.computeJointJacobians(model, data, pin.neutral(model))
        # The axis about which each body turned last: where two are parallel in one configuration they are in all.
        axes = np.zeros((model.njoints, 3))
        self._joints = [_Joint(0, False, 0.0, 0.0)]
        for j in range(1, model.njoints):
            parent, axis = model.parents[j], data.J[3:, model.joints[j].idx_v]
            slides = bool(np.linalg.norm(axis) < PARALLEL)
            parallel = not slides and axes[parent].any() and np.linalg.norm(np.cross(axis, axes[parent])) < PARALLEL
            sign = float(np.sign(axis @ axes[parent])) if parallel else 0.0
            offset = float(np.linalg.norm(model.jointPlacements[j].translation))
            self._joints.append(_Joint(parent, slides, offset, sign))
            axes[j] = axes[parent] if slides else axis
        bodies = robot.collision_model.geometryObjects
        self._joint_of = [body.parentJoint for body in bodies]
        self._extent = [_extent(body) for body in bodies]

    def reach(self, change: Array, slide: Array, origin: int) -> Reach:
        """Return how far the links get relative to the body of a joint; those it does not carry do not move.

        Args:
            change: How far the joints move (nv,), m and rad.
            slide: The farthest that each is from 0 on the way (nv,), m and rad.
            origin: The joint, 0 for the base.
        """
        motions = {origin: _Motion()}
        for j, joint in enumerate(self._joints):
            if j > origin and joint.parent in motions:
                motions[j] = _carried(motions[joint.parent], joint, float(change[j - 1]), float(slide[j - 1]))
        travel, curvature = np.zeros(len(self._extent)), np.zeros(len(self._extent))
        for link, (joint_of, extent) in enumerate(zip(self._joint_of, self._extent, strict=True)):
            if (motion := motions.get(joint_of)) is not None:
                travel[link] = motion.travel + motion.turn * extent
                curvature[link] = motion.curvature + (motion.twist + motion.turn**2) * extent
        return Reach(travel, curvature)


def _carried(before: _Motion, joint: _Joint, rate: float, slide: float) -> _Motion:
    """Return the motion of a joint's body from that of the body which carries it."""
    bend = before.twist + before.turn**2
    if joint.slides:
        offset = joint.offset + slide
        return _Motion(
            before.travel + before.turn * offset + abs(rate),
            before.curvature + bend * offset + 2.0 * before.turn * abs(rate),
            before.turn,
            before.twist,
            before.turn_before,
            before.twist_before,
            before.run,
        )
    turn, twist, run = (before.turn_before, before.twist_before, joint.parallel * before.run)
    if joint.parallel == 0.0:
        turn, twist, run = before.turn, before.twist, 0.0
    run += rate
    return _Motion(
        before.travel + before.turn * joint.offset,
        before.curvature + bend * joint.offset,
        turn + abs(run),
        twist + turn * abs(run),
        turn,
        twist,
        run,
    )


def _extent(body: pin.GeometryObject) -> float:
    """Return how far the points that decide about a body's distances are from the origin of its joint, m.

    Those of a capsule are its axis: a distance from a capsule is one from its axis less the radius.
    """
    middle = body.placement.translation
    if isinstance(body.geometry, coal.Capsule):
        half = body.geometry.halfLength * body.placement.rotation[:, 2]
        return float(max(np.linalg.norm(middle + half), np.linalg.norm(middle - half)))
    body.geometry.computeLocalAABB()
    return float(np.linalg.norm(body.placement.act(body.geometry.aabb_center)) + body.geometry.aabb_radius)
