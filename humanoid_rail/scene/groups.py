"""Obstacles that are placed, repeated or built together: groups and shelves, which a scene has as single obstacles."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
import pinocchio as pin
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from humanoid_rail._arrays import triple
from humanoid_rail._validation import Angles, Frozen, Positive, Size, Vector, plain
from humanoid_rail.scene.covers import HeightField, PointCloud
from humanoid_rail.scene.obstacle import LONGEST_NAME, ObstacleBase
from humanoid_rail.scene.obstacles import Box, Capsule, Cylinder, HalfSpace, Mesh, Obstacle, Sphere
from humanoid_rail.scene.placing import frame_of, put_into

MOST_OBSTACLES = 10_000
"""The groups and shelves of a scene make so many obstacles at most."""


def _count(value: int) -> int:
    if not 1 <= value <= MOST_OBSTACLES:
        raise ValueError(f"a whole number from 1 to {MOST_OBSTACLES}")
    return value


Count = Annotated[int, AfterValidator(_count), Field(json_schema_extra={"minimum": 1, "maximum": MOST_OBSTACLES})]


def _counts(value: object) -> object:
    value = plain(value)
    numbers = value if isinstance(value, tuple) else (value,)
    are_whole = all(isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= MOST_OBSTACLES for n in numbers)
    if are_whole and len(numbers) in (1, 3) and (len(numbers) == 3) == isinstance(value, tuple):
        return value
    raise ValueError(f"a whole number from 1 to {MOST_OBSTACLES}, or three of them for x, y and z")


class Repeat(Frozen):
    """Copies of a group, each a step from the one before."""

    count: Annotated[int | tuple[int, int, int], BeforeValidator(_counts)]
    """How many there are in all, in a row; or in a grid along the group's x, y and z axes."""
    step: Vector
    """From each copy to the next one, in the group's frame, m: of a row, or along each axis of a grid."""

    @property
    def size(self) -> int:
        """How many copies there are."""
        return self.count if isinstance(self.count, int) else prod(self.count)

    @property
    def places(self) -> dict[str, tuple[float, float, float]]:
        """Where the origins of the copies are in the group's frame, m, by their numbers from 1, as `2` or `1-3`."""
        x, y, z = self.step
        if isinstance(self.count, int):
            return {f"{i + 1}": (i * x, i * y, i * z) for i in range(self.count)}
        counted = [axis for axis in range(3) if self.count[axis] > 1]
        return {
            "-".join(str(at[axis] + 1) for axis in counted): (at[0] * x, at[1] * y, at[2] * z)
            for at in product(*map(range, self.count))
        }


class Group(ObstacleBase):
    """Obstacles that are placed together, once or several times. In a scene it is these obstacles, `NAME/...`."""

    type: Literal["group"] = "group"
    obstacles: Annotated[tuple[Entry, ...], BeforeValidator(plain), Field(min_length=1)]
    """Its obstacles, in its own frame; groups and shelves too."""
    center: Vector = (0.0, 0.0, 0.0)
    """Where the origin of its frame is, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """How its frame is turned about the fixed axes x, y, z in this order, as in URDF, rad."""
    repeat: Repeat | None = None
    """Copies of it, if given."""

    @model_validator(mode="after")
    def _few_enough(self) -> Self:
        _check_count(count_of(self))
        return self


class Shelf(ObstacleBase):
    """A shelf of boards, open in front, which is where its x axis points. In a scene it is these boxes, `NAME/...`."""

    type: Literal["shelf"] = "shelf"
    center: Vector
    """The middle of its underside, m."""
    size: Size
    """Depth (along x), width (y) and height (z), boards included, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad: the third turns its front."""
    rows: Count = 3
    """How many bays are one above the other."""
    columns: Count = 1
    """How many bays are side by side."""
    thickness: Positive = 0.02
    """How thick the boards are, m."""
    back: bool = True
    """Whether it has a back."""

    @model_validator(mode="after")
    def _has_bays(self) -> Self:
        depth, width, height = self.size
        for name, length, count in (("columns", width, self.columns), ("rows", height, self.rows)):
            if length <= (count + 1) * self.thickness:
                valid = f"a size and a thickness that leave room between {count + 1} boards, for the {name}"
                raise ValueError(f"{valid}: more than {(count + 1) * self.thickness:.4g} m, not {length:g} m")
        if depth <= self.thickness:
            raise ValueError(f"a depth of more than the thickness, {self.thickness:g} m")
        _check_count(count_of(self))
        return self


if TYPE_CHECKING:
    Entry = Obstacle | Group | Shelf
    SceneObstacles = tuple[Obstacle, ...]
else:
    Entry = Annotated[
        Sphere | Box | Capsule | Cylinder | HalfSpace | Mesh | HeightField | PointCloud | Group | Shelf,
        Field(discriminator="type"),
    ]
    Group.model_rebuild()


def boards(shelf: Shelf) -> tuple[Box, ...]:
    """Return the boards of a shelf in its own frame, named: `board` is horizontal and `side` upright, from 1."""
    depth, width, height = shelf.size
    thick = shelf.thickness
    boxes = [
        Box(name=f"board {i + 1}", center=(0.0, 0.0, z), size=(depth, width, thick))
        for i, z in enumerate(np.linspace(thick / 2, height - thick / 2, shelf.rows + 1).tolist())
    ]
    boxes += [
        Box(name=f"side {i + 1}", center=(0.0, y, height / 2), size=(depth, thick, height))
        for i, y in enumerate(np.linspace(-(width - thick) / 2, (width - thick) / 2, shelf.columns + 1).tolist())
    ]
    if shelf.back:
        boxes.append(Box(name="back", center=((thick - depth) / 2, 0.0, height / 2), size=(thick, width, height)))
    return tuple(boxes)


def flat_obstacles(entries: Sequence[Obstacle | Group | Shelf]) -> tuple[Obstacle, ...]:
    """Return obstacles with groups and shelves as what they are made of, each `NAME/...`, where that is.

    A scene does this by itself with the obstacles that it is given.

    Raises:
        ValueError: If they are too many, a name gets too long, or a value is not valid where a group has put it.
    """
    _check_count(sum(count_of(entry) for entry in entries if isinstance(entry, Group | Shelf)))
    return tuple(_flat(entries))


def count_of(entry: Obstacle | Group | Shelf) -> int:
    """Return how many obstacles an entry of a scene is."""
    match entry:
        case Group():
            copies = 1 if entry.repeat is None else entry.repeat.size
            return copies * sum(map(count_of, entry.obstacles))
        case Shelf():
            return entry.rows + entry.columns + 2 + entry.back
        case _:
            return 1


def _check_count(count: int) -> None:
    if count > MOST_OBSTACLES:
        raise ValueError(f"groups and shelves that make at most {MOST_OBSTACLES} obstacles, not {count}")


def _flat(entries: Sequence[Obstacle | Group | Shelf]) -> Iterator[Obstacle]:
    labels = iter(_labels([entry for entry in entries if isinstance(entry, Group | Shelf)]))
    for entry in entries:
        if isinstance(entry, Group | Shelf):
            yield from _parts(entry, next(labels))
        else:
            yield entry


def _parts(entry: Group | Shelf, label: str) -> Iterator[Obstacle]:
    """Yield what a group or a shelf is made of, where it is."""
    own = boards(entry) if isinstance(entry, Shelf) else tuple(_flat(entry.obstacles))
    names, frame = _labels(own), frame_of(entry.center, entry.rpy)
    repeat = entry.repeat if isinstance(entry, Group) else None
    for number, place in ({"": (0.0, 0.0, 0.0)} if repeat is None else repeat.places).items():
        here = frame * pin.SE3(np.eye(3), np.array(place))
        for part, name in zip(own, names, strict=True):
            whole = f"{label} {number}/{name}" if number else f"{label}/{name}"
            if len(whole) > LONGEST_NAME:
                raise ValueError(f"names of groups that leave {whole!r} no longer than {LONGEST_NAME} characters")
            velocity = triple(entry.velocity + here.rotation @ part.velocity)
            more = {"name": whole, "color": part.color or entry.color, "velocity": velocity}
            yield put_into(here, part, more)


def _labels(entries: Sequence[Obstacle | Group | Shelf]) -> list[str]:
    """Return what each is called, by its name or its type; numbered from 1 where several would be called the same."""
    own = [entry.name or entry.type for entry in entries]
    many = {label for label, count in Counter(own).items() if count > 1}
    used = {label for label in own if label not in many}
    labels, last = [], Counter[str]()
    for label in own:
        called = label
        while label in many and (called == label or called in used):
            last[label] += 1
            called = f"{label} {last[label]}"
        used.add(called)
        labels.append(called)
    return labels


if not TYPE_CHECKING:
    SceneObstacles = Annotated[tuple[Entry, ...], BeforeValidator(plain), AfterValidator(flat_obstacles)]
    """The obstacles of a scene, which groups and shelves are turned into."""
