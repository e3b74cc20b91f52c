"""Position actuators for simulators: gains that suit what each joint has to move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.io.mujoco.inertias import mended_inertias
from humanoid_rail.model.robot import Robot

BANDWIDTH = 20.0
"""Natural frequency of every actuator, Hz. The tracking errors grow with its inverse square."""


@dataclass(frozen=True)
class PositionActuator:
    """The actuator of a joint: force = kp (ctrl - q) - kv q_dot."""

    joint: str
    kp: float
    """N/m or N m/rad."""
    kv: float
    """N s/m or N m s/rad."""
    effort_limit: float
    """Of the whole force, N or N m; infinite where the URDF has none or 0."""


def gravity_load(robot: Robot, q: Array) -> Array:
    """Return the forces that hold the robot against gravity, S^T g (N, n), N and N m.

    Args:
        robot: The robot. Its passive joints are held by those that they follow.
        q: Configurations (N, n), m and rad.
    """
    model = mended_inertias(robot).model
    data = model.createData()
    return np.array(
        [pin.computeGeneralizedGravity(model, data, robot.full_configuration(sample)) for sample in q]
    ) @ np.asarray(robot.coupling)


def needed_forces(robot: Robot, q: Array, velocity: Array, acceleration: Array) -> Array:
    """Return the forces that move the robot so (N, n), N and N m, those against gravity included.

    Args:
        robot: The robot. Its passive joints are moved by those that they follow.
        q: Configurations (N, n), m and rad.
        velocity: (N, n), m/s and rad/s.
        acceleration: (N, n), m/s^2 and rad/s^2.
    """
    model, S = mended_inertias(robot).model, np.asarray(robot.coupling)
    data = model.createData()
    samples = zip(q, velocity, acceleration, strict=True)
    return np.array([S.T @ pin.rnea(model, data, robot.full_configuration(at), S @ v, S @ a) for at, v, a in samples])


def position_actuators(robot: Robot, q: Array) -> tuple[PositionActuator, ...]:
    """Return a critically damped actuator for each actuated joint.

    With the largest inertia I that the joint sees in any of the configurations, the other joints held, and the natural
    frequency w, kp = I w^2 and kv = 2 I w.

    Args:
        robot: The robot.
        q: Configurations (N, n) of the motion, m and rad.

    Raises:
        InvalidInput: If a joint moves something with a negative moment of inertia.
    """
    model, S = mended_inertias(robot).model, robot.coupling
    data = model.createData()
    seen = np.zeros(robot.n)
    for sample in q:
        upper = np.triu(pin.crba(model, data, robot.full_configuration(sample)))
        inertia = upper + np.triu(upper, 1).T
        seen = np.maximum(seen, np.einsum("ji,jk,ki->i", S, inertia, S))
    w = 2 * np.pi * BANDWIDTH
    limits = [float(model.effortLimit[model.joints[model.getJointId(name)].idx_v]) for name in robot.joint_names]
    return tuple(
        PositionActuator(name, float(inertia * w**2), float(2 * inertia * w), limit if limit > 0 else np.inf)
        for name, inertia, limit in zip(robot.joint_names, seen, limits, strict=True)
    )
