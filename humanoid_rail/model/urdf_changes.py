"""Changes a URDF: locks joints, gives joints limits and the root a place."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.robot_file import FULL_TURN, LimitEntry
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_elements import parse_xml
from humanoid_rail.model.urdf_joint import Joint

SPEEDS = {"prismatic": 0.25, "revolute": 1.0, "continuous": 1.0}
"""A joint without a speed limit gets this one, m/s or rad/s."""
ACCELERATION_TIME = 0.2
"""A joint without a limit of acceleration reaches its speed limit in this time, s."""
EFFORT = 1e3
"""A joint without a limit of effort gets this one, N or N m."""
WORLD = "world"
"""The link that the root stands on where it has a place of its own; with underscores if there is one called so."""


@dataclass(frozen=True)
class Changes:
    """What is changed in a URDF."""

    locked: Mapping[str, float]
    """Where joints stand from now on, m or rad."""
    limits: Mapping[str, LimitEntry] = field(default_factory=dict)
    """Limits of joints that move, instead of their own."""
    continuous_within: tuple[float, float] = (-FULL_TURN, FULL_TURN)
    """The range of joints without end, rad."""
    acceleration_time: float | None = None
    """In this time joints without a limit of acceleration reach their speed limit, s."""
    base: pin.SE3 = field(default_factory=pin.SE3.Identity)
    """Where the root stands, m."""
    name: str | None = None
    """What the robot is called."""
    as_written: bool = False
    """Whether no limits are assumed."""


def changed_urdf(urdf: Urdf, changes: Changes) -> tuple[str, tuple[str, ...]]:
    """Return the text of a URDF with changes, and what was assumed in sentences.

    Raises:
        InvalidInput: If a joint that is to change is not there, a joint that has three or six freedoms is to move,
            or one of these is to stand elsewhere than at 0.
    """
    for field_name, names in (("locked", changes.locked), ("limits", changes.limits)):
        for name in names:
            _check_moves(urdf, field_name, name)
    root = parse_xml("urdf", urdf.text)
    if changes.name is not None:
        root.set("name", changes.name)
    moving = [joint for joint in urdf.joints.values() if joint.kind != "fixed" and joint.name not in changes.locked]
    elements = {element.get("name"): element for element in root.findall("joint")}
    for name, value in changes.locked.items():
        _lock(elements[name], urdf.joints[name], value, changes.limits.get(name))
    assumed = [note for joint in moving if joint.mimic is None for note in _limit(elements[joint.name], joint, changes)]
    for joint in moving:
        if joint.mimic is not None:
            _limit_follower(elements, joint, urdf, changes)
    if not changes.as_written:
        assumed += [
            ("have a safety_controller, whose soft limits are not used", joint.name)
            for joint in moving
            if elements[joint.name].find("safety_controller") is not None
        ]
    _warn_of_time(moving, changes)
    _place(root, urdf, changes.base)
    return ElementTree.tostring(root, encoding="unicode"), tuple(_gathered(assumed))


def _warn_of_time(moving: Sequence[Joint], changes: Changes) -> None:
    """Warn of a time for accelerations where all joints that move have limits of them."""
    lacking = [
        joint
        for joint in moving
        if (joint.limit is None or not np.isfinite(joint.limit.acceleration))
        and changes.limits.get(joint.name, LimitEntry()).acceleration is None
    ]
    if changes.acceleration_time is not None and (changes.as_written or not lacking):
        all_have = "each joint that moves has a limit of acceleration already"
        warnings.warn(f"acceleration_time: of no effect, as {all_have}; limits can change them", stacklevel=3)


def resting_place(joint: Joint, given: LimitEntry | None = None) -> float:
    """Return where a joint stands that is locked without a position: at 0 or at its limit next to it, m or rad."""
    return float(np.clip(0.0, *_position_limits(joint, given)))


def _position_limits(joint: Joint, given: LimitEntry | None) -> tuple[float, float]:
    """Return within what a joint can be locked: limits that are given, else its own; m or rad."""
    is_limited = joint.limit is not None and joint.kind in ("revolute", "prismatic")
    lower, upper = (joint.limit.lower, joint.limit.upper) if is_limited and joint.limit else (-np.inf, np.inf)
    if given is not None:
        lower = lower if given.lower is None else given.lower
        upper = upper if given.upper is None else given.upper
    return lower, upper


def _check_moves(urdf: Urdf, field_name: str, name: str) -> None:
    moving = [joint.name for joint in urdf.joints.values() if joint.kind != "fixed"]
    if name not in moving:
        valid = f"a joint of the URDF that moves{did_you_mean(name, moving)}: {', '.join(moving)}"
        raise InvalidInput(field_name, name, valid)


def _lock(element: Element, joint: Joint, value: float, given: LimitEntry | None) -> None:
    """Make a joint fixed where it is at a position, m or rad."""
    if joint.kind in ("planar", "floating") and value != 0.0:
        raise InvalidInput(f"locked.{joint.name}", value, f"0, as the joint is {joint.kind}")
    lower, upper = _position_limits(joint, given)
    rounding = 1e-9 * min(max(1.0, upper - lower), 1e3)
    if not lower - rounding <= value <= upper + rounding:
        valid = f"a position within the limits of the joint, {lower!r} to {upper!r}"
        raise InvalidInput(f"locked.{joint.name}", value, valid)
    if given is not None:
        warnings.warn(f"limits.{joint.name}: of no effect on motions, as the joint is locked", stacklevel=4)
    element.set("type", "fixed")
    for child in list(element):
        if child.tag not in ("origin", "parent", "child"):
            element.remove(child)
    if value != 0.0:
        slides = joint.kind == "prismatic"
        turn, shift = (np.eye(3), value * joint.axis) if slides else (pin.exp3(value * joint.axis), np.zeros(3))
        _set_origin(element, joint.placement * pin.SE3(turn, shift))


def _limit(element: Element, joint: Joint, changes: Changes) -> list[tuple[str, str]]:
    """Give a joint that moves the limits that it has to have; return what was assumed, and the joint."""
    _check_kind(joint)
    if changes.as_written and joint.name not in changes.limits and joint.kind != "continuous":
        return []
    entry, limit, notes = changes.limits.get(joint.name, LimitEntry()), element.find("limit"), []
    if limit is None:
        limit = SubElement(element, "limit", effort=repr(EFFORT), velocity="0")
        notes.append(f"have no limit of effort: {EFFORT:g} N m is assumed")
    if joint.kind == "continuous":
        element.set("type", "revolute")
        low, high = changes.continuous_within
        limit.set("lower", repr(low))
        limit.set("upper", repr(high))
        if entry.lower is None or entry.upper is None:
            notes.append(f"turn without end: they are kept within {low:.5g} to {high:.5g} rad")
    if (speed := entry.velocity) is None and not (joint.limit and joint.limit.velocity > 0.0):
        speed = SPEEDS[joint.kind]
        unit = "m/s" if joint.kind == "prismatic" else "rad/s"
        notes.append(f"have no speed limit, or 0, which is none: {speed:g} {unit} is assumed")
    acceleration, time = entry.acceleration, changes.acceleration_time or ACCELERATION_TIME
    is_limited = joint.limit is not None and np.isfinite(joint.limit.acceleration)
    if acceleration is None and not is_limited:
        fastest = speed or (joint.limit.velocity if joint.limit else np.inf)
        if np.isfinite(fastest):
            acceleration = fastest / time
            if changes.acceleration_time is None:
                notes.append(
                    f"have no limit of acceleration: one that reaches the speed limit in {time:g} s is assumed"
                )
    if entry.acceleration is not None:
        for own in [name for name in limit.attrib if name.rpartition(":")[2] == "deceleration"]:
            del limit.attrib[own]
    values = {"lower": entry.lower, "upper": entry.upper, "velocity": speed, "acceleration": acceleration}
    _write(limit, values | {"jerk": entry.jerk})
    return [(note, joint.name) for note in notes]


def _limit_follower(elements: Mapping[str | None, Element], joint: Joint, urdf: Urdf, changes: Changes) -> None:
    """Give a follower limits that leave its leader as free as it is, where it has none of its own."""
    _check_kind(joint)
    if changes.as_written and joint.name not in changes.limits and joint.kind != "continuous":
        return
    element, entry = elements[joint.name], changes.limits.get(joint.name, LimitEntry())
    leader, multiplier, offset = joint, 1.0, 0.0
    while leader.mimic is not None:
        multiplier, offset = multiplier * leader.mimic.multiplier, multiplier * leader.mimic.offset + offset
        leader = urdf.joints[leader.mimic.joint]
    asked = elements[leader.name].find("limit")
    assert asked is not None  # it was given one before
    values: dict[str, float | None] = {"jerk": entry.jerk, "acceleration": entry.acceleration}
    limit = element.find("limit")
    if limit is None:
        limit = SubElement(element, "limit", effort=repr(EFFORT), velocity="0")
    if joint.kind == "continuous":
        element.set("type", "revolute")
        ends = sorted(multiplier * float(asked.get(end, "0")) + offset for end in ("lower", "upper"))
        values |= {"lower": ends[0], "upper": ends[1]}
    if not (joint.limit and joint.limit.velocity > 0.0):
        fastest = abs(multiplier) * float(asked.get("velocity", "inf"))
        values["velocity"] = fastest if fastest > 0.0 else SPEEDS[joint.kind]
    given = {"lower": entry.lower, "upper": entry.upper, "velocity": entry.velocity}
    _write(limit, values | {name: value for name, value in given.items() if value is not None})


def _check_kind(joint: Joint) -> None:
    if joint.kind in ("planar", "floating"):
        valid = f"locked (locked: {{{joint.name}: 0}}), or joints of one freedom each instead, three for a plane"
        raise InvalidInput(f"joint {joint.name}", f"a {joint.kind} joint", valid)


def _write(limit: Element, values: Mapping[str, float | None]) -> None:
    """Write values into a `<limit>` for those with the same name, whatever their prefix; None changes nothing."""
    for name, value in values.items():
        if value is not None:
            for written in [a for a in limit.attrib if a.rpartition(":")[2] == name]:
                del limit.attrib[written]
            limit.set(name, repr(float(value)))


def _gathered(notes: Sequence[tuple[str, str]]) -> list[str]:
    """Return notes as sentences, each once with all its joints; warn of speeds that are assumed."""
    gathered: dict[str, list[str]] = {}
    for note, joint in notes:
        gathered.setdefault(note, []).append(joint)
    sentences = [f"The joints {', '.join(joints)} {note}." for note, joints in gathered.items()]
    for sentence in sentences:
        if "speed limit, or 0" in sentence:
            warnings.warn(sentence, stacklevel=2)
    return sentences


def _place(root: Element, urdf: Urdf, base: pin.SE3) -> None:
    """Put a link under the root where it does not stand at the origin."""
    if base.isIdentity(0.0):
        return
    moved = {joint.child for joint in urdf.joints.values()}
    old, world = next(name for name in urdf.links if name not in moved), WORLD
    while world in urdf.links:
        world += "_"
    SubElement(root, "link", name=world)
    name = f"{world}_to_{old}"
    while name in urdf.joints:
        name += "_"
    joint = SubElement(root, "joint", name=name, type="fixed")
    SubElement(joint, "parent", link=world)
    SubElement(joint, "child", link=old)
    _set_origin(joint, base)


def _set_origin(element: Element, placement: pin.SE3) -> None:
    origin = element.find("origin")
    if origin is None:
        origin = SubElement(element, "origin")
    origin.attrib.clear()
    origin.set("xyz", " ".join(repr(x) for x in placement.translation.tolist()))
    origin.set("rpy", " ".join(repr(x) for x in pin.rpy.matrixToRpy(placement.rotation).tolist()))
