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


def _length(model: pin.Model, joint: int) -> float:
    return float(np.linalg.norm(model.jointPlacements[joint].translation))


def _range(model: pin.Model, joint: int) -> float:
    """Return the range of a prismatic joint, m; 0 of others and of one without limits."""
    j = model.joints[joint]
    span = float(model.upperPositionLimit[j.idx_q] - model.lowerPositionLimit[j.idx_q])
    return span if j.shortname().startswith("JointModelP") and np.isfinite(span) else 0.0
