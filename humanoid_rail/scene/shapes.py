"""The obstacles of a scene as coal shapes."""

from __future__ import annotations

from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.convex_shape import convex_shape
from humanoid_rail.scene.covers import HeightField, PointCloud
from humanoid_rail.scene.obstacles import Box, Capsule, Cylinder, HalfSpace, Mesh, Obstacle, Sphere


class PlacedShape(NamedTuple):
    """A convex shape and where it is in the base frame."""

    shape: coal.CollisionGeometry
    placement: coal.Transform3s


def placed_shapes(obstacle: Obstacle) -> list[PlacedShape]:
    """Return the convex shapes that make up an obstacle: one, or the pieces that cover it."""
    match obstacle:
        case Sphere():
            return [PlacedShape(coal.Sphere(obstacle.radius), _placement(obstacle.center))]
        case Box():
            return [PlacedShape(coal.Box(*obstacle.size), _placement(obstacle.center, obstacle.rpy))]
        case Capsule():
            capsule = coal.Capsule(obstacle.radius, obstacle.length)
            return [PlacedShape(capsule, _placement(obstacle.center, obstacle.rpy))]
        case Cylinder():
            cylinder = coal.Cylinder(obstacle.radius, obstacle.length)
            return [PlacedShape(cylinder, _placement(obstacle.center, obstacle.rpy))]
        case HalfSpace():
            length = float(np.linalg.norm(obstacle.normal))
            half_space = coal.Halfspace(np.array(obstacle.normal) / length, obstacle.offset / length)
            return [PlacedShape(half_space, coal.Transform3s())]
        case Mesh() | HeightField():
            placement = _placement(obstacle.center, obstacle.rpy)
            return [PlacedShape(convex_shape(vertices), placement) for vertices in obstacle.pieces]
        case PointCloud():
            turn = pin.rpy.rpyToMatrix(*obstacle.rpy)
            centers = obstacle.centers @ turn.T + obstacle.center
            return [
                PlacedShape(coal.Sphere(radius), coal.Transform3s(turn, center))
                for center, radius in zip(centers, obstacle.radii.tolist(), strict=True)
            ]


def distance_between(one: PlacedShape, other: PlacedShape) -> float:
    """Return how far two convex shapes are from each other, m; negative inside."""
    return float(coal.distance(*one, *other, coal.DistanceRequest(), coal.DistanceResult()))


def support(placed: PlacedShape, direction: Array) -> float:
    """Return the largest coordinate of a convex shape along a direction (3,), m if the direction has length 1.

    Raises:
        TypeError: If the shape is none of those that a URDF or a scene can hold.
    """
    shape, placement = placed
    local: Array = placement.getRotation().T @ direction
    middle = float(direction @ placement.getTranslation())
    along, across, length = abs(float(local[2])), float(np.hypot(*local[:2])), float(np.linalg.norm(direction))
    match shape:
        case coal.Sphere():
            reach = shape.radius * length
        case coal.Capsule():
            reach = shape.halfLength * along + shape.radius * length
        case coal.Box():
            reach = abs(local) @ shape.halfSide
        case coal.Cylinder():
            reach = shape.halfLength * along + shape.radius * across
        case coal.Halfspace():  # along its own normal; in no other direction does it end
            reach = shape.d
        case coal.ConvexBase():
            reach = (np.array(shape.points()) @ local).max()
        case _:
            raise TypeError(f"no support function of a {type(shape).__name__}")
    return middle + float(reach)


def _placement(
    center: tuple[float, float, float], rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> coal.Transform3s:
    return coal.Transform3s(pin.rpy.rpyToMatrix(*rpy), np.array(center))


def _settle_boxes() -> None:
    """Have coal decide how boxes are measured now, and not by whatever a process happens to measure first.

    Its support function of a box keeps, in a static variable, whether the first direction it was ever asked about had a
    coordinate that is 0 (coal 3.0.3, `support_functions.cpp`); all distances from boxes depend on that, by 1e-10 of
    their size. Here the first direction has none.
    """
    tilted = coal.Transform3s(pin.rpy.rpyToMatrix(0.4, 0.5, 0.6), np.array([2.0, 3.0, 4.0]))
    for shape in (coal.Capsule(0.1, 1.0), coal.Box(1.0, 1.0, 1.0)):
        box, here = coal.Box(1.0, 1.0, 1.0), coal.Transform3s()
        for a, at_a, b, at_b in ((shape, tilted, box, here), (box, here, shape, tilted)):
            coal.distance(a, at_a, b, at_b, coal.DistanceRequest(), coal.DistanceResult())


_settle_boxes()
