"""What hands have to reach: points, poses or nothing, at once or one after the other; as frozen, validated data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Self

import numpy as np
import pinocchio as pin
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from humanoid_rail._arrays import Array
from humanoid_rail._validation import Angles, Frozen, Vector, plain
from humanoid_rail.scene.obstacles import not_zero

ANY_AXIS = (1.0, 0.0, 0.0)
"""This axis of its frame shows how a hand is turned that points nowhere."""
SAME = 1e-6
"""Targets that differ by no more than this along each axis are at the same place, m."""


class Pose(Frozen):
    """A point that a hand has to reach, and how it has to be turned there."""

    position: Vector
    """Where the hand has to be, m."""
    approach: Annotated[Vector, AfterValidator(not_zero)] | None = None
    """Direction along which the hand has to point, of any length; it may turn about it."""
    rpy: Angles | None = None
    """Orientation of the hand's frame as in URDF: roll, pitch and yaw about the fixed axes x, y, z, rad."""

    @model_validator(mode="after")
    def _at_most_one(self) -> Self:
        if self.approach is not None and self.rpy is not None:
            raise ValueError("approach or rpy, not both")
        return self


def _kind_of_target(value: object) -> str:
    if value is None:
        return "<free>"
    return "<pose>" if isinstance(value, Mapping | Pose) else "<point>"


def _kind_of_targets(value: object) -> str:
    return "<one after the other>" if isinstance(value, list | tuple) else "<once>"


Target = Annotated[
    Annotated[Vector, Tag("<point>")] | Annotated[Pose, Tag("<pose>")] | Annotated[None, Tag("<free>")],
    Discriminator(_kind_of_target),
]
"""A point, a pose, or None for a hand that may stay wherever is convenient."""

Step = dict[str, Target]
"""What the hands have to reach at the same time, by their names."""

Targets = Annotated[
    Annotated[Step, Tag("<once>")]
    | Annotated[tuple[Step, ...], Field(min_length=1), BeforeValidator(plain), Tag("<one after the other>")],
    Discriminator(_kind_of_targets),
]
"""One step, or several that follow each other."""


def position(target: Vector | Pose) -> Vector:
    """Return the point of a target, m."""
    return target.position if isinstance(target, Pose) else target


def direction(target: Target, pointing: tuple[float, float, float] | None) -> Array | None:
    """Return the unit vector (3,) in which a target has a hand point; None if it may point anywhere.

    Args:
        target: The target.
        pointing: The direction in the hand's frame in which it points; `ANY_AXIS` if it points nowhere.
    """
    if not isinstance(target, Pose) or not is_oriented(target):
        return None
    axis = np.array(pointing or ANY_AXIS)
    along = np.array(target.approach if target.rpy is None else pin.rpy.rpyToMatrix(*target.rpy) @ axis)
    unit: Array = along / np.linalg.norm(along)
    return unit


def is_oriented(target: Target) -> bool:
    """Return whether a target asks for more than a point."""
    return isinstance(target, Pose) and (target.approach is not None or target.rpy is not None)


def numbers_there(steps: Sequence[Mapping[str, Target | None]], step: int, hand: str) -> str:
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
