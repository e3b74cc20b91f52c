"""What a hand has to reach: a point, a pose, a line, or one of several; as frozen, validated data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
import pinocchio as pin
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, PrivateAttr, Tag, model_validator

from humanoid_rail._arrays import FARTHEST, Array
from humanoid_rail._validation import Angles, Frozen, Number, Positive, Vector, plain
from humanoid_rail.scene.obstacles import not_zero

ANY_AXIS = (1.0, 0.0, 0.0)
"""This axis of its frame shows how a hand is turned that points nowhere."""
UNIT = 1e-3
"""A quaternion is of length 1 to within this; it is made so exactly."""


def _four(value: object) -> object:
    value = plain(value)
    if not isinstance(value, tuple) or len(value) != 4:
        raise ValueError("four numbers [w, x, y, z], the real part first")
    return value


def _of_length_1(value: Quaternion) -> Quaternion:
    if not abs((length := math.hypot(*value)) - 1.0) <= UNIT:
        raise ValueError(f"a quaternion [w, x, y, z] of length 1; its length is {length:.6g}")
    w, x, y, z = value
    return w / length, x / length, y / length, z / length


Quaternion = tuple[Number, Number, Number, Number]
NotNegative = Annotated[float, Field(ge=0.0, le=FARTHEST)]
Tolerance = NotNegative | tuple[NotNegative, NotNegative, NotNegative]
Row = tuple[float, float, float]


class Straight(Frozen):
    """A straight way of a hand to its target or away from it."""

    direction: Annotated[Vector, AfterValidator(not_zero)]
    """Along which the hand moves, of any length."""
    distance: Positive
    """How far, m."""
    pointing: bool = False
    """Whether the hand points in this direction at the target; it may turn about it."""


def _kind_of_approach(value: object) -> str:
    return "<straight>" if isinstance(value, Mapping | Straight) else "<direction>"


class Pose(Frozen):
    """A point that a hand has to reach, how it has to be turned there, and how it comes and goes."""

    position: Vector
    """Where the hand has to be, m."""
    frame: str | None = None
    """The name of an obstacle, an object or a bay of a shelf, such as `shelf/bay 2`: then all of the pose is in its
    frame, where that is at the beginning. The base frame if not given."""
    approach: (
        Annotated[
            Annotated[Annotated[Vector, AfterValidator(not_zero)], Tag("<direction>")]
            | Annotated[Straight, Tag("<straight>")],
            Discriminator(_kind_of_approach),
        ]
        | None
    ) = None
    """Direction along which the hand has to point, of any length; it may turn about it. Or a :class:`Straight`: the
    hand comes straight along it, and need not point anywhere."""
    retreat: Straight | None = None
    """The straight way that the hand takes from there, once it has grasped or released what the step says."""
    rpy: Angles | None = None
    """Orientation of the hand's frame as in URDF: roll, pitch and yaw about the fixed axes x, y, z, rad."""
    quaternion: Annotated[Quaternion, BeforeValidator(_four), AfterValidator(_of_length_1)] | None = None
    """The same as a quaternion [w, x, y, z], the real part first, of length 1."""
    tolerance: Annotated[Tolerance, BeforeValidator(plain)] | None = None
    """How far from the position the hand may be along each axis of the frame that it is given in, m: one number, or one
    for each axis."""
    angle_tolerance: Annotated[float, Field(ge=0.0, le=math.pi / 2)] | None = None
    """By what angle the hand may be turned otherwise, rad, of at most a quarter turn."""
    _axes: tuple[Row, Row, Row] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _at_most_one(self) -> Self:
        given = {"approach": pointing_direction(self), "rpy": self.rpy, "quaternion": self.quaternion}
        if len(names := [name for name, value in given.items() if value is not None]) > 1:
            raise ValueError(f"one of approach, rpy and quaternion, not {' and '.join(names)}")
        if self.angle_tolerance is not None and not names:
            raise ValueError(
                "approach, rpy or quaternion with angle_tolerance: without one the hand may turn as it likes"
            )
        return self

    @property
    def axes(self) -> tuple[Row, Row, Row] | None:
        """The axes of the frame that the position was given in, if that was not the base frame."""
        return self._axes

    def in_axes(self, axes: tuple[Row, Row, Row]) -> Pose:
        """Return the same pose with its tolerance along other axes, given in the base frame."""
        found = self.model_copy()
        found._axes = axes
        return found


def _kind_of_target(value: object) -> str:
    if value is None:
        return "<free>"
    if isinstance(value, Line) or (isinstance(value, Mapping) and _is_line(value)):
        return "<line>"
    if isinstance(value, AnyOf) or (isinstance(value, Mapping) and "any_of" in value):
        return "<any of>"
    return _kind_of_alternative(value)


def _is_line(keys: Mapping[str, object]) -> bool:
    return "end" in keys or ("start" in keys and "position" not in keys)


def _kind_of_alternative(value: object) -> str:
    return "<pose>" if isinstance(value, Mapping | Pose) else "<point>"


class Line(Frozen):
    """A straight path of a hand, which keeps its orientation on it."""

    end: Vector
    """The point where it ends, m."""
    start: Vector | None = None
    """The point where it begins, m, to which the hand moves first; where the hand is if not given."""


class AnyOf(Frozen):
    """Several targets of a hand, of which one has to be reached."""

    any_of: Annotated[
        tuple[
            Annotated[
                Annotated[Vector, Tag("<point>")] | Annotated[Pose, Tag("<pose>")], Discriminator(_kind_of_alternative)
            ],
            ...,
        ],
        Field(min_length=1),
        BeforeValidator(plain),
    ]
    """The targets, points and poses. `auto` takes the one with the shortest path, other methods the nearest."""


Target = Annotated[
    Annotated[Vector, Tag("<point>")]
    | Annotated[Pose, Tag("<pose>")]
    | Annotated[AnyOf, Tag("<any of>")]
    | Annotated[Line, Tag("<line>")]
    | Annotated[None, Tag("<free>")],
    Discriminator(_kind_of_target),
]
"""A point, a pose, a line, one of several, or None for a hand that may stay wherever is convenient."""


def alternatives(target: Target) -> tuple[Target, ...]:
    """Return the targets of which one has to be reached: one alone where there are not several."""
    return target.any_of if isinstance(target, AnyOf) else (target,)


def position(target: Vector | Pose | Line | AnyOf) -> Vector:
    """Return the point of a target, m; of a line its end, of several the first."""
    match target:
        case AnyOf():
            return position(target.any_of[0])
        case Pose():
            return target.position
        case Line():
            return target.end
    return target


def pointing_direction(pose: Pose) -> Vector | None:
    """Return the direction in which the hand has to point; None if none is given."""
    if isinstance(pose.approach, Straight):
        return pose.approach.direction if pose.approach.pointing else None
    return pose.approach


def orientation(pose: Pose) -> Array | None:
    """Return the rotation (3, 3) that the hand's frame has to have; None if none is given."""
    if pose.quaternion is not None:
        w, x, y, z = pose.quaternion
        turned: Array = pin.Quaternion(w, x, y, z).toRotationMatrix()
        return turned
    return None if pose.rpy is None else pin.rpy.rpyToMatrix(*pose.rpy)


def direction(target: Target, pointing: tuple[float, float, float] | None) -> Array | None:
    """Return the unit vector (3,) in which a target has a hand point; None if it may point anywhere.

    Args:
        target: The target.
        pointing: The direction in the hand's frame in which it points; `ANY_AXIS` if it points nowhere.
    """
    if not isinstance(target, Pose) or not is_oriented(target):
        return None
    axis = np.array(pointing or ANY_AXIS)
    turned = orientation(target)
    along = np.array(pointing_direction(target)) if turned is None else turned @ axis
    unit: Array = along / np.linalg.norm(along)
    return unit


def is_oriented(target: Target) -> bool:
    """Return whether a target asks for more than a point."""
    if isinstance(target, AnyOf):
        return any(map(is_oriented, target.any_of))
    return isinstance(target, Pose) and (pointing_direction(target) is not None or orientation(target) is not None)
