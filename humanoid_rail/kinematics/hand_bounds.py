"""How fast a hand can move and turn, and how much that can change, from the rates of the joints alone.

Seen from the body of a joint further in, the origin of joint j is x_j = x_i + R_i c for the joint i before it, with a
constant c. With |w_i| <= turn_i and |w_dot_i| <= twist_i,

    |x_j'|  <= |x_i'|  + turn_i |c|
    |x_j''| <= |x_i''| + (twist_i + turn_i^2) |c|

and so on to the hand. A sliding joint, c + a q, adds |q'| and |q''| + 2 turn |q'|. Turns about parallel axes that
follow each other add up with their signs, the others in size: w = sum_r w_r a_r, and each axis a_r is carried by the
turns before it, so that turn = sum_r |w_r| and twist = sum_r (|w_r'| + |w_r| sum_{s < r} |w_s|). These are the bounds
of `engine/collision/motion_bound.cpp`, there for the points of links and constant rates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot

PARALLEL = 1e-9
"""Axes whose sine is below this are parallel up to rounding."""


class Rates(NamedTuple):
    """What is known of all joints of the model on N pieces of a motion; the values between are in the convex hulls."""

    velocity: Array
    """Control points of the velocities (N, 3, nv), m/s and rad/s."""
    acceleration: Array
    """Control points of the accelerations (N, 2, nv), m/s^2 and rad/s^2."""
    farthest: Array
    """The farthest that each joint is from 0 (N, nv), m and rad."""


class HandMotion(NamedTuple):
    """Bounds for the point of a hand and its frame on N pieces of a motion."""

    speed: Array
    """(N,), m/s."""
    acceleration: Array
    """(N,), m/s^2."""
    turn: Array
    """Of the angular velocity (N,), rad/s."""
    twist: Array
    """Of the angular acceleration (N,), rad/s^2."""

    def of_point(self, offset: float) -> HandMotion:
        """Return the same for a point of the hand that is this far from its own, m."""
        speed = self.speed + self.turn * offset
        return self._replace(speed=speed, acceleration=self.acceleration + (self.twist + self.turn**2) * offset)


class _Joint(NamedTuple):
    parent: int
    v: int
    slides: bool
    offset: float
    """From the parent's origin, at 0, m."""
    parallel: float
    """1 or -1 where the axis is parallel to that of the turn before, else 0."""


class HandBounds:
    """Bounds on the motion of a robot's hands, valid in every configuration."""

    def __init__(self, robot: Robot) -> None:
        model = robot.model
        data = model.createData()
        pin.computeJointJacobians(model, data, pin.neutral(model))
        axes, self._joints = [np.zeros(3)], [_Joint(0, 0, False, 0.0, 0.0)]
        for j in range(1, model.njoints):
            parent, v = model.parents[j], model.joints[j].idx_v
            axis, before = data.J[3:, v].copy(), axes[model.parents[j]]
            slides = bool(np.linalg.norm(axis) < PARALLEL)
            parallel = not slides and before.any() and np.linalg.norm(np.cross(axis, before)) < PARALLEL
            sign = float(np.sign(axis @ before)) if parallel else 0.0
            offset = float(np.linalg.norm(model.jointPlacements[j].translation))
            self._joints.append(_Joint(parent, v, slides, offset, sign))
            axes.append(before if slides else axis)
        frames = [model.frames[model.getFrameId(hand.frame)] for hand in robot.hands]
        self._chains = [self._chain(frame.parentJoint) for frame in frames]
        self._offsets = [float(np.linalg.norm(frame.placement.translation)) for frame in frames]

    def _chain(self, joint: int) -> list[int]:
        chain = []
        while joint:
            chain.append(joint)
            joint = self._joints[joint].parent
        return chain[::-1]

    def common(self, first: int, second: int) -> int:
        """Return the outermost joint that carries two hands, 0 for the base."""
        shared = [a for a, b in zip(self._chains[first], self._chains[second], strict=False) if a == b]
        return shared[-1] if shared else 0

    def motion(self, hand: int, rates: Rates, origin: int = 0) -> HandMotion:
        """Return bounds on the motion of a hand relative to the body of a joint that carries it.

        Args:
            hand: Its number.
            rates: What is known of the joints.
            origin: The joint, 0 for the base.
        """
        none = np.zeros(len(rates.velocity))
        speed = acceleration = turn = twist = none
        turn_before = twist_before = none
        run, run_rate = np.zeros(rates.velocity.shape[:2]), np.zeros(rates.acceleration.shape[:2])
        for j in self._chains[hand]:
            if j <= origin:
                continue
            joint = self._joints[j]
            velocity, change = rates.velocity[..., joint.v], rates.acceleration[..., joint.v]
            offset = joint.offset + (rates.farthest[:, joint.v] if joint.slides else none)
            speed = speed + turn * offset
            acceleration = acceleration + (twist + turn**2) * offset
            if joint.slides:
                fastest = abs(velocity).max(axis=1)
                speed = speed + fastest
                acceleration = acceleration + abs(change).max(axis=1) + 2.0 * turn * fastest
                continue
            if not joint.parallel:
                turn_before, twist_before = turn, twist
            run, run_rate = joint.parallel * run + velocity, joint.parallel * run_rate + change
            fastest = abs(run).max(axis=1)
            turn = turn_before + fastest
            twist = twist_before + abs(run_rate).max(axis=1) + turn_before * fastest
        return HandMotion(speed, acceleration, turn, twist).of_point(self._offsets[hand])
