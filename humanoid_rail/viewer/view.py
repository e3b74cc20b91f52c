"""What a meshcat view shows of a motion.

Shown are robot and obstacles as they move, the targets, the traces of the hands coloured by clearance, and lines
between the nearest points of the closest bodies.
"""

from __future__ import annotations

from collections.abc import Sequence

import meshcat
import meshcat.transformations as mt
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.scene.targets import direction, position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.animation import animate
from humanoid_rail.viewer.camera import NEARBY, ZOOM, viewpoint
from humanoid_rail.viewer.closest_pairs import ClosestPairs, trace_clearance
from humanoid_rail.viewer.colours import clearance_colours, hand_colour, rgb
from humanoid_rail.viewer.connection import draw_connection
from humanoid_rail.viewer.drawing import draw_bodies, draw_obstacles, draw_target, draw_trace
from humanoid_rail.viewer.sizes import bounds, robot_points, scale
from humanoid_rail.viewer.visual_meshes import Visual, draw_visuals, robot_visuals

BELOW = 0.01
"""The grid is drawn this far below the lowest point of robot and obstacles, m."""

DIM = {"AmbientLight": 0.5, "FillLight": 0.3, "PointLightNegativeX": 0.2, "PointLightPositiveX": 0.2}
"""Lights of meshcat where they are weaker, and how strong they are."""


def fill_view(
    view: meshcat.Visualizer, robot: Robot, scene: Scene, trajectory: Trajectory, pairs: ClosestPairs
) -> None:
    """Send robot, scene, traces, closest pairs, camera and animation to a meshcat server.

    Args:
        view: What draws in the server.
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
        pairs: The closest pairs at each of its frames.
    """
    visuals, size = robot_visuals(robot), scale(robot)
    middle, camera = viewpoint(robot, scene, trajectory)
    set_up(view, middle, camera, _floor(robot, scene, visuals))
    world = view["world"]
    world.set_transform(mt.translation_matrix(-middle))
    if robot.meshes:
        dim(view)
    draw_visuals(world["robot"], visuals)
    draw_bodies(world["capsules"], robot, robot.collision_model)
    world["capsules"].set_property("visible", False)
    draw_obstacles(world["obstacles"], scene.obstacles)
    _draw_targets(world["targets"], robot, scene, size)
    _draw_traces(world["traces"], trajectory, trace_clearance(trajectory, pairs), size)
    shown = [kind for kind, closest in pairs._asdict().items() if closest]
    for kind in shown:
        # Some links are never far from each other; obstacles matter more.
        draw_connection(world[f"closest/{kind}"], kind == shown[0], size)
    world.set_animation(animate(world, robot, scene, trajectory, pairs), play=True, repetitions=10_000)


def set_up(view: meshcat.Visualizer, middle: Array, camera: Array, floor: float) -> None:
    """Set background, grid and camera.

    Args:
        view: What draws in the server.
        middle: The middle (3,) of what is to be seen, m.
        camera: Where the camera is from there (3,), m.
        floor: Height of the grid, m.
    """
    view["/Background"].set_property("top_color", [0.93, 0.95, 0.97])
    view["/Background"].set_property("bottom_color", [0.78, 0.82, 0.86])
    view["/Axes"].set_property("visible", False)
    # meshcat's camera turns about the origin and cannot be told otherwise, so the world moves instead.
    view["/Grid"].set_transform(mt.translation_matrix([0, 0, floor - middle[2]]))
    x, y, z = camera
    # The camera hangs in a node whose y axis points up.
    view["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])
    view["/Cameras/default/rotated/<object>"].set_property("zoom", ZOOM)


def dim(view: meshcat.Visualizer) -> None:
    """Make the light weaker: robots of meshes are often white, and meshcat's light shows nothing of their form."""
    for light, intensity in DIM.items():
        view[f"/Lights/{light}/<object>"].set_property("intensity", intensity)


def _draw_targets(view: meshcat.Visualizer, robot: Robot, scene: Scene, size: float) -> None:
    for number, step in enumerate(scene.steps):
        for i, hand in enumerate(robot.hands):
            if (target := step[hand.name]) is not None:
                pointing = direction(target, hand.pointing)
                at = np.array(position(target))
                draw_target(view[f"{number}/{hand.name}"], at, pointing, hand_colour(i), size)


def _draw_traces(view: meshcat.Visualizer, trajectory: Trajectory, clearance: Array | None, size: float) -> None:
    """Draw the traces of the hands, by clearance at the samples (N,), m, or in the colours of the hands without."""
    for i, name in enumerate(trajectory.hand_names):
        plain = np.tile(rgb(hand_colour(i)), (len(trajectory.t), 1))
        colours = plain if clearance is None else clearance_colours(clearance)
        draw_trace(view[name], trajectory.hands[:, i], colours, size)


def _floor(robot: Robot, scene: Scene, visuals: Sequence[Visual]) -> float:
    """Return the height of the grid: below the robot where it starts, and below obstacles that are near it, m."""
    low = float(robot_points(robot, visuals, robot.initial)[:, 2].min())
    boxes = [bounds(piece) for obstacle in scene.obstacles for piece in placed_shapes(obstacle)]
    under = [float(box[0, 2]) for box in boxes if len(box) and low - NEARBY * scale(robot) < box[0, 2]]
    return min([low, *under]) - BELOW
