"""Robot files: what a URDF does not say about a robot, as frozen, validated data (`robot.yaml`)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationError

from humanoid_rail._validation import Angles, Frozen, Number, Positive, Size, Vector, invalid_input, plain
from humanoid_rail._yaml import parse_yaml
from humanoid_rail.errors import InvalidInput

NAME = "robot.yaml"
"""The robot file of a folder has this name."""
IN_FILES_ONLY = ("urdf", "locked_already", "as_written", "assumed")
"""These fields are no arguments of `load_robot`: its source, and what `robot.save` writes."""
FULL_TURN = 6.283185307179586
"""Continuous joints are kept within this of 0 unless a robot file says otherwise, rad."""
ELSEWHERE = "every other joint, at 0"
"""`locked` may say this, with what follows, instead of positions: it is what happens anyway."""

Names = Annotated[tuple[str, ...], BeforeValidator(plain)]
BodyNumber = Annotated[int, Field(ge=0)]
Positions = dict[str, Number]
"""Positions of joints by their names, m and rad."""


def _kind_of_start(value: object) -> str:
    if isinstance(value, str):
        return "<posture>"
    return "<positions>" if isinstance(value, Mapping) else "<numbers>"


Start = Annotated[
    Annotated[str, Tag("<posture>")]
    | Annotated[Positions, Tag("<positions>")]
    | Annotated[tuple[Number, ...], BeforeValidator(plain), Tag("<numbers>")],
    Discriminator(_kind_of_start),
]
"""Where motions start: the name of a posture, positions by joint, or all positions; m and rad."""


def _in_words(value: object) -> object:
    """Take what the format does anyway, said in words, as nothing."""
    return {} if isinstance(value, str) and re.fullmatch(rf"{ELSEWHERE}(?![.\d]).*", value) else value


class _OfRobot(Frozen):
    """Part of a robot file."""

    described_in = "docs/robots.md"


class _BodyEntry(_OfRobot):
    """A collision body in the frame of a hand."""

    center: Vector
    """Its centre, m."""


class SphereEntry(_BodyEntry):
    """A ball."""

    type: Literal["sphere"]
    radius: Positive
    """Its radius, m."""


class BoxEntry(_BodyEntry):
    """A solid box."""

    type: Literal["box"]
    size: Size
    """Full edge lengths before rotation, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw about the fixed axes x, y, z, rad."""


class CapsuleEntry(_BodyEntry):
    """All points within `radius` of a segment along the local z axis."""

    type: Literal["capsule"]
    radius: Positive
    """Its radius, m."""
    length: Positive
    """Distance between the centres of the two end spheres, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw about the fixed axes x, y, z, rad."""


BodyEntry = Annotated[SphereEntry | BoxEntry | CapsuleEntry, Field(discriminator="type")]
"""A collision body of a hand, with the fields of an obstacle of a scene."""


class HandEntry(_OfRobot):
    """A hand of a robot file."""

    frame: str
    """The frame of the URDF whose origin is given targets."""
    arm: Names | None = None
    """The joints of its arm; the last ones that only this hand needs if not given."""
    pointing: Vector | None = None
    """The direction in the frame in which the hand points; targets with `approach` need one."""
    links: Names | None = None
    """The links that make up the hand, which may touch what it grasps; found by themselves if not given."""
    bodies: Annotated[tuple[BodyEntry, ...], BeforeValidator(plain)] = ()
    """Collision bodies that the URDF does not have, fixed to the frame and given in it."""


HandOrFrame = Annotated[
    HandEntry,
    BeforeValidator(
        lambda value: {"frame": value} if isinstance(value, str) else value, json_schema_input_type=HandEntry | str
    ),
]
"""A hand, or its frame alone."""


class LimitEntry(_OfRobot):
    """Limits of a joint, instead of those of the URDF. m, rad, s."""

    lower: Number | None = None
    """Lower position limit, m or rad."""
    upper: Number | None = None
    """Upper position limit, m or rad."""
    velocity: Positive | None = None
    """m/s or rad/s."""
    acceleration: Positive | None = None
    """m/s^2 or rad/s^2."""
    jerk: Positive | None = None
    """m/s^3 or rad/s^3."""


class BaseEntry(_OfRobot):
    """Where the root of the URDF stands."""

    xyz: Vector = (0.0, 0.0, 0.0)
    """m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw about the fixed axes x, y, z, rad."""


class PairEntry(_OfRobot):
    """Two links that are not checked against each other."""

    links: Annotated[tuple[str, str], BeforeValidator(plain)]
    """Their names."""
    why: str = "left out by the robot file"
    """Why they are left out."""


class DistanceEntry(_OfRobot):
    """Two links that are kept nearer to each other than others."""

    links: Annotated[tuple[str, str], BeforeValidator(plain)]
    """Their names."""
    bodies: Annotated[tuple[BodyNumber, BodyNumber], BeforeValidator(plain)] | None = None
    """Which of the bodies of each link a distance is about, counted from 0; all of both if not given."""
    distance: Annotated[float, Field(ge=0.0)]
    """How far apart they are kept where that is less than the safety distance, m."""


class PairsEntry(_OfRobot):
    """Pairs of links, beside those that are found by themselves."""

    left_out: Annotated[tuple[PairEntry, ...], BeforeValidator(plain)] = ()
    """Pairs that are not checked, beside those that are found."""
    distances: Annotated[tuple[DistanceEntry, ...], BeforeValidator(plain)] = ()
    """Pairs with a distance of their own, beside those that are found."""
    complete: bool = False
    """Whether these are all: then none is looked for, nor taken from the SRDF. `robot.save` writes it."""


class RobotFile(_OfRobot):
    """A robot: its URDF and what that does not say. Metres, radians and seconds.

    Raises:
        InvalidInput: If a field is not valid.
    """

    urdf: str
    """URDF or xacro: a path relative to this file, or to the models of `package`; or `PACKAGE:ROBOT`."""
    name: str | None = None
    """What the robot is called; the name in the URDF if not given."""
    srdf: str | None = None
    """SRDF, found as the URDF is."""
    package: str | None = None
    """The Python package whose models the robot is one of, such as `example-robot-data>=5`."""
    packages: Names = ()
    """Folders of ROS packages, or folders that hold them, relative to this file."""
    xacro: dict[str, str | int | float | bool] = Field(default_factory=dict)
    """Arguments of the xacro."""
    hands: dict[str, HandOrFrame] | None = None
    """The hands by name, or their frames; found by themselves if not given."""
    joints: Names | None = None
    """The joints that move; those that a hand needs if not given."""
    locked: Annotated[Positions, BeforeValidator(_in_words, json_schema_input_type=Positions | str)] = Field(
        default_factory=dict
    )
    """Where joints stand that do not move. Those not named here stand at 0, or at their limit next to it."""
    locked_joints: Names = ()
    """Joints that do not move, whatever else."""
    locked_already: Positions = Field(default_factory=dict)
    """Joints of the original that are fixed in this URDF, and where they stand: written by `robot.save`."""
    continuous_joints_within: Annotated[tuple[Number, Number], BeforeValidator(plain)] = (-FULL_TURN, FULL_TURN)
    """Joints without end are kept within this, rad."""
    limits: dict[str, LimitEntry] = Field(default_factory=dict)
    """Limits by joint, instead of those of the URDF."""
    acceleration_time: Positive | None = None
    """Joints without a limit of acceleration get one by which they reach their speed limit in this time, s."""
    as_written: bool = False
    """Whether the limits of the URDF are taken as they are, with none assumed: written by `robot.save`."""
    postures: dict[str, Positions] = Field(default_factory=dict)
    """Postures by name, beside those of the SRDF."""
    initial: Start | None = None
    """Where motions start unless a scene says otherwise: a posture's name, positions by joint (of the others as by
    itself), or all of them. Found by itself if not given."""
    base: BaseEntry = BaseEntry()
    """Where the root of the URDF stands."""
    pairs: PairsEntry = PairsEntry()
    """Pairs of links that are not checked against each other, or kept nearer than others."""
    decomposed: Names | None = None
    """Links whose meshes are cut into convex pieces; those whose hulls cost freedom if not given."""
    assumed: Names = ()
    """What was found or assumed before this file was written, in sentences."""


def read_robot_file(path: str | Path) -> RobotFile:
    """Return the robot file at a path, or in a folder as `robot.yaml`.

    Raises:
        InvalidInput: If it is missing, is not YAML or no robot file; the error names the field.
    """
    file = Path(path)
    try:
        file = file / NAME if file.is_dir() else file
        text = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise InvalidInput("robot", str(file), f"a robot file that can be read ({error})") from None
    return make_robot_file(parse_yaml("robot", text, str(file)), str(file))


def make_robot_file(data: object, source: str | None = None) -> RobotFile:
    """Return a robot file from plain data.

    Raises:
        InvalidInput: If they are none; the error names the field.
    """
    if not isinstance(data, Mapping):
        raise InvalidInput("robot", data, "a mapping with the keys of a robot file; see docs/robots.md", source)
    try:
        return RobotFile.model_validate(dict(data))
    except ValidationError as error:
        raise invalid_input(error, source, root="robot") from None
