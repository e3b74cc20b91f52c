"""Whether a configuration is within the position limits of a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, told_apart
from humanoid_rail.model.robot import Robot

ROUNDING = 1e-9
"""A position beyond a limit by at most this share of the joint's range is at the limit: rounding explains it."""
OTHER_UNIT = 2.0 * np.pi
"""A position beyond this may have been given in degrees or millimetres, rad or m."""


def within_position_limits(robot: Robot, q: ArrayLike, field: str) -> Array:
    """Return a configuration (n,) with what is beyond a limit by rounding put onto it, m and rad.

    Args:
        robot: The robot.
        q: Configuration (n,).
        field: What errors call it.

    Raises:
        InvalidInput: If a position is beyond a limit by more than rounding; the error says so where it looks like
            degrees or millimetres.
    """
    given, lower, upper = np.array(q, float), robot.lower, robot.upper
    for i in beyond_limits(given, lower, upper):
        value = float(given[i])
        low, high = (told_apart(float(limit[i]), value) for limit in (lower, upper))
        name = robot.joint_names[i]
        slides = robot.model.joints[robot.model.getJointId(name)].shortname().startswith("JointModelP")
        other, factor = ("millimetres", 1e-3) if slides else ("degrees", np.pi / 180.0)
        hint = f"; given in {other}?" if abs(value) > OTHER_UNIT and lower[i] <= factor * value <= upper[i] else ""
        valid = f"a position within {low} to {high} {'m' if slides else 'rad'}{hint}"
        raise InvalidInput(f"{field}[{i}] ({name})", value, valid)
    within: Array = np.clip(given, lower, upper)
    return within


def beyond_limits(q: Array, lower: Array, upper: Array) -> tuple[int, ...]:
    """Return the positions of q (n,), by index, that are beyond limits (n,) by more than rounding; m and rad."""
    if ((q >= lower) & (q <= upper)).all():
        return ()
    span = upper - lower
    rounding = ROUNDING * np.where(np.isfinite(span), span, np.maximum(1.0, abs(q)))
    return tuple(np.flatnonzero(~((q >= lower - rounding) & (q <= upper + rounding))).tolist())
