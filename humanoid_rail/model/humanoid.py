"""The paper's robot, built from its xacro file."""

from __future__ import annotations

import math
from collections.abc import Callable
from inspect import Parameter, Signature
from pathlib import Path
from typing import SupportsFloat, TypedDict, TypeVar, Unpack
from xml.etree import ElementTree

from humanoid_rail._arrays import FARTHEST
from humanoid_rail._resources import resource
from humanoid_rail.errors import InvalidInput, checked_number, did_you_mean
from humanoid_rail.model.building import robot_as_written
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.model.units import check_units

XACRO = "humanoid_rail.urdf.xacro"
"""The file in `robots/` that the paper's robot is built from."""
SRDF = "humanoid_rail.srdf"
"""The file in `robots/` with the pairs of links that are not checked against each other."""
ARM_JOINTS = ("shoulder_roll", "shoulder_pitch", "upper_arm_roll", "elbow_pitch")
"""The joints of an arm, without the side that their names begin with."""
INITIAL = (0.0, 0.0, math.pi / 3, math.pi / 4, *(8 * (0.0,)))
"""q(0) of eq. 5.1: the rail in m, then angles in rad."""
SMALLEST = 1e-6
"""Lengths, rates, efforts and densities are at least this; SI units."""
LARGEST = 1e9
"""Rates, efforts and densities are at most this; SI units."""

SWITCHES = ("trunk_bodies", "grippers")
"""These arguments are 1 or 0."""

_XACRO_TAG = "{http://www.ros.org/wiki/xacro}"
_F = TypeVar("_F", bound=Callable[..., object])


class RobotArguments(TypedDict, total=False):
    """The arguments of the paper's robot; those that are not given have the defaults of the xacro file."""

    l_t1: SupportsFloat
    """Height of the waist above the carriage, m."""
    l_t2: SupportsFloat
    """Length of the lower torso, m."""
    l_t3: SupportsFloat
    """Length of the upper torso, m."""
    l_l1: SupportsFloat
    """Length of the left clavicle, m."""
    l_l2: SupportsFloat
    """Length of the left upper arm, m."""
    l_l3: SupportsFloat
    """Length of the left forearm up to the hand point, m."""
    l_r1: SupportsFloat
    """Length of the right clavicle, m."""
    l_r2: SupportsFloat
    """Length of the right upper arm, m."""
    l_r3: SupportsFloat
    """Length of the right forearm up to the hand point, m."""
    beta: SupportsFloat
    """Angle of the arm bases, rad; the paper does not give it."""
    link_radius: SupportsFloat
    """Radius of the collision capsules, m; 0 for bones without thickness."""
    trunk_bodies: SupportsFloat
    """Whether trunk, head and hands have collision bodies, 1 or 0."""
    grippers: SupportsFloat
    """Whether the hands are grippers with collision bodies, a palm and two fingers, 1 or 0."""
    rail_lower: SupportsFloat
    """Lower position limit of the rail, m."""
    rail_upper: SupportsFloat
    """Upper position limit of the rail, m."""
    rail_velocity: SupportsFloat
    """Velocity limit of the rail, m/s."""
    rail_acceleration: SupportsFloat
    """Acceleration limit of the rail, m/s^2."""
    rail_effort: SupportsFloat
    """Force limit of the rail, N."""
    waist_yaw_lower: SupportsFloat
    """Lower position limit of the waist's yaw, rad."""
    waist_yaw_upper: SupportsFloat
    """Upper position limit of the waist's yaw, rad."""
    waist_pitch_lower: SupportsFloat
    """Lower position limit of the waist's pitch, rad."""
    waist_pitch_upper: SupportsFloat
    """Upper position limit of the waist's pitch, rad."""
    spine_pitch_lower: SupportsFloat
    """Lower position limit of the spine's pitch, rad."""
    spine_pitch_upper: SupportsFloat
    """Upper position limit of the spine's pitch, rad."""
    shoulder_roll_lower: SupportsFloat
    """Lower position limit of the shoulders' roll, rad."""
    shoulder_roll_upper: SupportsFloat
    """Upper position limit of the shoulders' roll, rad."""
    shoulder_pitch_lower: SupportsFloat
    """Lower position limit of the shoulders' pitch, rad."""
    shoulder_pitch_upper: SupportsFloat
    """Upper position limit of the shoulders' pitch, rad."""
    upper_arm_roll_lower: SupportsFloat
    """Lower position limit of the upper arms' roll, rad."""
    upper_arm_roll_upper: SupportsFloat
    """Upper position limit of the upper arms' roll, rad."""
    elbow_lower: SupportsFloat
    """Lower position limit of the elbows, rad."""
    elbow_upper: SupportsFloat
    """Upper position limit of the elbows, rad."""
    revolute_velocity: SupportsFloat
    """Velocity limit of all revolute joints, rad/s."""
    revolute_acceleration: SupportsFloat
    """Acceleration limit of all revolute joints, rad/s^2."""
    revolute_effort: SupportsFloat
    """Torque limit of all revolute joints, N m."""
    density: SupportsFloat
    """Density of the links, kg/m^3."""


def xacro_arguments(path: Path | None = None) -> dict[str, str]:
    """Return the arguments that a xacro file declares, with their defaults as written there.

    Args:
        path: xacro file; `robots/humanoid_rail.urdf.xacro` if not given.
    """
    root = ElementTree.parse(path or resource("robots", XACRO)).getroot()
    return {arg.attrib["name"]: arg.attrib["default"] for arg in root.iter(f"{_XACRO_TAG}arg")}


def argument_parameters() -> list[Parameter]:
    """Return the arguments of the xacro file as parameters of a function, with their defaults."""
    names = {"pi": math.pi, "radians": math.radians}
    return [
        Parameter(name, Parameter.KEYWORD_ONLY, default=float(eval(text.strip("${}"), {"__builtins__": {}}, names)))
        for name, text in xacro_arguments().items()
    ]


def _shows_arguments(function: _F) -> _F:
    """Give a function that takes :class:`RobotArguments` a signature that names them with their defaults."""
    signature = Signature(argument_parameters(), return_annotation=function.__annotations__["return"])
    function.__signature__ = signature  # type: ignore[attr-defined]
    return function


@_shows_arguments
def build_urdf(**arguments: Unpack[RobotArguments]) -> str:
    """Return the URDF of the paper's robot as text.

    Args:
        **arguments: Those of :func:`load_robot`.

    Raises:
        InvalidInput: If an argument is unknown or its value cannot be built.
    """
    # Imported here: a robot that is read from a URDF needs no xacro.
    import xacro

    path = resource("robots", XACRO)
    known = xacro_arguments(path)
    values = {name: _number(name, value, known) for name, value in arguments.items()}
    check_units({parameter.name: parameter.default for parameter in argument_parameters()} | values, values)
    # Not process_file, which writes the path of this installation into the URDF.
    document = xacro.parse(None, str(path))
    xacro.process_doc(document, mappings={name: repr(value) for name, value in values.items()})
    urdf: str = document.toprettyxml(indent="  ")
    _check_limits(urdf)
    return urdf


def paper_robot(urdf: str) -> Robot:
    """Return the paper's robot from its URDF text, as :func:`humanoid_rail.build_urdf` makes it.

    Raises:
        InvalidInput: If the text is no URDF, or not one of this robot.
    """
    return robot_as_written(
        urdf,
        resource("robots", SRDF).read_text(encoding="utf-8"),
        hands=[Hand(side, f"{side}_hand", tuple(f"{side}_{j}" for j in ARM_JOINTS)) for side in ("left", "right")],
        initial=INITIAL,
        with_rigid_pairs=False,
    )


def _number(name: str, value: object, known: dict[str, str]) -> float:
    """Return the value of a xacro argument, checked."""
    if name not in known:
        valid = f"one of the xacro arguments {', '.join(sorted(known))}{did_you_mean(name, known)}"
        raise InvalidInput("argument", name, valid)
    if name in SWITCHES:
        if (given := checked_number(name, value)) not in (0.0, 1.0):
            raise InvalidInput(name, value, "1 or 0")
        return given
    if name == "link_radius":
        return checked_number(name, value, least=0.0, most=FARTHEST)
    if name.startswith("l_"):
        return checked_number(name, value, least=SMALLEST, most=FARTHEST)
    if name.endswith(("_velocity", "_acceleration", "_effort")) or name == "density":
        return checked_number(name, value, least=SMALLEST, most=LARGEST)
    return checked_number(name, value, least=-FARTHEST, most=FARTHEST)


def _check_limits(urdf: str) -> None:
    for joint in ElementTree.fromstring(urdf).findall("joint"):
        limit = joint.find("limit")
        if limit is None:
            continue
        lower, upper = float(limit.attrib["lower"]), float(limit.attrib["upper"])
        if lower >= upper:
            raise InvalidInput(
                f"limits of joint {joint.attrib['name']}", (lower, upper), "a lower limit below the upper"
            )
