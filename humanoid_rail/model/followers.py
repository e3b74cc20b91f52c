"""Limits of `<mimic>` joints as limits of the joints that they follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_joint import Limit

ROUNDING = 1e-9
"""A limit of a follower counts if it is narrower than its leader's by more than this share of the leader's."""
RATES = ("velocity", "acceleration", "jerk")
"""These limits of a follower are those of its leader, divided by the multiplier."""


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
    jerk: Array
    """m/s^3 or rad/s^3; infinite where there is none."""


@dataclass(frozen=True)
class _Follower:
    """The joint `name` is at multiplier x + offset where its leader, the actuated joint `leader`, is at x."""

    name: str
    leader: int
    multiplier: float
    offset: float
    limit: Limit


def folded_limits(
    model: pin.Model, urdf: Urdf, joint_names: Sequence[str], coupling: Array, offset: Array
) -> ActuatedLimits:
    """Return limits of the actuated joints within which each follower keeps its own limits too.

    Args:
        model: All joints.
        urdf: Their limits.
        joint_names: The actuated ones.
        coupling: S (model.nv, n); a follower has one leader, so there is at most one number in its row.
        offset: s0 (model.nq,).

    Raises:
        InvalidInput: If a follower cannot keep its position limits anywhere in its leader's range.
    """
    own = [_limit(urdf, name) for name in joint_names]
    columns = (np.array([getattr(limit, field.name) for limit in own]) for field in fields(ActuatedLimits))
    limits = ActuatedLimits(*columns)
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if name not in joint_names:
            row, constant = coupling[joint.idx_v], float(offset[joint.idx_q])
            leader = int(np.argmax(abs(row)))
            follower = _Follower(name, leader, float(row[leader]), constant, _limit(urdf, name))
            limits = _with_follower(limits, follower, joint_names[leader])
    return limits


def _limit(urdf: Urdf, name: str) -> Limit:
    limit = urdf.joints[name].limit
    assert limit is not None  # only revolute and prismatic joints are left, and these have limits
    return limit


def _with_follower(limits: ActuatedLimits, follower: _Follower, leader: str) -> ActuatedLimits:
    """Return limits that are narrower where those of a follower ask for it."""
    j, multiplier = follower.leader, follower.multiplier
    if multiplier == 0.0:
        if not follower.limit.lower - ROUNDING <= follower.offset <= follower.limit.upper + ROUNDING:
            raise _nowhere(follower, f"it always stands at {follower.offset!r}")
        return limits
    first, last = sorted(
        (bound - follower.offset) / multiplier for bound in (follower.limit.lower, follower.limit.upper)
    )
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
        **{rate: _replaced(getattr(limits, rate), j, _rate(limits, follower, rate)) for rate in RATES},
    )


def _reach(follower: _Follower, lower: float, upper: float) -> str:
    ends = sorted(follower.multiplier * bound + follower.offset for bound in (lower, upper))
    return f"{ends[0]!r} to {ends[1]!r}"


def _rate(limits: ActuatedLimits, follower: _Follower, rate: str) -> float:
    """Return a leader's limit of a rate, or the smaller one that its follower's asks for."""
    leader = float(getattr(limits, rate)[follower.leader])
    asked = float(getattr(follower.limit, rate)) / abs(follower.multiplier)
    return asked if asked < leader * (1.0 - ROUNDING) else leader


def _replaced(values: Array, index: int, value: float) -> Array:
    changed = values.copy()
    changed[index] = value
    return changed


def _nowhere(follower: _Follower, why: str) -> InvalidInput:
    valid = f"limits of position that the joint can keep: {why}"
    return InvalidInput(f"limits of joint {follower.name}", (follower.limit.lower, follower.limit.upper), valid)
