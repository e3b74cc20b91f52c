"""Follows the velocity of `qp` step by step; each step is proven free of contact before it is made.

The velocity is held for dt, as by the controller of a robot: the motion is linear in q between its samples, and what is
proven of it is proven of the motion that a robot makes. The native engine does all of it
(`engine/resolution/rollout.cpp`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Contact
from humanoid_rail.collision.certifier import named_contact
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
from humanoid_rail.result import Status


def rollout(
    kinematics: NativeKinematics,
    start: Array,
    tasks: Sequence[Task],
    gains: Gains,
    safety: Safety,
    settings: Settings,
    constraints: Sequence[Task] = (),
) -> Integration:
    """Move from the start until |e| falls to the tolerance or the motion cannot go on.

    Other Python threads run meanwhile.

    Args:
        kinematics: The robot among its obstacles.
        start: Configuration (n,) at t = 0.
        tasks: What is to be reached.
        gains: Parameters of eq. 4.9.
        safety: Parameters of the constraints.
        settings: When to end, and how long a step is; the integrator's tolerances do not matter.
        constraints: What is kept. Their rows are equalities, and each step is brought back onto them.
    """
    state_at, K = kinematics.state_for_callback, gains.diagonal(count_rows(tasks))
    stack = native_tasks(kinematics.robot, tasks, state_at)
    converted = (
        native_gains(kinematics.robot, gains, stack.rows, state_at),
        native_safety(safety, state_at, native_tasks(kinematics.robot, constraints, state_at) if constraints else None),
        native_settings(settings, K),
    )
    motion, overrun = kinematics.native.rollout(start, stack, *converted)
    contact = None if overrun is None else named_contact(kinematics.robot, kinematics.obstacles, overrun)
    status, t = status_of(motion.status), motion.t
    remains = what_remains(kinematics.state(motion.q[-1], t[-1]), tasks, motion.left)
    reason = explain_rollout(status, t[-1], remains, motion.evaluations, settings, contact)
    if status is Status.STALLED and (safety.equalities or constraints):
        what = "equalities" if safety.equalities else "constraints"
        reason += f", or none that does and satisfies the {what}"
    return Integration(t, motion.q, status, reason, motion.evaluations, JointMotion(*motion.visited))


def explain_rollout(
    status: Status, end: float, remains: str, evaluations: int, settings: Settings, contact: Contact | None
) -> str:
    """Return a status in a sentence, with numbers.

    Args:
        status: What became of the tasks.
        end: T, s.
        remains: What remains to be done there, in words.
        evaluations: Number of steps.
        settings: Tolerance and longest motion.
        contact: What runs into the robot and when, if something does.
    """
    where = f"{remains} at {settings.at(end)}"
    match status:
        case Status.STALLED:
            return f"{where}: no velocity that keeps clear and within the limits brings the hands nearer"
        case Status.PLANNING_TIMEOUT:
            return f"{where}, where planning was cut off by {settings.planning_time_option}"
        case Status.OVERRUN if contact is not None:
            return f"{where}, and even standing still {replace(contact, t=settings.begun + contact.t)}"
        case Status.OVERRUN:
            return f"{where}, and neither a step nor standing still can be shown to be free of contact"
        case _:  # the others end an integration too
            return explain(status, end, remains, evaluations, settings)
