"""How far the arms of a robot reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin


def arm_reach(model: pin.Model, frame_name: str, arm: Sequence[str]) -> float:
    """Return how far an arm reaches from its first joint, or the hand from the base if that is nothing, m.

    That is the sum of the lengths between its joints and of the ranges of those that are prismatic.

    Args:
        model: All joints.
        frame_name: The frame of the hand.
        arm: The joints of the arm.
    """
    frame = model.frames[model.getFrameId(frame_name)]
    chain = list(model.supports[frame.parentJoint])[1:]
    first = min((chain.index(j) for j in map(model.getJointId, arm) if j in chain), default=0)
    tool = float(np.linalg.norm(frame.placement.translation))
    reach = tool + sum(_length(model, j) for j in chain[first + 1 :]) + sum(_range(model, j) for j in chain[first:])
    return reach or sum(_length(model, j) for j in chain)


def farthest_from_base(model: pin.Model, frame_names: Sequence[str]) -> float:
    """Return a distance from the base that no point of these frames exceeds, m.

    That is the sum of all lengths on the way there, and of how far prismatic joints go.

    Args:
        model: All joints.
        frame_names: The frames.
    """
    return max(_farthest(model, model.frames[model.getFrameId(name)]) for name in frame_names)


def _farthest(model: pin.Model, frame: pin.Frame) -> float:
    chain = list(model.supports[frame.parentJoint])[1:]
    tool = float(np.linalg.norm(frame.placement.translation))
    return tool + sum(_length(model, j) + _travel(model, j) for j in chain)


def _travel(model: pin.Model, joint: int) -> float:
    """Return how far a prismatic joint goes from 0, m; 0 of others and of one without limits."""
    j = model.joints[joint]
    most = float(max(abs(model.lowerPositionLimit[j.idx_q]), abs(model.upperPositionLimit[j.idx_q])))
    return most if j.shortname().startswith("JointModelP") and np.isfinite(most) else 0.0


def _length(model: pin.Model, joint: int) -> float:
    return float(np.linalg.norm(model.jointPlacements[joint].translation))


def _range(model: pin.Model, joint: int) -> float:
    """Return the range of a prismatic joint, m; 0 of others and of one without limits."""
    j = model.joints[joint]
    span = float(model.upperPositionLimit[j.idx_q] - model.lowerPositionLimit[j.idx_q])
    return span if j.shortname().startswith("JointModelP") and np.isfinite(span) else 0.0
