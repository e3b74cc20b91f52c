"""What hands have to reach: points, poses or nothing, at once or one after the other; as frozen, validated data."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np
import pinocchio as pin
from pydantic import AfterValidator, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from humanoid_rail._arrays import Array
from humanoid_rail._validation import Angles, Frozen, Positive, Vector, plain
from humanoid_rail.errors import did_you_mean
from humanoid_rail.scene.keep import Keep, plain_keep
from humanoid_rail.scene.obstacles import not_zero

ANY_AXIS = (1.0, 0.0, 0.0)
"""This axis of its frame shows how a hand is turned that points nowhere."""
SAME = 1e-6
"""Targets that differ by no more than this along each axis are at the same place, m."""


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

    @model_validator(mode="after")
    def _at_most_one(self) -> Self:
        if pointing_direction(self) is not None and self.rpy is not None:
            raise ValueError("approach or rpy, not both")
        return self


def _kind_of_target(value: object) -> str:
    if value is None:
        return "<free>"
    if isinstance(value, Line) or (isinstance(value, Mapping) and _is_line(value)):
        return "<line>"
    return "<pose>" if isinstance(value, Mapping | Pose) else "<point>"


def _is_line(keys: Mapping[str, object]) -> bool:
    return "end" in keys or ("start" in keys and "position" not in keys)


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
        """Take any key that is no misspelt field: the others are names of hands, which the robot knows."""
        if not isinstance(data, Mapping):
            return data
        left = [name for name in cls.model_fields if name not in data]
        for i, (key, value) in enumerate(data.items()):
            near = did_you_mean(str(key), left)
            is_target = isinstance(value, Mapping) and value.keys() & {*Pose.model_fields, *Line.model_fields}
            if near and key not in cls.model_fields and isinstance(value, Mapping) and not is_target:
                valid = f"the name of a hand with its target, or one of {', '.join(cls.model_fields)}{near}"
                raise PydanticCustomError("unknown_key", "{valid}", {"valid": valid, "number": i})
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
        return self.hands[hand]

    def __contains__(self, hand: object) -> bool:
        return hand in self.hands

    def __len__(self) -> int:
        return len(self.hands)

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


def direction(target: Target, pointing: tuple[float, float, float] | None) -> Array | None:
    """Return the unit vector (3,) in which a target has a hand point; None if it may point anywhere.

    Args:
        target: The target.
        pointing: The direction in the hand's frame in which it points; `ANY_AXIS` if it points nowhere.
    """
    if not isinstance(target, Pose) or not is_oriented(target):
        return None
    axis = np.array(pointing or ANY_AXIS)
    along = np.array(pointing_direction(target) if target.rpy is None else pin.rpy.rpyToMatrix(*target.rpy) @ axis)
    unit: Array = along / np.linalg.norm(along)
    return unit


def is_oriented(target: Target) -> bool:
    """Return whether a target asks for more than a point."""
    return isinstance(target, Pose) and (pointing_direction(target) is not None or target.rpy is not None)


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
