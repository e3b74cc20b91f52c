"""Checks of configurations that users give."""

from __future__ import annotations

import math

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot

OTHER_UNIT = 2.0 * math.pi
"""A coordinate beyond this may have been given in degrees or millimetres, rad or m."""


def check_within_limits(robot: Robot, q: Array, field: str) -> None:
    """Check that a configuration is within the position limits.

    Args:
        robot: The robot.
        q: The configuration (n,), m and rad.
        field: What it is called in errors.

    Raises:
        InvalidInput: If it is not; the error says so where the value looks like degrees or millimetres.
    """
    for name, value, lower, upper in zip(robot.joint_names, q.tolist(), robot.lower, robot.upper, strict=True):
        if not lower <= value <= upper:
            slides = robot.model.joints[robot.model.getJointId(name)].shortname().startswith("JointModelP")
            unit, factor = ("millimetres", 1e-3) if slides else ("degrees", math.pi / 180.0)
            hint = f"; given in {unit}?" if abs(value) > OTHER_UNIT and lower <= factor * value <= upper else ""
            valid = f"a position within the limits {lower:.6g} to {upper:.6g} {'m' if slides else 'rad'}{hint}"
            raise InvalidInput(f"{field}[{robot.joint_names.index(name)}] ({name})", value, valid)
