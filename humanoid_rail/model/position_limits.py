"""Whether a configuration is within the position limits of a robot."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, told_apart
from humanoid_rail.model.robot import Robot

ROUNDING = 1e-9
"""A position beyond a limit by at most this share of the joint's range is at the limit: rounding explains it."""
SLIGHTLY = 1e-3
"""A start beyond a limit by at most this is taken to the limit, rad or m. Files with three decimals are off by up to
half of it, and an encoder of 12 bits by 0.8e-3 rad; nothing that is farther off is explained so."""
SLIGHT_SHARE = 0.01
"""But by no more than this share of the joint's range."""
OTHER_UNIT = 2.0 * np.pi
"""A position beyond this may have been given in degrees or millimetres, rad or m."""


def within_position_limits(robot: Robot, q: ArrayLike, field: str, *, said_from: float = np.inf) -> Array:
    """Return a start (n,) with what is slightly beyond a limit put onto it, m and rad.

    Slightly beyond is what a measured or written position may be by itself: see `SLIGHTLY`.

    Args:
        robot: The robot.
        q: Configuration (n,).
        field: What errors and warnings call it.
        said_from: What is beyond a limit by more than this share of the joint's range is warned of; 0 for all of it.

    Raises:
        InvalidInput: If a position is farther beyond a limit; the error says by how much, and where it looks like
            degrees or millimetres.
    """
    given, lower, upper = np.array(q, float), robot.lower, robot.upper
    span = _span(given, lower, upper)
    allowed = np.maximum(ROUNDING * span, np.minimum(SLIGHTLY, SLIGHT_SHARE * span))
    for i in np.flatnonzero(~((given >= lower - allowed) & (given <= upper + allowed))):
        value, name = float(given[i]), robot.joint_names[i]
        low, high = (told_apart(float(limit[i]), value) for limit in (lower, upper))
        slides = robot.model.joints[robot.model.getJointId(name)].shortname().startswith("JointModelP")
        other, factor = ("millimetres", 1e-3) if slides else ("degrees", np.pi / 180.0)
        unit = "m" if slides else "rad"
        beyond = max(float(lower[i]) - value, value - float(upper[i]))
        valid = f"a position within {low} to {high} {unit}"
        if abs(value) > OTHER_UNIT and lower[i] <= factor * value <= upper[i]:
            valid += f"; given in {other}?"
        elif np.isfinite(beyond):
            valid += f"; it is {beyond:.3g} {unit} beyond, and up to {allowed[i]:.3g} {unit} is taken to the limit"
        raise InvalidInput(f"{field}[{i}] ({name})", value, valid)
    within: Array = np.clip(given, lower, upper)
    for i in np.flatnonzero(abs(given - within) > said_from * span):
        name, limit = robot.joint_names[i], float(within[i])
        side, unit = ("lower" if limit > given[i] else "upper"), robot.unit_of(name)
        far = f"{abs(limit - float(given[i])):.2g} {unit} beyond the {side} limit of {limit:.6g} {unit}"
        warnings.warn(f"{field}[{i}] ({name}) is {far}; the motion starts at the limit", stacklevel=3)
    return within


def beyond_limits(q: Array, lower: Array, upper: Array) -> tuple[int, ...]:
    """Return the positions of q (n,), by index, that are beyond limits (n,) by more than rounding; m and rad."""
    if ((q >= lower) & (q <= upper)).all():
        return ()
    rounding = ROUNDING * _span(q, lower, upper)
    return tuple(np.flatnonzero(~((q >= lower - rounding) & (q <= upper + rounding))).tolist())


def _span(q: Array, lower: Array, upper: Array) -> Array:
    """Return the ranges of joints (n,), m and rad; where there is no end, how far positions (n,) are from 0."""
    span = upper - lower
    ranges: Array = np.where(np.isfinite(span), span, np.maximum(1.0, abs(q)))
    return ranges
