"""What is kept on the way to the targets of a step, as frozen, validated data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BeforeValidator, model_validator

from humanoid_rail._validation import Frozen, Vector, plain
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.scene.obstacles import not_zero


def _hand(value: object) -> object:
    return {"hand": value} if isinstance(value, str) else value


def _hands(value: object) -> object:
    return {"hands": value} if isinstance(value, list | tuple) else value


def _two(hands: tuple[str, str]) -> tuple[str, str]:
    if hands[0] == hands[1]:
        raise ValueError("two hands, not one twice")
    return hands


Direction = Annotated[Vector, AfterValidator(not_zero)]
TwoHands = Annotated[tuple[str, str], BeforeValidator(plain), AfterValidator(_two)]


class Upright(Frozen):
    """An axis of a hand that stays along a direction, as of a tray that stays level."""

    hand: str
    """Name of the hand. It may be all that is given."""
    axis: Direction | None = None
    """The axis in the hand's frame, of any length; the one that points in the direction at the beginning if not
    given."""
    direction: Direction = (0.0, 0.0, 1.0)
    """Where the axis points, in the base frame, of any length; up if not given."""


class OnLine(Frozen):
    """A hand that stays on the straight line through where it is at the beginning."""

    hand: str
    """Name of the hand."""
    direction: Direction
    """Where the line runs, in the base frame, of any length."""


class Relative(Frozen):
    """Two hands that stay to each other as they are at the beginning."""

    hands: TwoHands
    """Names of the hands. They may be all that is given."""
    what: Literal["pose", "place", "difference"] = "pose"
    """What of the second hand stays: its pose in the frame of the first, its place there, or the difference of their
    points in the base frame."""


class Keep(Frozen):
    """One thing that is kept; by default as it is at the beginning."""

    upright: Annotated[Upright, BeforeValidator(_hand)] | None = None
    """An axis of a hand: a hand's name, or an :class:`Upright`."""
    orientation: str | None = None
    """The orientation of a hand, by its name."""
    point: str | None = None
    """The place of a hand, by its name."""
    line: OnLine | None = None
    """A hand on a line."""
    distance: TwoHands | None = None
    """The distance of two hands, by their names."""
    relative: Annotated[Relative, BeforeValidator(_hands)] | None = None
    """What two hands are to each other: their names, or a :class:`Relative`."""

    @model_validator(mode="after")
    def _one_thing(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"one of {', '.join(type(self).model_fields)}, each in an entry of its own")
        return self

    @property
    def hands(self) -> tuple[str, ...]:
        """The names of the hands that it is about."""
        for one in (self.upright, self.line):
            if one is not None:
                return (one.hand,)
        if self.relative is not None:
            return self.relative.hands
        if self.distance is not None:
            return self.distance
        return tuple(name for name in (self.orientation, self.point) if name is not None)


def kept_hands(keep: Sequence[Keep]) -> Iterator[str]:
    """Yield the names of the hands of what is kept."""
    for one in keep:
        yield from one.hands


def check_keep(hands: Sequence[str], keep: Sequence[Keep], where: str) -> None:
    """Check that a robot has the hands that are named.

    Args:
        hands: Names of the robot's hands.
        keep: What is kept.
        where: What errors call the step.

    Raises:
        InvalidInput: If it has not.
    """
    for i, one in enumerate(keep):
        for hand in one.hands:
            if hand not in hands:
                valid = f"one of {', '.join(hands)}, the hands of the robot{did_you_mean(hand, hands)}"
                raise InvalidInput(f"{where}.keep[{i}]", hand, valid)


def plain_keep(value: object) -> object:
    """Take a single thing that is kept for a list of one."""
    return plain([value] if isinstance(value, Mapping | Keep) else value)
