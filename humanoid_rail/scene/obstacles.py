"""The obstacles of a scene as frozen, validated data. Metres and radians, in the base frame."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Annotated, Literal, Self, get_args

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from humanoid_rail._arrays import SHORTEST, frozen
from humanoid_rail._validation import Angles, Number, Positive, Size, Vector, plain
from humanoid_rail.geometry.convex_decomposition import Pieces, convex_pieces
from humanoid_rail.scene.covers import Cover, HeightField, PointCloud
from humanoid_rail.scene.obstacle import File, ObstacleBase


def _factors(value: object) -> object:
    value = plain(value)
    is_number = isinstance(value, float | int) and not isinstance(value, bool)
    if is_number or (isinstance(value, tuple) and len(value) == 3):
        return value
    raise ValueError("a number greater than 0, or three of them")


def not_zero(normal: tuple[float, float, float]) -> tuple[float, float, float]:
    """Check that a vector has a direction."""
    if sqrt(sum(x * x for x in normal)) < SHORTEST:
        raise ValueError("a vector longer than 1e-6")
    return normal


class Sphere(ObstacleBase):
    """A ball."""

    type: Literal["sphere"] = "sphere"
    center: Vector
    """Its centre, m."""
    radius: Positive
    """Its radius, m."""


class Box(ObstacleBase):
    """A solid box."""

    type: Literal["box"] = "box"
    center: Vector
    """Its centre, m."""
    size: Size
    """Full edge lengths in m, before rotation."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""


class Capsule(ObstacleBase):
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


class Cylinder(ObstacleBase):
    """A solid cylinder with flat ends, along the local z axis."""

    type: Literal["cylinder"] = "cylinder"
    center: Vector
    """Its centre, m."""
    radius: Positive
    """Its radius, m."""
    length: Positive
    """Distance between its ends, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""


class HalfSpace(ObstacleBase):
    """Everything on one side of a plane: solid where normal . x <= offset. A floor, a wall, the rail."""

    type: Literal["halfspace"] = "halfspace"
    normal: Annotated[Vector, AfterValidator(not_zero)]
    """Points out of the solid; of any length but 0."""
    offset: Number
    """How far the plane is from the origin along the normal; in m if that has length 1."""


class Mesh(ObstacleBase):
    """The solids inside closed triangle meshes, as the convex pieces they are made of. Cavities are solid."""

    type: Literal["mesh"] = "mesh"
    file: File
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


Obstacle = Annotated[
    Sphere | Box | Capsule | Cylinder | HalfSpace | Mesh | HeightField | PointCloud, Field(discriminator="type")
]
"""What a scene may have in the way of a robot."""
KINDS: tuple[type[Obstacle], ...] = get_args(get_args(Obstacle)[0])
"""The classes of obstacles."""


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
    """Return what messages call an obstacle of a scene: no two of a scene are called the same."""
    obstacle = obstacles[i]
    if obstacle.called is not None:
        return obstacle.called
    return f"obstacles[{i}] ({obstacle.type if obstacle.name is None else obstacle.name})"


def covers_of(obstacles: Sequence[Obstacle]) -> tuple[Cover, ...]:
    """Return what stands for those obstacles that were measured: point clouds and height fields."""
    return tuple(
        obstacle.cover(name_of(obstacles, i))
        for i, obstacle in enumerate(obstacles)
        if isinstance(obstacle, HeightField | PointCloud)
    )
