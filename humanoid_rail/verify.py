"""Proves a motion free of contact, or finds the first one.

How is in `certification.py` and `sweep.py`.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from humanoid_rail.arrays import Array
from humanoid_rail.certificate import Certificate
from humanoid_rail.engines import get_engine
from humanoid_rail.errors import InvalidInput
from humanoid_rail.obstacles import FARTHEST
from humanoid_rail.robot import Robot
from humanoid_rail.scene import Scene


class SampledMotion(Protocol):
    """Anything with times and configurations: a :class:`humanoid_rail.Trajectory`, or what another tool made."""

    @property
    def t(self) -> Array:
        """Times (N,), ever later, s."""
        ...

    @property
    def q(self) -> Array:
        """Configurations (N, n), m and rad."""
        ...


def verify(robot: Robot, scene: Scene, trajectory: SampledMotion, *, engine: str = "native") -> Certificate:
    """Prove that a motion touches no obstacle and that no links touch each other, between its samples neither.

    The motion is linear in q between its samples, whatever made it. Nothing else of the trajectory is believed. Neither
    are limits looked at, nor what comes after the last sample; see docs/safety.md.

    Args:
        robot: The robot.
        scene: The scene with the obstacles; those that move start at t = 0.
        trajectory: Times and configurations, from :func:`plan`, :func:`read_trajectory` or anywhere else.
        engine: What computes it, `native` or `python`; see :func:`plan`.

    Returns:
        The certificate. Where there is contact it says where the first one is, and the bound is negative.

    Raises:
        InvalidInput: If the trajectory is for another robot, or its times or configurations are not valid.
    """
    for name, value, kind in (("robot", robot, Robot), ("scene", scene, Scene)):
        if not isinstance(value, kind):
            raise InvalidInput(name, value, f"a {kind.__name__}")
    try:
        t, q = np.array(trajectory.t, float), np.array(trajectory.q, float)
    except (AttributeError, TypeError, ValueError) as error:
        valid = f"something with times t (N,) and configurations q (N, n), such as a Trajectory ({error})"
        raise InvalidInput("trajectory", trajectory, valid) from error
    names = getattr(trajectory, "joint_names", None) or robot.joint_names
    if tuple(names) != robot.joint_names:
        raise InvalidInput("trajectory.joint_names", names, f"those of the robot: {', '.join(robot.joint_names)}")
    if q.ndim != 2 or q.shape[1] != robot.n or not len(q):
        raise InvalidInput("trajectory.q", q.shape, f"an array of shape (N, {robot.n}), N not less than 1")
    if t.shape != (len(q),):
        raise InvalidInput("trajectory.t", t.shape, f"an array of shape ({len(q)},), a time for each configuration")
    for name, values in (("t", t), ("q", q)):
        size = abs(values)
        if not size.max() <= FARTHEST:  # nor if one is no number
            valid = f"finite numbers, at most {FARTHEST:g} in size: beyond that double precision tells little"
            raise InvalidInput(f"trajectory.{name}", float(values[~(size <= FARTHEST)][0]), valid)
    if (t[1:] <= t[:-1]).any():
        k = int(np.flatnonzero(t[1:] <= t[:-1])[0]) + 1
        raise InvalidInput(f"trajectory.t[{k}]", float(t[k]), f"a time after {t[k - 1]:g}, that of the sample before")
    return get_engine(engine).certify(robot, scene.obstacles, t, q)
