"""What hands have to reach: points, poses or nothing, at once or one after the other; as frozen, validated data."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from humanoid_rail._validation import Frozen, Number, plain
from humanoid_rail.errors import did_you_mean
from humanoid_rail.scene.keep import Keep, plain_keep
from humanoid_rail.scene.poses import (
    ANY_AXIS,
    AnyOf,
    Line,
    Pose,
    Straight,
    Target,
    alternatives,
    direction,
    is_oriented,
    orientation,
    pointing_direction,
    position,
)

__all__ = [
    "ANY_AXIS",
    "SAME",
    "AnyOf",
    "Line",
    "Pose",
    "Step",
    "Straight",
    "Target",
    "Targets",
    "alternatives",
    "direction",
    "is_oriented",
    "numbers_there",
    "orientation",
    "pointing_direction",
    "position",
]

SAME = 1e-6
"""Targets that differ by no more than this along each axis are at the same place, m."""


def _kind_of_targets(value: object) -> str:
    return "<one after the other>" if isinstance(value, list | tuple) else "<once>"


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
        """Take any key that is no misspelt field: the others are names of hands, which the robot knows."""
        if not isinstance(data, Mapping):
            return data
        left = [name for name in cls.model_fields if name not in data]
        for i, (key, value) in enumerate(data.items()):
            near = did_you_mean(str(key), left)
            is_target = isinstance(value, Mapping) and value.keys() & {
                *Pose.model_fields,
                *Line.model_fields,
                *AnyOf.model_fields,
            }
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

    @property
    def combinations(self) -> tuple[Step, ...]:
        """The steps of which one has to be done: with every combination of the hands' alternatives."""
        if not any(isinstance(target, AnyOf) for target in self.values()):
            return (self,)
        choices = product(*map(alternatives, self.values()))
        return tuple(self.with_targets(dict(zip(self, chosen, strict=True))) for chosen in choices)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Step:
        """Return a copy with some fields or targets changed, validated like any other.

        Args:
            update: The fields to change, or targets by the names of hands.
            deep: Has no effect: nothing here can be changed.

        Raises:
            InvalidInput: If a field is not valid.
        """
        return Step(**{**self._fields(), **self.hands, **(update or {})})

    def _fields(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in type(self).model_fields}

    def with_targets(self, hands: Mapping[str, Target]) -> Step:
        """Return the same step with other targets, by the names of the hands."""
        return Step(**{**self._fields(), **hands})


if TYPE_CHECKING:
    Targets = Step | Mapping[str, Target] | Sequence[Step | Mapping[str, Target]]
else:
    Targets = Annotated[
        Annotated[Step, Tag("<once>")]
        | Annotated[tuple[Step, ...], Field(min_length=1), BeforeValidator(plain), Tag("<one after the other>")],
        Discriminator(_kind_of_targets),
    ]
    """One step, or several that follow each other."""


def numbers_there(steps: Sequence[Step], step: int, hand: str, choice: int = 0) -> str:
    """Return the numbers from 1 of all steps in which a hand has its target where it has it in one, such as `2, 3`.

    Args:
        steps: The targets of each step, by hand.
        step: The one, from 0, in which the hand has a target.
        hand: Name of the hand.
        choice: Which of its targets it is there, from 0, if it has several of which one has to be reached.
    """
    there = alternatives(steps[step][hand])[choice]
    assert there is not None
    same = [
        number
        for number, targets in enumerate(steps, start=1)
        if any(
            one is not None and np.allclose(position(one), position(there), rtol=0.0, atol=SAME)
            for one in alternatives(targets.get(hand))
        )
    ]
    return ", ".join(map(str, same))
