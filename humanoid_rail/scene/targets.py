"""What hands have to reach: points, poses or nothing, at once or one after the other; as frozen, validated data."""

from __future__ import annotations

import math
from collections.abc import ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np
import pinocchio as pin
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from humanoid_rail._arrays import Array
from humanoid_rail._validation import Angles, Frozen, Number, Positive, Vector, plain
from humanoid_rail.scene.keep import Keep, plain_keep
from humanoid_rail.scene.obstacles import not_zero

ANY_AXIS = (1.0, 0.0, 0.0)
"""This axis of its frame shows how a hand is turned that points nowhere."""
SAME = 1e-6
"""Targets that differ by no more than this along each axis are at the same place, m."""


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

    @model_validator(mode="after")
    def _at_most_one(self) -> Self:
        given = {"approach": pointing_direction(self), "rpy": self.rpy, "quaternion": self.quaternion}
        if len(names := [name for name, value in given.items() if value is not None]) > 1:
            raise ValueError(f"one of approach, rpy and quaternion, not {' and '.join(names)}")
        return self


def _kind_of_target(value: object) -> str:
    if value is None:
        return "<free>"
    if isinstance(value, Line) or (isinstance(value, Mapping) and "end" in value):
        return "<line>"
    return "<pose>" if isinstance(value, Mapping | Pose) else "<point>"


def _kind_of_targets(value: object) -> str:
    return "<one after the other>" if isinstance(value, list | tuple) else "<once>"


class Line(Frozen):
    """A straight path of a hand, which keeps its orientation on it."""

    end: Vector
    """The point where it ends, m."""
    start: Vector | None = None
    """The point where it begins, m, to which the hand moves first; where the hand is if not given."""


Target = Annotated[
    Annotated[Vector, Tag("<point>")]
    | Annotated[Pose, Tag("<pose>")]
    | Annotated[Line, Tag("<line>")]
    | Annotated[None, Tag("<free>")],
    Discriminator(_kind_of_target),
]
"""A point, a pose, a line, or None for a hand that may stay wherever is convenient."""


class Step(Frozen):
    """What the hands have to reach at the same time: a target for each, by the names of the hands.

    It is read like a mapping of the hands' names to their targets.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Target]

    joints: Mapping[str, Number] = {}
    """Where joints have to be, by their names, m and rad. It counts before the posture."""
    posture: str | None = None
    """The name of a posture of the robot. Its joints have to be there, but for those that move a hand which has a
    target."""
    stop: bool = True
    """Whether the motion rests at these targets. If not, it passes them and goes on to the next ones; those of the last
    step it always rests at."""
    grasp: Mapping[str, str] = {}
    """What hands grasp once the targets are reached: the names of objects by those of hands. An object that two hands
    grasp is held by both."""
    release: Mapping[str, str] = {}
    """What hands let go of once the targets are reached, before others are grasped: the names of objects by hands."""
    contacts: Mapping[str, Annotated[tuple[str, ...], BeforeValidator(plain)]] = {}
    """What a held object may touch on the straight ways of this step, by its name: obstacles and other objects, such as
    what it is put down on. What it stands on when it is grasped it may touch on the way from there in any case."""

    keep: Annotated[tuple[Keep, ...], BeforeValidator(plain_keep)] = ()
    """What is kept on the way to the targets, as it is when that begins; see :class:`Keep`."""

    @property
    def hands(self) -> Mapping[str, Target]:
        """The targets by the names of the hands."""
        return self.__pydantic_extra__

    @model_validator(mode="before")
    @classmethod
    def _know_every_key(cls, data: object) -> object:
        """Take any key: those that are no fields are names of hands, which the robot knows."""
        return data

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Mapping):
            return self == Step(**other)
        return super().__eq__(other)

    def __hash__(self) -> int:
        return hash(tuple(self.items()))

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]
        return iter(self.hands)

    def __getitem__(self, hand: str) -> Target:
        """Return the target of a hand; None for one that is not named where joints have to be somewhere."""
        return self.hands.get(hand) if self.has_joints else self.hands[hand]

    def __contains__(self, hand: object) -> bool:
        return hand in self.hands

    def __len__(self) -> int:
        return len(self.hands)

    @property
    def has_joints(self) -> bool:
        """Whether joints have to be somewhere."""
        return bool(self.joints) or self.posture is not None

    def get(self, hand: str) -> Target:
        """Return the target of a hand; None also for a hand that has none."""
        return self.hands.get(hand)

    def keys(self) -> KeysView[str]:
        """Return the names of the hands."""
        return self.hands.keys()

    def values(self) -> ValuesView[Target]:
        """Return the targets."""
        return self.hands.values()

    def items(self) -> ItemsView[str, Target]:
        """Return the names of the hands with their targets."""
        return self.hands.items()

    def with_targets(self, hands: Mapping[str, Target]) -> Step:
        """Return the same step with other targets, by the names of the hands."""
        return Step(**{**{name: getattr(self, name) for name in type(self).model_fields}, **hands})


if TYPE_CHECKING:
    Targets = Step | Mapping[str, Target] | Sequence[Step | Mapping[str, Target]]
else:
    Targets = Annotated[
        Annotated[Step, Tag("<once>")]
        | Annotated[tuple[Step, ...], Field(min_length=1), BeforeValidator(plain), Tag("<one after the other>")],
        Discriminator(_kind_of_targets),
    ]
    """One step, or several that follow each other."""


def position(target: Vector | Pose | Line) -> Vector:
    """Return the point of a target, m; of a line its end."""
    match target:
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
    return isinstance(target, Pose) and (pointing_direction(target) is not None or orientation(target) is not None)


def numbers_there(steps: Sequence[Step], step: int, hand: str) -> str:
    """Return the numbers from 1 of all steps in which a hand has its target where it has it in one, such as `2, 3`.

    Args:
        steps: The targets of each step, by hand.
        step: The one, from 0, in which the hand has a target.
        hand: Name of the hand.
    """
    there = steps[step][hand]
    assert there is not None
    same = [
        number
        for number, targets in enumerate(steps, start=1)
        if (other := targets[hand]) is not None and np.allclose(position(other), position(there), rtol=0.0, atol=SAME)
    ]
    return ", ".join(map(str, same))
