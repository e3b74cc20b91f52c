"""Whether a motion can start where it is to, and if not what is to be changed: start, robot or obstacle."""

from __future__ import annotations

import warnings

import coal
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.unmoved_pairs import unmoved_pairs
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.state import KinematicsModel
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, name_of
from humanoid_rail.scene.scene import Scene
from humanoid_rail.search.reachability import MILLIMETRES

DEEP = 0.01
"""A body that stands on something is no deeper in it than this, m."""


def check_start(field: str, kinematics: KinematicsModel, scene: Scene, start: Array, least: float) -> None:
    """Check that a start is clear of obstacles, and of other links if any clearance is asked for.

    Args:
        field: What errors call the start.
        kinematics: The robot among the obstacles.
        scene: The scene they are of.
        start: The configuration (n,), m and rad.
        least: The clearance that it must have, m.

    Raises:
        InvalidInput: If it is not. The links' radius is to blame where links touch even at the robot's own start.
    """
    robot = kinematics.robot
    there = kinematics.measure(start, horizon=0.0)
    rounded = [round(float(x), 6) for x in start]
    if there.clearance.size and there.clearance.min() < least:
        _check_radius(kinematics)
        nearest = float(there.clearance.min())
        link, number = np.unravel_index(there.clearance.argmin(), there.clearance.shape)
        near = f"{robot.link_names[link]} is {_where(nearest)} {name_of(scene.obstacles, int(number))}"
        near += _hint(scene.obstacles[int(number)], nearest)
        raise InvalidInput(field, rounded, f"a start clear of obstacles: {near}")
    if least > 0 and there.self_clearance.size and there.self_clearance.min() < least:
        _check_radius(kinematics)
        one, other = robot.self_collision_pairs[int(there.self_clearance.argmin())]
        near = f"{robot.link_names[one]} is {_where(there.self_clearance.min())} {robot.link_names[other]}"
        raise InvalidInput(field, rounded, f"a start in which no links touch: {near}")


def warn_of_depth(robot: Robot, scene: Scene) -> None:
    """Warn of obstacles in which a body of the robot is from the start and stays, as no joint moves it."""
    for pair, distance in unmoved_pairs(robot, scene.obstacles, -DEEP):
        warnings.warn(f"{pair.link} is {-distance:.3g} m inside {pair.other}, and neither moves", stacklevel=3)


def _check_radius(kinematics: KinematicsModel) -> None:
    """Check that links which are capsules of one radius do not touch at the robot's own start.

    Raises:
        InvalidInput: If they do, and would not if they were thinner.
    """
    robot = kinematics.robot
    shapes = [body.geometry for body in robot.collision_model.geometryObjects]
    radii = {shape.radius if isinstance(shape, coal.Capsule) else None for shape in shapes}
    apart = kinematics.measure(robot.initial, horizon=0.0).self_clearance
    radius = radii.pop() if len(radii) == 1 else None
    if radius is None or not apart.size or apart.min() >= 0.0:
        return
    most = radius + float(apart.min()) / 2.0
    if most > 0.0:
        one, other = (robot.link_names[link] for link in robot.self_collision_pairs[int(apart.argmin())])
        why = f"at the robot's own start {one} is {_where(apart.min())} {other}"
        raise InvalidInput("link_radius", radius, f"less than {most:.4g} m: {why}")


def _hint(obstacle: Obstacle, clearance: float) -> str:
    """Return what may be wrong with an obstacle in which a link is."""
    if clearance < -MILLIMETRES:
        return "; given in millimetres?"
    if isinstance(obstacle, HalfSpace):
        offset = obstacle.offset + clearance * float(np.linalg.norm(obstacle.normal))
        return (
            f"; links have a thickness (link_radius), so the offset of this floor or wall has to be below {offset:.4g}"
        )
    return ""


def _where(clearance: float) -> str:
    return f"{-clearance:.4g} m inside" if clearance < 0 else f"{clearance:.4g} m, too near to tell from touching, from"
