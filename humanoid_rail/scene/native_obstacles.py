"""Obstacles as the native engine has them."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, assert_never

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.errors import InvalidInput
from humanoid_rail.scene.covers import HeightField, PointCloud
from humanoid_rail.scene.obstacles import KINDS, Box, Capsule, Cylinder, HalfSpace, Mesh, Obstacle, Sphere

if TYPE_CHECKING:
    from humanoid_rail import _engine


class _Identical:
    """Obstacles that are the same if they are the same object: they are frozen, and many numbers to compare."""

    def __init__(self, obstacles: tuple[Obstacle, ...]) -> None:
        self.obstacles = obstacles

    def __hash__(self) -> int:
        return id(self.obstacles)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Identical) and self.obstacles is other.obstacles


def native_obstacles(obstacles: tuple[Obstacle, ...]) -> _engine.Obstacles:
    """Return obstacles as the native engine has them; the same object for those that were asked for lately.

    Raises:
        InvalidInput: If one of them is no obstacle.
        EngineMissing: If there is no native engine.
    """
    # Another tuple of what is no tuple: that may change.
    return _made(_Identical(tuple(obstacles)))


@lru_cache(maxsize=8)
def _made(given: _Identical) -> _engine.Obstacles:
    result: _engine.Obstacles = engine().Obstacles()
    for obstacle in given.obstacles:
        if not isinstance(obstacle, KINDS):
            *names, last = (kind.__name__ for kind in KINDS)
            raise InvalidInput("obstacles", obstacle, f"a {', '.join(names)} or {last}")
        velocity = np.array(obstacle.velocity)
        match obstacle:
            case Sphere():
                result.sphere(np.array(obstacle.center), obstacle.radius, velocity)
            case Box():
                result.box(*_placement(obstacle), np.array(obstacle.size), velocity)
            case Capsule():
                result.capsule(*_placement(obstacle), obstacle.radius, obstacle.length, velocity)
            case Cylinder():
                result.cylinder(*_placement(obstacle), obstacle.radius, obstacle.length, velocity)
            case HalfSpace():
                length = float(np.linalg.norm(obstacle.normal))
                result.halfspace(np.array(obstacle.normal) / length, obstacle.offset / length, velocity)
            case Mesh() | HeightField():
                result.convex(*_placement(obstacle), list(obstacle.pieces), velocity)
            case PointCloud():
                result.spheres(*_placement(obstacle), obstacle.centers, obstacle.radii, velocity)
            case _:
                assert_never(obstacle)
    return result


def _placement(obstacle: Box | Capsule | Cylinder | Mesh | HeightField | PointCloud) -> tuple[Array, Array]:
    return np.array(obstacle.center), pin.rpy.rpyToMatrix(*obstacle.rpy)
