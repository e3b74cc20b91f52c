"""Limits of `<mimic>` joints as limits of the joints that they follow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput

ROUNDING = 1e-9
"""A limit of a follower counts if it is narrower than its leader's by more than this share of the leader's."""


@dataclass(frozen=True, eq=False)
class ActuatedLimits:
    """Limits (n,) of the actuated joints."""

    lower: Array
    """m or rad."""
    upper: Array
    """m or rad."""
    velocity: Array
    """m/s or rad/s."""
    acceleration: Array
    """m/s^2 or rad/s^2; infinite where there is none."""


@dataclass(frozen=True)
class _Follower:
    """The joint `name` is at multiplier x + offset where its leader, the actuated joint `leader`, is at x."""

    name: str
    leader: int
    multiplier: float
    offset: float
    lower: float
    upper: float
    velocity: float
    acceleration: float


def folded_limits(
    model: pin.Model, joint_names: Sequence[str], coupling: Array, offset: Array, acceleration: Array
) -> ActuatedLimits:
    """Return limits of the actuated joints within which each follower keeps its own limits too.

    Args:
        model: All joints with their limits.
        joint_names: The actuated ones.
        coupling: S (model.nv, n); a follower has one leader, so there is at most one number in its row.
        offset: s0 (model.nq,).
        acceleration: Acceleration limits (model.nv,) of all joints, infinite where there are none.

    Raises:
        InvalidInput: If a follower cannot keep its position limits anywhere in its leader's range.
    """
    actuated = [model.joints[model.getJointId(name)].idx_v for name in joint_names]
    limits = ActuatedLimits(
        model.lowerPositionLimit[actuated].copy(),
        model.upperPositionLimit[actuated].copy(),
        model.velocityLimit[actuated].copy(),
        acceleration[actuated].copy(),
    )
    for follower in _followers(model, joint_names, coupling, offset, acceleration):
        limits = _with_follower(limits, follower, joint_names[follower.leader])
    return limits


def _followers(
    model: pin.Model, joint_names: Sequence[str], coupling: Array, offset: Array, acceleration: Array
) -> Iterator[_Follower]:
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if name in joint_names:
            continue
        i, leader = joint.idx_v, int(np.argmax(abs(coupling[joint.idx_v])))
        lower, upper = float(model.lowerPositionLimit[i]), float(model.upperPositionLimit[i])
        multiplier, constant = float(coupling[i, leader]), float(offset[i])
        speed = float(model.velocityLimit[i])
        yield _Follower(name, leader, multiplier, constant, lower, upper, speed, float(acceleration[i]))


def _with_follower(limits: ActuatedLimits, follower: _Follower, leader: str) -> ActuatedLimits:
    """Return limits that are narrower where those of a follower ask for it."""
    j, multiplier = follower.leader, follower.multiplier
    if multiplier == 0.0:
        if not follower.lower - ROUNDING <= follower.offset <= follower.upper + ROUNDING:
            raise _nowhere(follower, f"it always stands at {follower.offset!r}")
        return limits
    first, last = sorted((bound - follower.offset) / multiplier for bound in (follower.lower, follower.upper))
    lower, upper = float(limits.lower[j]), float(limits.upper[j])
    rounding = ROUNDING * max(1.0, *(abs(bound) for bound in (lower, upper) if np.isfinite(bound)))
    if first > upper + rounding or last < lower - rounding:
        raise _nowhere(
            follower, f"{leader}, which it follows, can make it go only from {_reach(follower, lower, upper)}"
        )
    return replace(
        limits,
        lower=_replaced(limits.lower, j, min(first, upper) if first > lower + rounding else lower),
        upper=_replaced(limits.upper, j, max(last, lower) if last < upper - rounding else upper),
        velocity=_replaced(limits.velocity, j, _rate(float(limits.velocity[j]), follower.velocity, multiplier)),
        acceleration=_replaced(
            limits.acceleration, j, _rate(float(limits.acceleration[j]), follower.acceleration, multiplier)
        ),
    )


def _reach(follower: _Follower, lower: float, upper: float) -> str:
    ends = sorted(follower.multiplier * bound + follower.offset for bound in (lower, upper))
    return f"{ends[0]!r} to {ends[1]!r}"


def _rate(leader: float, follower: float, multiplier: float) -> float:
    """Return a leader's limit of velocity or acceleration, or the smaller one that its follower's asks for."""
    asked = follower / abs(multiplier)
    return asked if asked < leader * (1.0 - ROUNDING) else leader


def _replaced(values: Array, index: int, value: float) -> Array:
    changed = values.copy()
    changed[index] = value
    return changed


def _nowhere(follower: _Follower, why: str) -> InvalidInput:
    valid = f"limits of position that the joint can keep: {why}"
    return InvalidInput(f"limits of joint {follower.name}", (follower.lower, follower.upper), valid)
