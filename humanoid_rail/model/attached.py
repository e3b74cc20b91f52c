"""Objects as bodies of a robot: one that a hand holds moves with it, one that stands somewhere is fixed to the base.

So the engine measures, avoids and certifies an object as it does a link: against obstacles while it is held, against
the links, and against other objects.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail.model.far_parts import AWAY
from humanoid_rail.model.pairs import NO_JOINT, UncheckedPair
from humanoid_rail.model.robot import Robot

COLOUR = np.array([0.95, 0.75, 0.3, 1.0])
"""Objects have this colour: red, green, blue and opacity from 0 to 1."""
MAY_TOUCH = "they may touch there"
"""This is said of an object and what it may touch on the way to a grasp or away from it."""


@dataclass(frozen=True, eq=False)
class ObjectBody:
    """An object as a body of a robot."""

    name: str
    shapes: tuple[coal.CollisionGeometry, ...]
    """Its convex pieces."""
    placements: tuple[pin.SE3, ...]
    """Where each of them is in the frame of the joint."""
    joint: int = 0
    """The joint of the model that carries it; 0 for the base."""
    may_touch: frozenset[str] = frozenset()
    """Links and other objects, by name, that it is not checked against."""


def with_objects(robot: Robot, objects: Sequence[ObjectBody]) -> Robot:
    """Return the robot with objects as further links, after its own.

    Every link is checked against every object, and objects are checked against each other, but for those that do not
    move relative to each other and those that may touch. These are among its unchecked pairs.

    Args:
        robot: The robot.
        objects: The objects. Each is a link of its name, which no frame of the robot has.
    """
    if not objects:
        return robot
    model, bodies = robot.model.copy(), robot.collision_model.copy()
    for one in objects:
        frame = model.addFrame(pin.Frame(one.name, one.joint, 0, pin.SE3.Identity(), pin.FrameType.BODY))
        for k, (shape, placement) in enumerate(zip(one.shapes, one.placements, strict=True)):
            name = one.name if len(one.shapes) == 1 else f"{one.name}.{k}"
            made = pin.GeometryObject(name, one.joint, frame, placement, shape)
            made.meshColor = COLOUR
            bodies.addGeometryObject(made)
    found = replace(robot, model=model, collision_model=bodies)
    checked, left_out = _pairs(found, objects, robot.collision_model.ngeoms)
    found = replace(
        found,
        self_collision_pairs=(*robot.self_collision_pairs, *checked),
        left_out=(*robot.unchecked_pairs, *left_out),
        objects=(*robot.objects, *(one.name for one in objects)),
    )
    # The URDF has nothing of objects.
    vars(found)["links_without_body"] = robot.links_without_body
    return found


def _pairs(
    robot: Robot, objects: Sequence[ObjectBody], first: int
) -> tuple[list[tuple[int, int]], tuple[UncheckedPair, ...]]:
    """Return which bodies are checked against those of objects, from the first on, and which are not."""
    names, moves, geometry = robot.link_names, robot.moving_bodies, list(robot.collision_model.geometryObjects)
    allowed = {frozenset((one.name, other)) for one in objects for other in one.may_touch}
    checked, left_out = list[tuple[int, int]](), dict[tuple[str, str], str]()
    for i, j in _candidates(robot, first):
        if not (moves[i] or moves[j]):
            continue  # no motion changes how near they are
        if frozenset((names[i], names[j])) in allowed:
            left_out[names[i], names[j]] = MAY_TOUCH
        elif geometry[i].parentJoint == geometry[j].parentJoint:
            left_out.setdefault((names[i], names[j]), NO_JOINT)
        else:
            checked.append((i, j))
    return checked, tuple(UncheckedPair(*pair, why) for pair, why in left_out.items())


def _candidates(robot: Robot, first: int) -> Iterator[tuple[int, int]]:
    """Yield the pairs of bodies one of which is an object's, without parts of bodies that are there whole."""
    names, bodies = robot.link_names, robot.collision_model.geometryObjects
    for j in range(first, len(bodies)):
        for i in range(j):
            if names[i] != names[j] and AWAY not in bodies[i].name:
                yield i, j
