"""Draws bodies, targets and the traces of hands into a meshcat view."""

from __future__ import annotations

from collections.abc import Sequence
from urllib.parse import quote

import coal
import meshcat
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail._validation import Vector
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.colors import color_bytes
from humanoid_rail.scene.covers import HeightField, PointCloud
from humanoid_rail.scene.obstacles import Box, HalfSpace, Mesh, Obstacle, is_moving
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.viewer.colours import OBSTACLE_COLOURS, WALL_COLOUR, colour_of
from humanoid_rail.viewer.forms import Group, instances

DIRECTION_LENGTH = 0.45
"""The cone that shows in which direction a hand has to point is this long, m."""
TRACE_SPACING = 0.01
"""The points of a trace are this far apart, m."""


def node_name(name: str) -> str:
    """Return what the node of a joint, a body or a hand is called, where slashes lead from node to node."""
    return quote(name, safe="")


def draw_bodies(view: meshcat.Visualizer, robot: Robot, bodies: pin.GeometryModel) -> None:
    """Draw the bodies of a robot, each joint's under a node of its own, which the animation moves."""
    for body in bodies.geometryObjects:
        joint = node_name(robot.model.names[body.parentJoint])
        draw_body(view[joint][node_name(body.name)], body.geometry, body.placement, body.meshColor)


def draw_body(view: meshcat.Visualizer, shape: coal.CollisionGeometry, placement: pin.SE3, rgba: Array) -> None:
    """Draw a body of a robot where it is in the frame of the node, of a colour and opacity (4,) from 0 to 1."""
    placed = PlacedShape(shape, coal_placement(placement))
    view.set_object(Group({"body": instances([placed], colour_of(rgba), float(rgba[3]))}))


def draw_obstacles(view: meshcat.Visualizer, obstacles: Sequence[Obstacle]) -> None:
    """Draw obstacles as one object: a group for those that move alike, named as :func:`moving_together` does.

    Their number hardly matters: in a group those of the same form and colour are one object. A half-space below which
    everything is full is left out unless it has a colour of its own: the floor shows it.
    """
    colours, groups = obstacle_colours(obstacles), dict[str, list[mg.Object]]()
    for name, together in moving_together(obstacles).items():
        coloured: dict[tuple[int, bool], list[int]] = {}
        for i in together:
            if not is_plain_floor(obstacles[i]):
                coloured.setdefault((colours[i], isinstance(obstacles[i], HalfSpace)), []).append(i)
        groups[name] = []
        for (colour, is_wall), numbers in coloured.items():
            pieces = [(piece, i) for i in numbers for piece in placed_shapes(obstacles[i])]
            shapes, owners = [piece for piece, _ in pieces], [i for _, i in pieces]
            groups[name] += instances(shapes, colour, 0.2 if is_wall else 1.0, -1 if is_wall else 0, owners)
    view.set_object(Group(groups))


def is_floor(obstacle: Obstacle) -> bool:
    """Return whether an obstacle is a half-space at rest that has everything above it free."""
    if not isinstance(obstacle, HalfSpace) or is_moving(obstacle):
        return False
    x, y, z = obstacle.normal
    return z > 0 and x == y == 0


def is_plain_floor(obstacle: Obstacle) -> bool:
    """Return whether an obstacle is a floor without a colour of its own, which the floor of the picture shows."""
    return is_floor(obstacle) and obstacle.color is None


def obstacle_colours(obstacles: Sequence[Obstacle]) -> list[int]:
    """Return the colour of each obstacle: its own, or else the same for those of the same kind and size."""
    kinds: dict[tuple[object, ...], int] = {}
    colours = []
    for obstacle in obstacles:
        if obstacle.color is not None:
            colours.append(color_bytes(obstacle.color))
            continue
        kind: tuple[object, ...] = (obstacle.type,)
        if isinstance(obstacle, Box):
            kind = (*kind, *(round(size, 2) for size in sorted(obstacle.size)))
        elif isinstance(obstacle, Mesh | HeightField | PointCloud):
            kind = (*kind, obstacle.file)
        elif isinstance(obstacle, HalfSpace):
            colours.append(WALL_COLOUR)
            continue
        colours.append(OBSTACLE_COLOURS[kinds.setdefault(kind, len(kinds)) % len(OBSTACLE_COLOURS)])
    return colours


def moving_together(obstacles: Sequence[Obstacle]) -> dict[str, list[int]]:
    """Return the numbers of obstacles that have the same velocity, by a name for each velocity in their order."""
    grouped: dict[Vector, list[int]] = {}
    for i, obstacle in enumerate(obstacles):
        grouped.setdefault(obstacle.velocity, []).append(i)
    return {f"together{number}": together for number, together in enumerate(grouped.values())}


def draw_target(view: meshcat.Visualizer, at: Array, direction: Array | None, colour: int, scale: float = 1.0) -> None:
    """Draw a target (3,) and, if the hand has to point in a direction (3,), a cone that points so at the target.

    All is as much larger by `scale` than for the paper's robot.
    """
    view["point"].set_object(mg.Sphere(0.035 * scale), mg.MeshPhongMaterial(color=colour))
    view["halo"].set_object(mg.Sphere(0.09 * scale), mg.MeshPhongMaterial(color=colour, opacity=0.3, transparent=True))
    if direction is not None:
        length = DIRECTION_LENGTH * scale
        cone = mg.Cylinder(length, radiusTop=0.0, radiusBottom=0.04 * scale)
        view["direction"].set_object(cone, mg.MeshPhongMaterial(color=colour))
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), direction).matrix()
        view["direction"].set_transform(pin.SE3(turn, -length / 2 * direction).homogeneous)
    view.set_transform(mt.translation_matrix(at))


def draw_trace(view: meshcat.Visualizer, hand: Array, colours: Array, scale: float = 1.0) -> None:
    """Draw the path of a hand as evenly spaced points.

    Args:
        view: The node to draw into.
        hand: Positions of the hand at the samples (N, 3), m.
        colours: Red, green and blue at the samples (N, 3), from 0 to 1.
        scale: Points and their distance are as much larger than for the paper's robot.
    """
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(hand, axis=0), axis=1))])
    at = np.arange(0.0, length[-1] + 1e-9, TRACE_SPACING * scale)
    position = np.array([np.interp(at, length, column) for column in hand.T])
    colour = np.array([np.interp(at, length, column) for column in colours.T])
    view.set_object(mg.PointCloud(position.astype(np.float32), colour.astype(np.float32), size=0.05 * scale))
