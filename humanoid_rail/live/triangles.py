"""Bodies as triangles, for a browser."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.scene.covers import PointCloud
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.viewer.forms import WALL
from humanoid_rail.viewer.painted import Painted

MANY_CORNERS, FEW_CORNERS = 2, 0
"""How often the triangles of an icosahedron are divided to show a ball, ..."""
FEW = 200
"""... as one of up to so many, and as one of more."""


class Triangles(NamedTuple):
    """A mesh."""

    vertices: Array
    """(n, 3), m."""
    faces: NDArray[np.int64]
    """(m, 3)."""


def triangles(shape: coal.CollisionGeometry | Sequence[Painted]) -> Triangles:
    """Return the surface of a shape in its own frame.

    Raises:
        TypeError: If the shape is none of those that a URDF or a scene can hold.
    """
    # Imported here: it takes long.
    import trimesh

    match shape:
        case coal.Sphere():
            vertices, faces = _ball(MANY_CORNERS)
            return Triangles(shape.radius * vertices, faces)
        case coal.Box():
            mesh = trimesh.creation.box(2.0 * shape.halfSide)
        case coal.Capsule():
            mesh = trimesh.creation.capsule(height=2.0 * shape.halfLength, radius=shape.radius, count=(16, 16))
            mesh.apply_translation(-mesh.bounds.mean(axis=0))
        case coal.Cylinder():
            mesh = trimesh.creation.cylinder(radius=shape.radius, height=2.0 * shape.halfLength, sections=24)
        case coal.ConvexBase():
            mesh = trimesh.convex.convex_hull(np.array(shape.points()))
        case coal.Halfspace():
            mesh = trimesh.creation.box(WALL)
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(shape.n)).matrix()
            mesh.apply_transform(pin.SE3(turn, (shape.d - WALL[2] / 2.0) * np.array(shape.n)).homogeneous)
        case Sequence():
            parts = [trimesh.Trimesh(part.vertices, part.faces, process=False) for part in shape]
            mesh = trimesh.util.concatenate(parts)
        case _:
            raise TypeError(f"no picture of a {type(shape).__name__}")
    return Triangles(np.array(mesh.vertices), np.array(mesh.faces))


def obstacle_triangles(obstacle: Obstacle) -> Triangles:
    """Return the surface of an obstacle around its own centre; of a half-space where it is."""
    if isinstance(obstacle, PointCloud):
        # Their radii differ, and in the obstacle's own frame each is elsewhere; all others have one frame.
        ball = _ball(MANY_CORNERS if len(obstacle.radii) <= FEW else FEW_CORNERS)
        parts = [
            Triangles(center + radius * ball.vertices, ball.faces)
            for center, radius in zip(obstacle.centers, obstacle.radii, strict=True)
        ]
    else:
        parts = [triangles(placed.shape) for placed in placed_shapes(obstacle)]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    return Triangles(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def _ball(subdivisions: int) -> Triangles:
    """Return a ball of radius 1 as triangles, four times as many with each subdivision of the 20 of an icosahedron."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    return Triangles(np.array(mesh.vertices), np.array(mesh.faces))


def radius(obstacle: Obstacle) -> float:
    """Return how far a point of an obstacle is at most from its centre, m."""
    if isinstance(obstacle, HalfSpace):
        return float(np.inf)
    if isinstance(obstacle, PointCloud):
        return float((np.linalg.norm(obstacle.centers, axis=1) + obstacle.radii).max())
    return float(np.linalg.norm(obstacle_triangles(obstacle).vertices, axis=1).max())
