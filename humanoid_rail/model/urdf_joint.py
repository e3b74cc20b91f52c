"""Joints of a URDF: where they are, what limits them and what they follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.urdf_elements import Node

MOVING = ("revolute", "prismatic", "continuous", "floating", "planar")
"""The types of joints that move."""

_UNUSED = {
    "dynamics": ("damping", "friction"),
    "calibration": ("rising", "falling"),
    "safety_controller": ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"),
}


@dataclass(frozen=True)
class Limit:
    """The limits of a joint, m and rad; infinite where the URDF has none."""

    lower: float
    upper: float
    velocity: float
    effort: float
    acceleration: float
    jerk: float
    is_range_written: bool = True
    """Whether both limits of position are; one that is not is 0."""

    @property
    def has_no_range(self) -> bool:
        """Whether limits of position are missing, so that the joint cannot move; one that is held has both."""
        return self.lower == self.upper and not self.is_range_written


@dataclass(frozen=True)
class Mimic:
    """What a joint follows: multiplier * q + offset, q the position of another joint. A multiplier of 0 holds it."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint."""

    name: str
    kind: str
    """Its type: `fixed` or one of `MOVING`."""
    parent: str
    child: str
    placement: pin.SE3
    """Where it is in the frame of the parent link, m."""
    axis: Array
    """(3,), of length 1; x if the URDF has none."""
    limit: Limit | None
    mimic: Mimic | None


def read_joint(node: Node) -> Joint:
    """Return a joint.

    Raises:
        InvalidInput: If an element or attribute is missing, cannot be read or has a value that it cannot have.
    """
    node.check_children(("origin", "parent", "child", "axis", "limit", "mimic", *_UNUSED))
    kind = node.text("type")
    if kind not in (*MOVING, "fixed"):
        raise InvalidInput(f"{node.where}.type", kind, f"one of fixed, {', '.join(MOVING)}")
    _check_unused(node)
    axis, limit, mimic = (node.child(tag) if kind in MOVING else None for tag in ("axis", "limit", "mimic"))
    if limit is None and kind in ("revolute", "prismatic"):
        node.needed("limit")
    return Joint(
        name=node.text("name"),
        kind=kind,
        parent=node.needed("parent").text("link"),
        child=node.needed("child").text("link"),
        placement=node.origin(),
        axis=np.array([1.0, 0.0, 0.0]) if axis is None else _axis(axis),
        limit=None if limit is None else _limit(limit, kind),
        mimic=None if mimic is None else _mimic(mimic),
    )


def _axis(node: Node) -> Array:
    node.check_attributes(("xyz",))
    return node.direction("xyz", 3)


def _mimic(node: Node) -> Mimic:
    node.check_attributes(("joint", "multiplier", "offset"))
    return Mimic(node.text("joint"), node.number("multiplier", 1.0), node.number("offset", 0.0))


def _limit(node: Node, kind: str) -> Limit:
    rates = ("acceleration", "deceleration", "jerk")
    node.check_misspelt(("lower", "upper", "velocity", "effort", *rates))
    bounded = kind in ("revolute", "prismatic")
    lower, upper = (node.number(name, None if bounded and node.version >= 1.2 else 0.0) for name in ("lower", "upper"))
    if bounded and lower > upper:
        valid = "lower <= upper, in m or rad; one that is not written is 0"
        raise InvalidInput(node.where, f"from {lower:g} to {upper:g}", valid)
    # URDF 1.2 made these optional, and those above not.
    default = np.inf if node.version >= 1.2 else None
    velocity, effort = (node.number(name, default, least=0.0, most=np.inf) for name in ("velocity", "effort"))
    acceleration, deceleration, jerk = (_rate_limit(node, name) for name in rates)
    written = {"lower", "upper"} <= node.element.attrib.keys()
    return Limit(lower, upper, velocity, effort, min(acceleration, deceleration), jerk, written)


def _rate_limit(node: Node, name: str) -> float:
    """Return the least of the limits with a name, with Drake's prefix or without, whatever the version; or infinity."""
    written = [attribute for attribute in node.element.attrib if attribute.rpartition(":")[2] == name]
    return min((node.number(attribute, above=0.0, most=np.inf) for attribute in written), default=np.inf)


def _check_unused(joint: Node) -> None:
    """Check that readers which do use them can read these, as they refuse the whole URDF otherwise."""
    for tag, attributes in _UNUSED.items():
        if (node := joint.child(tag)) is not None:
            if tag == "dynamics" and not {*attributes} & node.element.attrib.keys():
                raise InvalidInput(node.where, MISSING, "damping, friction, or both")
            for attribute in attributes:
                node.number(attribute, None if attribute == "k_velocity" else 0.0, least=-np.inf, most=np.inf)
