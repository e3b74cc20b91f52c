"""The obstacles of a scene as frozen, validated data. Metres and radians, in the base frame."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from humanoid_rail._arrays import SHORTEST, frozen
from humanoid_rail._validation import Angles, Frozen, Number, Positive, Size, Vector, plain
from humanoid_rail.geometry.convex_decomposition import Pieces, convex_pieces


def _factors(value: object) -> object:
    value = plain(value)
    is_number = isinstance(value, float | int) and not isinstance(value, bool)
    if is_number or (isinstance(value, tuple) and len(value) == 3):
        return value
    raise ValueError("a number greater than 0, or three of them")


def _require_type(schema: dict[str, Any]) -> None:
    """A file names the type of every obstacle, although Python code need not."""
    schema["required"] = ["type", *schema.get("required", [])]


def not_zero(normal: tuple[float, float, float]) -> tuple[float, float, float]:
    """Check that a vector has a direction."""
    if sqrt(sum(x * x for x in normal)) < SHORTEST:
        raise ValueError("a vector longer than 1e-6")
    return normal


class _Obstacle(Frozen):
    model_config = ConfigDict(json_schema_extra=_require_type)

    velocity: Vector = (0.0, 0.0, 0.0)
    """How fast it moves without turning, from where it is at t = 0, m/s."""


class Sphere(_Obstacle):
    """A ball."""

    type: Literal["sphere"] = "sphere"
    center: Vector
    """Its centre, m."""
    radius: Positive
    """Its radius, m."""


class Box(_Obstacle):
    """A solid box."""

    type: Literal["box"] = "box"
    center: Vector
    """Its centre, m."""
    size: Size
    """Full edge lengths in m, before rotation."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""


class Capsule(_Obstacle):
    """All points within `radius` of a segment along the local z axis."""

    type: Literal["capsule"] = "capsule"
    center: Vector
    """Middle of the segment, m."""
    radius: Positive
    """Its radius, m."""
    length: Positive
    """Distance between the centres of the two end spheres, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""


class HalfSpace(_Obstacle):
    """Everything on one side of a plane: solid where normal . x <= offset. A floor, a wall, the rail."""

    type: Literal["halfspace"] = "halfspace"
    normal: Annotated[Vector, AfterValidator(not_zero)]
    """Points out of the solid; of any length but 0."""
    offset: Number
    """How far the plane is from the origin along the normal; in m if that has length 1."""


class Mesh(_Obstacle):
    """The solids inside closed triangle meshes, as the convex pieces they are made of. Cavities are solid."""

    type: Literal["mesh"] = "mesh"
    file: str
    """Any format that trimesh and assimp read; relative to the scene file (in Python to the working directory). Metres
    with z up, unless the format says otherwise: glTF has y up, COLLADA names its unit and axis."""
    center: Vector
    """Where the mesh's origin is, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""
    scale: Annotated[Positive | Size, BeforeValidator(_factors)] = 1.0
    """One factor, or one for each axis of the mesh once z is up: 0.001 if its numbers are millimetres."""

    # Plain numbers, so that scenes can be compared.
    _pieces: tuple[tuple[tuple[float, ...], ...], ...] = PrivateAttr(default=())

    @field_validator("file")
    @classmethod
    def _resolve(cls, file: str, info: ValidationInfo) -> str:
        folder = (info.context or {}).get("folder", Path.cwd())
        path = Path(folder) / file
        try:
            exists = path.is_file()
        except (OSError, ValueError):  # a name too long, a folder that may not be looked into, a NUL
            exists = False
        if not exists:
            raise ValueError(f"an existing mesh file, relative to {Path(folder).resolve()}")
        return str(path)

    @model_validator(mode="after")
    def _decompose(self) -> Self:
        scale = self.scale if isinstance(self.scale, tuple) else (self.scale, self.scale, self.scale)
        try:
            pieces = convex_pieces(self.file, scale)
        except ValueError as error:
            raise PydanticCustomError("mesh_file", "{valid}", {"valid": str(error), "file": self.file}) from error
        self._pieces = tuple(tuple(map(tuple, piece.tolist())) for piece in pieces)
        return self

    @property
    def pieces(self) -> Pieces:
        """Vertices (k, 3) of the convex pieces, scaled, in the mesh's own frame, m."""
        return tuple(frozen(piece) for piece in self._pieces)


Obstacle = Annotated[Sphere | Box | Capsule | HalfSpace | Mesh, Field(discriminator="type")]


def is_moving(obstacle: Obstacle) -> bool:
    """Return whether an obstacle moves."""
    return any(obstacle.velocity)


def at_rest(obstacles: Sequence[Obstacle]) -> bool:
    """Return whether no obstacle moves."""
    return not any(map(is_moving, obstacles))


def moved(obstacle: Obstacle, t: float) -> Obstacle:
    """Return where an obstacle is after a time in s, as one that is there at t = 0."""
    displacement = [t * speed for speed in obstacle.velocity]
    if not any(displacement):
        return obstacle
    if isinstance(obstacle, HalfSpace):
        return obstacle.model_copy(update={"offset": obstacle.offset + float(np.dot(obstacle.normal, displacement))})
    return obstacle.model_copy(update={"center": tuple(np.add(obstacle.center, displacement).tolist())})


def name_of(obstacles: Sequence[Obstacle], i: int) -> str:
    """Return what messages call an obstacle of a scene."""
    return f"obstacles[{i}] ({obstacles[i].type})"
