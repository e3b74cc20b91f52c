"""Proves a motion free of contact, or finds the first contact; `humanoid_rail/collision/` has the proof."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from humanoid_rail._arrays import FARTHEST, Array
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.errors import InvalidInput, check_kind, told_apart
from humanoid_rail.holding.phases import certify_motion, sampled_motion
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot, check_joint_names
from humanoid_rail.planning.event_checks import checked_events
from humanoid_rail.planning.kept import deviations_of, kept_in_scene
from humanoid_rail.planning.start import warn_of_depth
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory

SAME_PLACE = 1e-6
"""Two computed places that are this near to each other are the same, m."""


class SampledMotion(Protocol):
    """Anything with times and configurations: a :class:`humanoid_rail.Trajectory`, or what another tool made."""

    @property
    def t(self) -> Array:
        """Times (N,), strictly increasing, s."""
        ...

    @property
    def q(self) -> Array:
        """Configurations (N, n), m and rad."""
        ...


def verify(robot: Robot, scene: Scene, trajectory: SampledMotion, *, max_checks: int | None = None) -> Certificate:
    """Prove that a motion touches no obstacle and that no links touch each other, including between samples.

    The motion is linear in q between its samples, whatever made it, or the cubic spline through positions and
    velocities if it has a :class:`humanoid_rail.Timing`. Of its events it is believed which hands grasp and release
    what and when, and what an object may touch meanwhile, which the certificate names; where objects are follows from
    the scene and the motion. Nothing else of the trajectory is believed. Joint limits are not looked at, nor is what
    comes after the last sample; see docs/safety.md.

    Args:
        robot: The robot.
        scene: The scene with the obstacles; those that move start at t = 0.
        trajectory: Times and configurations, from :func:`plan`, :func:`read_trajectory` or anywhere else.
        max_checks: How many distances may be measured. Most motions need some thousands; two million if not given.

    Returns:
        The certificate. Where there is contact it says where the first one is, and the bound is negative. Where the
        checks were used up it is not certified, and its reason says so. `deviations` bounds how far the motion leaves
        what the scene keeps (`Step.keep`), as it is when each step begins.

    Raises:
        InvalidInput: If the trajectory has other joints than the robot, its times or configurations are not valid, or
            `max_checks` is no whole number greater than 0.
        EngineMissing: If there is no native engine.
    """
    check_kind("robot", robot, Robot)
    check_kind("scene", scene, Scene)
    t, q, velocity = _checked_motion(robot, trajectory)
    warn_of_depth(robot, scene)
    motion = sampled_motion(robot, t, q, velocity, checked_events(robot, scene, t, getattr(trajectory, "events", ())))
    kept = kept_in_scene(robot, scene, t, q, getattr(trajectory, "arrivals", None))
    certificate = certify_motion(robot, scene, motion, max_checks)
    return replace(certificate, deviations=deviations_of(robot, kept, t, q, velocity))


def _checked_motion(robot: Robot, trajectory: SampledMotion) -> tuple[Array, Array, Array | None]:
    """Return times (N,), configurations (N, n) and velocities (N, n), or None for a motion that is linear.

    Raises:
        InvalidInput: If they are none, or not for this robot.
    """
    try:
        t, q = np.array(trajectory.t, float), np.array(trajectory.q, float)
    except (AttributeError, TypeError, ValueError) as error:
        valid = f"something with times t (N,) and configurations q (N, n), such as a Trajectory ({error})"
        raise InvalidInput("trajectory", trajectory, valid) from error
    check_joint_names(robot, getattr(trajectory, "joint_names", None) or robot.joint_names)
    if q.ndim != 2 or q.shape[1] != robot.n or not len(q):
        raise InvalidInput("trajectory.q", q.shape, f"an array of shape (N, {robot.n}), N not less than 1")
    if t.shape != (len(q),):
        raise InvalidInput("trajectory.t", t.shape, f"an array of shape ({len(q)},), a time for each configuration")
    velocity = _velocity(trajectory, q)
    _check_numbers(t, q, velocity)
    return t, q, velocity


def _velocity(trajectory: SampledMotion, q: Array) -> Array | None:
    timing = getattr(trajectory, "timing", None)
    try:
        velocity = None if timing is None else np.array(timing.velocity, float)
    except (AttributeError, TypeError, ValueError) as error:
        valid = f"something with velocities (N, n), such as a Timing, or None ({error})"
        raise InvalidInput("trajectory.timing", timing, valid) from error
    if velocity is not None and velocity.shape != q.shape:
        raise InvalidInput("trajectory.timing.velocity", velocity.shape, f"an array of the shape of q, {q.shape}")
    return velocity


def _check_numbers(t: Array, q: Array, velocity: Array | None) -> None:
    for name, values in (("t", t), ("q", q), *([("timing.velocity", velocity)] if velocity is not None else [])):
        size = abs(values)
        if not size.max() <= FARTHEST:  # nor if one is no number
            valid = f"finite numbers, at most {FARTHEST:g} in size: beyond that double precision tells little"
            raise InvalidInput(f"trajectory.{name}", float(values[~(size <= FARTHEST)][0]), valid)
    if (t[1:] <= t[:-1]).any():
        k = int(np.flatnonzero(t[1:] <= t[:-1])[0]) + 1
        before = told_apart(float(t[k - 1]), float(t[k]))
        raise InvalidInput(f"trajectory.t[{k}]", float(t[k]), f"a time after {before}, that of the sample before")


def check_robot(robot: Robot, trajectory: Trajectory) -> None:
    """Check that a trajectory is one of a robot: by its joints, its hands, and where these start.

    Raises:
        InvalidInput: If it is not.
    """
    check_kind("trajectory", trajectory, Trajectory)
    check_kind("robot", robot, Robot)
    check_joint_names(robot, trajectory.joint_names)
    if trajectory.hand_names != robot.hand_names:
        valid = f"those of the robot: {', '.join(robot.hand_names)}"
        raise InvalidInput("trajectory.hand_names", trajectory.hand_names, valid)
    if trajectory.samples.robot is robot:
        return  # the hands are this robot's, computed or not
    there = Kinematics(robot).hand_positions(trajectory.q[0])
    if not np.allclose(trajectory.hands[0], there, rtol=0.0, atol=SAME_PLACE):
        valid = f"where this robot has its hands then, {there.tolist()}: the robot that the motion was planned for"
        raise InvalidInput("trajectory.hands[0]", trajectory.hands[0].tolist(), valid)
