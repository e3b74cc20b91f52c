"""What tasks need to know of the hands beside their state, and how they keep vectors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import FARTHEST, Array, checked_array, triple
from humanoid_rail.kinematics.state import State


def hand_drift(state: State, hand: str, velocity: Array) -> tuple[Array, Array, Array]:
    """Return the linear and angular acceleration of a hand (3,) while q_dot is constant, and its angular velocity (3,).

    In the base frame, m/s^2, rad/s^2 and rad/s.

    Args:
        state: The robot at q.
        hand: Name of the hand.
        velocity: q_dot (n,), m/s and rad/s.
    """
    robot = state.robot
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(
        model, data, robot.full_configuration(state.q), robot.coupling @ np.asarray(velocity), np.zeros(model.nv)
    )
    frame = model.getFrameId(robot.hands[robot.hand(hand)].frame)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    pin.updateFramePlacement(model, data, frame)
    acceleration = pin.getFrameClassicalAcceleration(model, data, frame, aligned)
    return acceleration.linear, acceleration.angular, pin.getFrameVelocity(model, data, frame, aligned).angular


def keep_vectors(task: object, *names: str) -> None:
    """Keep vectors of a task as tuples of three finite numbers.

    Raises:
        InvalidInput: If one is none.
    """
    for name in names:
        object.__setattr__(task, name, triple(checked_array(name, getattr(task, name), (3,), most=FARTHEST)))


def rows_of(hand: int) -> slice:
    """Return the rows of a hand in the Jacobians of a state."""
    return slice(3 * hand, 3 * hand + 3)


def unit(vector: Sequence[float]) -> Array:
    """Return a vector (3,) with a length of 1."""
    along: Array = np.array(vector, float) / np.linalg.norm(vector)
    return along
