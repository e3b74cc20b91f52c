"""Obstacles that were measured: point clouds and height fields, which simpler solids stand for that contain them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from humanoid_rail._arrays import Array, frozen
from humanoid_rail._validation import Angles, Number, Positive, Vector
from humanoid_rail.geometry.height_pieces import height_pieces
from humanoid_rail.geometry.mesh_files import stamps
from humanoid_rail.geometry.point_files import read_heights, read_points
from humanoid_rail.geometry.sphere_cover import sphere_cover
from humanoid_rail.scene.obstacle import File, ObstacleBase

MOST_PIECES = 10_000
"""An obstacle is made of so many spheres or convex pieces at most."""
THICKNESS = 0.1
"""A height field without a base is this thick below its lowest height, m."""
THINNEST = 1e-4
"""The base of a height field is at least this much below its lowest height, m."""
Rows = tuple[tuple[float, ...], ...]
"""Numbers in rows, which unlike arrays can be compared."""


@dataclass(frozen=True)
class Cover:
    """What stands for an obstacle that was measured. The proof is about this, which contains the obstacle."""

    obstacle: str
    """Such as ``obstacles[3] (pointcloud)``."""
    pieces: str
    """What it is made of: `spheres` or `convex pieces`."""
    count: int
    """How many of them there are."""
    solid: str
    """What they contain."""
    swelling: float
    """They reach no farther beyond it than this, m."""

    def __str__(self) -> str:
        reach = f"and reach at most {self.swelling:.3g} m beyond" if self.swelling else "and nothing else"
        return f"{self.obstacle}: {self.count} {self.pieces} contain {self.solid}, {reach}"


class PointCloud(ObstacleBase):
    """The balls of one radius around the points of a file. What is between and behind them is free."""

    type: Literal["pointcloud"] = "pointcloud"
    file: File
    """NPZ with the array `points` (n, 3), or PLY, whose vertices are the points; relative to the scene file (in Python
    to the working directory). Metres with z up."""
    radius: Positive
    """The radius of the ball around each point, m; at least half of how far neighbours on a surface are apart, or there
    are holes between them."""
    center: Vector = (0.0, 0.0, 0.0)
    """Where the origin of the points is, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""
    voxel: Positive | None = None
    """If given, all points in the same cube of this edge, m, share one sphere that contains their balls. It reaches
    beyond them by less than the diagonal of the cube."""
    scale: Positive = 1.0
    """A factor for the numbers of the file: 0.001 if they are millimetres."""

    _spheres: Rows = PrivateAttr(default=())
    _swelling: float = PrivateAttr(default=0.0)

    @model_validator(mode="after")
    def _cover(self) -> Self:
        try:
            self._spheres, self._swelling = _spheres(self.file, self.scale, self.radius, self.voxel, stamps(self.file))
        except ValueError as error:
            raise PydanticCustomError("mesh_file", "{valid}", {"valid": str(error), "file": self.file}) from error
        return self

    @property
    def centers(self) -> Array:
        """The centres (k, 3) of the spheres, in the obstacle's own frame, m."""
        return frozen([row[:3] for row in self._spheres])

    @property
    def radii(self) -> Array:
        """The radii (k,) of the spheres, m."""
        return frozen([row[3] for row in self._spheres])

    def cover(self, called: str) -> Cover:
        """Return what stands for the obstacle, which messages call so."""
        solid = f"the balls of {self.radius:g} m around the points of the file"
        return Cover(called, "spheres", len(self._spheres), solid, self._swelling)


class HeightField(ObstacleBase):
    """The solid between a base and a surface: heights over a grid of x and y, with two triangles in each cell."""

    type: Literal["heightfield"] = "heightfield"
    file: File
    """NPZ with the arrays `heights` (ny, nx), in m, and `spacing`, which is how far columns and rows are apart: one
    number, or two for x and y. `origin` (2,) is where `heights[0, 0]` is; (0, 0) if it is not there. Relative to the
    scene file (in Python to the working directory)."""
    center: Vector = (0.0, 0.0, 0.0)
    """Where the origin of the grid is, m."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Rotation about the fixed axes x, y, z in this order, as in URDF, rad."""
    base: Number | None = None
    """The height down to which it is solid, in its own frame, m; 0.1 m below the lowest one if not given."""
    tolerance: Annotated[float, Field(ge=0.0, le=1.0)] = 0.001
    """Cells whose heights are within this of a plane, m, are one piece, which reaches beyond the surface by no more."""
    scale: Positive = 1.0
    """A factor for the numbers of the file: 0.001 if they are millimetres."""

    _pieces: tuple[Rows, ...] = PrivateAttr(default=())
    _swelling: float = PrivateAttr(default=0.0)

    @model_validator(mode="after")
    def _cover(self) -> Self:
        try:
            self._pieces, self._swelling = _prisms(self.file, self.scale, self.base, self.tolerance, stamps(self.file))
        except ValueError as error:
            raise PydanticCustomError("mesh_file", "{valid}", {"valid": str(error), "file": self.file}) from error
        return self

    @property
    def pieces(self) -> tuple[Array, ...]:
        """Corners (8, 3) of the convex pieces, in the obstacle's own frame, m."""
        return tuple(frozen(piece) for piece in self._pieces)

    def cover(self, called: str) -> Cover:
        """Return what stands for the obstacle, which messages call so."""
        return Cover(called, "convex pieces", len(self._pieces), "all below the surface of the file", self._swelling)


@lru_cache(maxsize=64)
def _spheres(file: str, scale: float, radius: float, voxel: float | None, _stamps: object) -> tuple[Rows, float]:
    points = read_points(file, scale)
    centers, radii, swelling = sphere_cover(points, radius, voxel)
    if len(centers) > MOST_PIECES:
        given = "a voxel" if voxel is None else "a larger voxel"
        enough = _voxel_for(points, radius, voxel or radius)
        valid = f"at most {MOST_PIECES} spheres, not {len(centers)}: give it {given}, such as voxel: {enough:.2g}"
        raise ValueError(valid)
    return tuple((*map(float, c), float(r)) for c, r in zip(centers, radii, strict=True)), swelling


def _voxel_for(points: Array, radius: float, voxel: float) -> float:
    """Return the edge of voxels, m, that leave few enough spheres."""
    while len(sphere_cover(points, radius, voxel).centers) > MOST_PIECES:
        voxel *= 1.5
    return voxel


@lru_cache(maxsize=64)
def _prisms(
    file: str, scale: float, base: float | None, tolerance: float, _stamps: object
) -> tuple[tuple[Rows, ...], float]:
    grid = read_heights(file, scale)
    lowest = float(grid.heights.min())
    bottom = lowest - THICKNESS if base is None else base
    if bottom > lowest - THINNEST:
        raise ValueError(f"a base at least {THINNEST:g} m below the lowest height, {lowest:.6g} m; it is {bottom:.6g}")
    pieces, swelling = height_pieces(grid, bottom, tolerance)
    if len(pieces) > MOST_PIECES:
        valid = f"at most {MOST_PIECES} convex pieces, not {len(pieces)}: give it a larger tolerance than {tolerance:g}"
        raise ValueError(f"{valid} m, or heights on a coarser grid")
    return tuple(tuple(map(tuple, piece.tolist())) for piece in pieces), swelling
