"""Units of the arguments of the paper's robot: what can only be a wrong one is refused, what may be one is warned of.

Robots may be of any scale. So lengths are held against each other: no mechanism has one link a hundred times as long
as most others. An angle beyond a full turn reaches no posture that one within it does not reach, so it is taken for
degrees.
"""

from __future__ import annotations

import math
import statistics
import warnings
from collections.abc import Mapping

from humanoid_rail.errors import InvalidInput

FULL_TURN = 2.0 * math.pi
"""Angles are within this of 0, rad."""
LONGEST = 100.0
"""A link is at most this many times as long as the median link."""
FARTHEST_RAIL = 1000.0
"""A rail goes at most this many times as far as the median link is long."""
THICKEST = 5.0
"""The radius of the links is at most this many times the longest of them."""
FAST = {"rail_velocity": (50.0, "mm/s"), "revolute_velocity": (30.0, "deg/s")}
"""Faster than this (m/s, rad/s) is no robot; which unit may have been meant."""
UNLIMITED = 1e6
"""Speeds from here on stand for no limit, m/s or rad/s."""


def check_units(values: Mapping[str, float], given: Mapping[str, float]) -> None:
    """Check arguments of the paper's robot for wrong units.

    Args:
        values: All arguments with their defaults; m, rad and s.
        given: Those that were given, which errors are about.

    Raises:
        InvalidInput: If one can only be in another unit; the error says what it would be in the right one.
    """
    lengths = [value for name, value in values.items() if name.startswith("l_")]
    median, longest = statistics.median(lengths), max(lengths)
    for name, value in given.items():
        if name == "beta" or (name.endswith(("_lower", "_upper")) and not name.startswith("rail_")):
            _check(name, value, FULL_TURN, "rad", "degrees", math.pi / 180.0)
        elif name.startswith("l_"):
            _check(name, value, LONGEST * median, "m, as other links are about as long", "millimetres", 1e-3)
        elif name == "link_radius":
            _check(name, value, THICKEST * longest, "m, as the links are not as long", "millimetres", 1e-3)
        elif name in ("rail_lower", "rail_upper"):
            _check(name, value, FARTHEST_RAIL * median, "m, for a robot of this size", "millimetres", 1e-3)
        elif name in FAST and FAST[name][0] * max(1.0, median) < value < UNLIMITED:
            slides = name.startswith("rail")
            unit = "m/s" if slides else "rad/s"
            meant = f"{value * (1e-3 if slides else math.pi / 180.0):.4g} {unit}"
            warnings.warn(
                f"{name} is {value:g} {unit}, faster than robots are; {value:g} {FAST[name][1]} would be {meant}",
                stacklevel=4,
            )


def _check(name: str, value: float, most: float, unit: str, other: str, factor: float) -> None:
    if abs(value) > most:
        valid = f"at most {most:.6g} in size, {unit}; {value:g} {other} would be {factor * value:.6g}"
        raise InvalidInput(name, value, valid)
