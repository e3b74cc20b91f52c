"""Velocities and motions from the native engine: eq. 4.9, the QP on top of it, and what comes of following them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.joint_limits import JointMotion
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import count_rows
from humanoid_rail.resolution.integrate import Integration, Settings, explain
from humanoid_rail.resolution.native_options import native_gains, native_safety, native_settings, status_of
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.remaining import what_remains
from humanoid_rail.resolution.velocity import Gains


class VelocityField(Protocol):
    """q_dot (n,) in m/s and rad/s at a configuration (n,) in m and rad, and a time in s.

    Raises:
        ValueError: For a configuration of another size, or one that is not finite.
    """

    def __call__(self, q: Array, t: float = 0.0) -> Array:
        """Return the velocity."""
        ...


def projected_velocity(kinematics: NativeKinematics, tasks: Sequence[Task], gains: Gains) -> VelocityField:
    """Return eq. 4.9 as a function of a configuration and a time.

    Args:
        kinematics: The robot among its obstacles.
        tasks: What is to be reached.
        gains: K, c_mu, c_kappa and the activation distance.
    """
    state_at, velocity = kinematics.state_for_callback, kinematics.native.projection_velocity
    stack = native_tasks(kinematics.robot, tasks, state_at)
    converted = native_gains(kinematics.robot, gains, stack.rows, state_at)
    return lambda q, t=0.0: velocity(q, t, stack, converted)


def constrained_velocity(
    kinematics: NativeKinematics, tasks: Sequence[Task], gains: Gains, safety: Safety, dt: float
) -> VelocityField:
    """Return the velocity of `qp` as a function of a configuration and a time.

    Args:
        kinematics: The robot among its obstacles.
        tasks: What is to be reached.
        gains: K, c_mu, c_kappa and the activation distance.
        safety: Safety distance, gain of the dampers, equalities.
        dt: How long a velocity is to be held, s.
    """
    state_at, velocity = kinematics.state_for_callback, kinematics.native.velocity
    stack = native_tasks(kinematics.robot, tasks, state_at)
    converted, limits = native_gains(kinematics.robot, gains, stack.rows, state_at), native_safety(safety, state_at)
    return lambda q, t=0.0: velocity(q, t, stack, converted, limits, dt)


def integrate_natively(
    kinematics: NativeKinematics, start: Array, tasks: Sequence[Task], gains: Gains, settings: Settings
) -> Integration:
    """Integrate q_dot of eq. 4.9 in C++; see :func:`humanoid_rail.resolution.integrate.integrate`.

    Other Python threads run meanwhile.
    """
    state_at, K = kinematics.state_for_callback, gains.diagonal(count_rows(tasks))
    stack = native_tasks(kinematics.robot, tasks, state_at)
    motion = kinematics.native.integrate(
        start, stack, native_gains(kinematics.robot, gains, stack.rows, state_at), native_settings(settings, K)
    )
    status, t = status_of(motion.status), motion.t
    remains = what_remains(kinematics.state(motion.q[-1], t[-1]), tasks, motion.left)
    reason = explain(status, t[-1], remains, motion.evaluations, settings, motion.broken)
    return Integration(t, motion.q, status, reason, motion.evaluations, JointMotion(*motion.visited))
