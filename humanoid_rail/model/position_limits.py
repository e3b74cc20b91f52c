"""Whether a configuration is within the position limits of a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, told_apart
from humanoid_rail.model.robot import Robot

ROUNDING = 1e-9
"""A position beyond a limit by at most this share of the joint's range is at the limit: rounding explains it."""


def within_position_limits(robot: Robot, q: ArrayLike, field: str) -> Array:
    """Return a configuration (n,) with what is beyond a limit by rounding put onto it, m and rad.

    Args:
        robot: The robot.
        q: Configuration (n,).
        field: What errors call it.

    Raises:
        InvalidInput: If a position is beyond a limit by more than rounding.
    """
    given, lower, upper = np.array(q, float), robot.lower, robot.upper
    span = upper - lower
    rounding = ROUNDING * np.where(np.isfinite(span), span, np.maximum(1.0, abs(given)))
    for i in np.flatnonzero(~((given >= lower - rounding) & (given <= upper + rounding))):
        value = float(given[i])
        low, high = (told_apart(float(limit[i]), value) for limit in (lower, upper))
        raise InvalidInput(f"{field}[{i}] ({robot.joint_names[i]})", value, f"a position within {low} to {high}")
    within: Array = np.clip(given, lower, upper)
    return within
