"""Draws bodies, targets and the traces of hands into a meshcat view."""

from __future__ import annotations

import coal
import meshcat
import meshcat.geometry as mg
import meshcat.transformations as mt
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.viewer.colours import OBSTACLE_COLOUR, WALL_COLOUR
from humanoid_rail.viewer.meshes import box_edges, capsule_mesh, hull_mesh

DIRECTION_LENGTH = 0.45
"""The cone that shows in which direction a hand has to point is this long, m."""
TRACE_SPACING = 0.01
"""The points of a trace are this far apart, m."""

# meshcat's cylinders lie along y, those of coal and URDF along z.
_Y_TO_Z = mt.rotation_matrix(np.pi / 2, [1, 0, 0])


def draw_shape(view: meshcat.Visualizer, placed: PlacedShape, colour: int, opacity: float) -> None:
    """Draw a coal shape where it is.

    Raises:
        TypeError: If the shape is none of those that a URDF or a scene can hold.
    """
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = placed.placement.getRotation(), placed.placement.getTranslation()
    material = mg.MeshPhongMaterial(color=colour, opacity=opacity, transparent=opacity < 1)
    shape = placed.shape
    match shape:
        case coal.Sphere():
            view.set_object(mg.Sphere(shape.radius), material)
        case coal.Box():
            view.set_object(mg.Box(2 * shape.halfSide), material)
        case coal.Cylinder():
            view.set_object(mg.Cylinder(2 * shape.halfLength, shape.radius), material)
            T = T @ _Y_TO_Z
        case coal.Capsule():
            view.set_object(capsule_mesh(shape), material)
        case coal.Halfspace():
            view.set_object(mg.Box([20.0, 20.0, 0.01]), material)
            T = _surface(shape)
        case coal.ConvexBase():
            view.set_object(hull_mesh(np.array(shape.points())), material)
        case _:
            raise TypeError(f"no picture of a {type(shape).__name__}")
    view.set_transform(T)


def _surface(shape: coal.Halfspace) -> Array:
    """Return the transform (4, 4) of a plate in the xy plane to the surface of a half-space."""
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(shape.n))
    T: Array = pin.SE3(turn, shape.d * np.array(shape.n)).homogeneous
    return T


def draw_bodies(view: meshcat.Visualizer, robot: Robot, bodies: pin.GeometryModel) -> None:
    """Draw the bodies of a robot, each joint's under a node of its own, which the animation moves."""
    for body in bodies.geometryObjects:
        joint = robot.model.names[body.parentJoint]
        rgb = (255 * np.clip(body.meshColor[:3], 0, 1)).astype(int)
        colour = int(rgb[0]) << 16 | int(rgb[1]) << 8 | int(rgb[2])
        placement = coal.Transform3s(body.placement.rotation, body.placement.translation)
        placed = PlacedShape(body.geometry, placement)
        draw_shape(view[f"{joint}/{body.name}"], placed, colour, float(body.meshColor[3]))


def draw_obstacle(view: meshcat.Visualizer, obstacle: Obstacle) -> None:
    """Draw an obstacle, each convex piece under a node of its own."""
    colour, opacity = (WALL_COLOUR, 0.2) if isinstance(obstacle, HalfSpace) else (OBSTACLE_COLOUR, 0.35)
    for i, piece in enumerate(placed_shapes(obstacle)):
        draw_shape(view[str(i)], piece, colour, opacity)
        if isinstance(piece.shape, coal.Box):
            edges = mg.PointsGeometry(box_edges(piece.shape).astype(np.float32))
            view[f"{i}/edges"].set_object(mg.LineSegments(edges, mg.LineBasicMaterial(OBSTACLE_COLOUR)))


def draw_target(view: meshcat.Visualizer, at: Array, direction: Array | None, colour: int) -> None:
    """Draw a target (3,) and, if the hand has to point in a direction (3,), a cone that points so at the target."""
    view["point"].set_object(mg.Sphere(0.035), mg.MeshPhongMaterial(color=colour))
    view["halo"].set_object(mg.Sphere(0.09), mg.MeshPhongMaterial(color=colour, opacity=0.3, transparent=True))
    if direction is not None:
        cone = mg.Cylinder(DIRECTION_LENGTH, radiusTop=0.0, radiusBottom=0.04)
        view["direction"].set_object(cone, mg.MeshPhongMaterial(color=colour))
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), direction).matrix()
        view["direction"].set_transform(pin.SE3(turn, -DIRECTION_LENGTH / 2 * direction).homogeneous)
    view.set_transform(mt.translation_matrix(at))


def draw_trace(view: meshcat.Visualizer, hand: Array, colours: Array) -> None:
    """Draw the path of a hand as evenly spaced points.

    Args:
        view: The node to draw into.
        hand: Positions of the hand at the samples (N, 3), m.
        colours: Red, green and blue at the samples (N, 3), from 0 to 1.
    """
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(hand, axis=0), axis=1))])
    at = np.arange(0.0, length[-1] + 1e-9, TRACE_SPACING)
    position = np.array([np.interp(at, length, column) for column in hand.T])
    colour = np.array([np.interp(at, length, column) for column in colours.T])
    view.set_object(mg.PointCloud(position.astype(np.float32), colour.astype(np.float32), size=0.05))
