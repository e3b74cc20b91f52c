"""Warns of scenes that look as if they were in millimetres: what is far off is ignored by a planner without a word."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.covers import HeightField, PointCloud
from humanoid_rail.scene.obstacles import HalfSpace, Mesh, Obstacle, name_of
from humanoid_rail.scene.scene import Scene, field_of_step
from humanoid_rail.scene.targets import alternatives, position

FAR = 10.0
"""What is farther from the base than this many times what any hand reaches has nothing to do with the robot."""
MILLIMETRE = 1e-3
"""m."""


def warn_of_units(robot: Robot, scene: Scene) -> None:
    """Warn of targets and obstacles that are far beyond what the robot reaches, and within it in millimetres.

    It is a warning, as there may be things far away.
    """
    reach = robot.farthest_hand
    if found := [*_far_targets(scene, reach), *_far_obstacles(scene.obstacles, reach)]:
        names = ", ".join(found[:3]) + (f" and {len(found) - 3} more" if len(found) > 3 else "")
        far = f"more than {FAR * reach:.3g} m from the base of a robot that reaches {reach:.3g} m"
        warnings.warn(f"{names}: {far}; scenes are in metres, these look like millimetres", stacklevel=3)


def _far_targets(scene: Scene, reach: float) -> Iterator[str]:
    for number, step in enumerate(scene.steps):
        for hand, target in step.items():
            points = [position(one) for one in alternatives(target) if one is not None]
            if any(_is_in_millimetres(float(np.linalg.norm(point)), reach) for point in points):
                yield f"{field_of_step(scene, number)}.{hand}"


def _far_obstacles(obstacles: tuple[Obstacle, ...], reach: float) -> Iterator[str]:
    for i, obstacle in enumerate(obstacles):
        match obstacle:
            case HalfSpace():
                far = abs(obstacle.offset) / float(np.linalg.norm(obstacle.normal))
            case Mesh() | HeightField():
                size = max(float(np.ptp(piece, axis=0).max()) for piece in obstacle.pieces)
                far = max(float(np.linalg.norm(obstacle.center)), size)
            case PointCloud():
                turned = obstacle.centers @ pin.rpy.rpyToMatrix(*obstacle.rpy).T + obstacle.center
                far = float(np.linalg.norm(turned, axis=1).min())
            case _:
                far = float(np.linalg.norm(obstacle.center))
        if _is_in_millimetres(far, reach):
            yield name_of(obstacles, i)


def _is_in_millimetres(distance: float, reach: float) -> bool:
    return distance > FAR * reach and MILLIMETRE * distance <= reach
