"""What is drawn of a motion, and stays as it is; the page's script moves it.

These are robot and obstacles, the targets, the traces of the hands coloured by clearance, and lines between the nearest
points of the closest bodies.
"""

from __future__ import annotations

from collections.abc import Sequence

import meshcat
import meshcat.transformations as mt
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.scene.targets import alternatives, direction, position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.camera import ZOOM
from humanoid_rail.viewer.closest_pairs import ClosestPairs, trace_clearance
from humanoid_rail.viewer.colours import clearance_colours, hand_colour, rgb
from humanoid_rail.viewer.connection import draw_connection
from humanoid_rail.viewer.drawing import draw_bodies, draw_obstacles, draw_target, draw_trace, is_floor, node_name
from humanoid_rail.viewer.sizes import bounds, robot_points, scale
from humanoid_rail.viewer.visual_meshes import Visual, draw_visuals

BELOW = 0.01
"""The floor is drawn this far below the lowest point of robot and obstacles, m."""
NEARBY = 1.5
"""Obstacles may be below the robot by as much, to stand on the floor; it is scaled with the robot, m."""
DIM = {"AmbientLight": 0.5, "FillLight": 0.3, "PointLightNegativeX": 0.2, "PointLightPositiveX": 0.2}
"""Lights of meshcat where they are weaker, and how strong they are."""
BODIES = (0.3, 0.55, 0.84, 0.4)
"""Collision bodies have this colour, red, green, blue and opacity from 0 to 1: what is in them can be seen."""
SECOND = (0.55, 0.33, 0.66, 0.35)
"""The robot of a second motion in the same picture has this colour, red, green, blue and opacity from 0 to 1."""


def draw_scene(view: meshcat.Visualizer, robot: Robot, scene: Scene) -> None:
    """Draw the obstacles and the targets of a scene."""
    draw_obstacles(view["obstacles"], scene.obstacles)
    for number, step in enumerate(scene.steps):
        for i, hand in enumerate(robot.hands):
            stated = [one for one in alternatives(step.get(hand.name)) if one is not None]
            for k, target in enumerate(stated):
                pointing, at = direction(target, hand.pointing), np.array(position(target))
                name = node_name(hand.name) if k == 0 else f"{node_name(hand.name)}-{k + 1}"
                draw_target(view[f"targets/{number}"][name], at, pointing, hand_colour(i), scale(robot))


def draw_motion(
    view: meshcat.Visualizer,
    robot: Robot,
    visuals: Sequence[Visual],
    trajectory: Trajectory,
    pairs: ClosestPairs,
    *,
    is_second: bool = False,
) -> None:
    """Draw a robot, its collision bodies, the traces of its hands and what connects closest bodies.

    Args:
        view: The node in which it is drawn.
        robot: The robot.
        visuals: Its visual bodies.
        trajectory: The motion.
        pairs: The closest pairs along it.
        is_second: Whether another motion of the robot is in the picture: then this one is in a colour of its own.
    """
    size = scale(robot)
    if is_second:  # what does not move is there already
        visuals = [visual._replace(rgba=SECOND) for visual in visuals if visual.joint != robot.model.names[0]]
    draw_visuals(view["robot"], visuals)
    bodies = robot.collision_model.copy()
    for body in bodies.geometryObjects:
        body.meshColor = np.array(BODIES)
    draw_bodies(view["bodies"], robot, bodies)
    view["bodies"].set_property("visible", False)
    clearance = trace_clearance(trajectory, pairs)
    for i, name in enumerate(trajectory.hand_names):
        plain = np.tile(SECOND[:3] if is_second else rgb(hand_colour(i)), (len(trajectory.t), 1))
        colours = plain if clearance is None or is_second else clearance_colours(clearance)
        draw_trace(view["traces"][node_name(name)], trajectory.hands[:, i], colours, size)
    shown = [kind for kind, closest in pairs._asdict().items() if closest]
    for kind in shown:
        # Some links are never far from each other; obstacles matter more.
        draw_connection(view[f"closest/{kind}"], kind == shown[0], size)


def set_up(view: meshcat.Visualizer, middle: Array, camera: Array, floor: float) -> None:
    """Set background, grid and camera of a page without a script of its own for these.

    Args:
        view: What draws.
        middle: The middle (3,) of what is to be seen, m.
        camera: Where the camera is from there (3,), m.
        floor: Height of the grid, m.
    """
    view["/Background"].set_property("top_color", [0.93, 0.95, 0.97])
    view["/Background"].set_property("bottom_color", [0.78, 0.82, 0.86])
    view["/Axes"].set_property("visible", False)
    # meshcat's camera turns about the origin, so the world moves instead.
    view["/Grid"].set_transform(mt.translation_matrix([0, 0, floor - middle[2]]))
    x, y, z = camera
    # The camera hangs in a node whose y axis points up.
    view["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])
    view["/Cameras/default/rotated/<object>"].set_property("zoom", ZOOM)


def dim(view: meshcat.Visualizer) -> None:
    """Make the light weaker: robots of meshes are often white, and meshcat's light shows nothing of their form."""
    for light, intensity in DIM.items():
        view[f"/Lights/{light}/<object>"].set_property("intensity", intensity)


def floor_height(robot: Robot, scene: Scene, visuals: Sequence[Visual]) -> float:
    """Return the height of the floor, m: of the half-space that is one, or below the robot and obstacles near it."""
    floors = [o.offset / o.normal[2] for o in scene.obstacles if isinstance(o, HalfSpace) and is_floor(o)]
    if floors:
        return max(floors)
    low = float(robot_points(robot, visuals, robot.initial)[:, 2].min())
    boxes = [bounds(piece) for obstacle in scene.obstacles for piece in placed_shapes(obstacle)]
    under = [float(box[0, 2]) for box in boxes if len(box) and low - NEARBY * scale(robot) < box[0, 2]]
    return min([low, *under]) - BELOW
