"""What a meshcat view shows of a motion.

Shown are robot and obstacles as they move, the targets, the traces of the hands coloured by clearance, and lines
between the nearest points of the closest bodies.
"""

from __future__ import annotations

import meshcat
import meshcat.transformations as mt
import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.targets import direction, position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.animation import animate
from humanoid_rail.viewer.camera import ZOOM, viewpoint
from humanoid_rail.viewer.closest_pairs import ClosestPairs, trace_clearance
from humanoid_rail.viewer.colours import clearance_colours, hand_colour, rgb
from humanoid_rail.viewer.connection import draw_connection
from humanoid_rail.viewer.drawing import draw_bodies, draw_obstacles, draw_target, draw_trace
from humanoid_rail.viewer.visual_meshes import draw_visuals

FLOOR = -0.33
"""The grid is drawn at this height, under the rail, m."""


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
    middle, camera = viewpoint(robot, scene, trajectory)
    _set_up(view, middle, camera)
    world = view["world"]
    world.set_transform(mt.translation_matrix(-middle))
    draw_visuals(world["robot"], robot)
    draw_bodies(world["capsules"], robot, robot.collision_model)
    world["capsules"].set_property("visible", False)
    draw_obstacles(world["obstacles"], scene.obstacles)
    _draw_targets(world["targets"], robot, scene)
    _draw_traces(world["traces"], trajectory, trace_clearance(trajectory, pairs))
    shown = [kind for kind, closest in pairs._asdict().items() if closest]
    for kind in shown:
        # Some links are never far from each other; obstacles matter more.
        draw_connection(world[f"closest/{kind}"], emphasised=kind == shown[0])
    world.set_animation(animate(world, robot, scene, trajectory, pairs), play=True, repetitions=10_000)


def _set_up(view: meshcat.Visualizer, middle: Array, camera: Array) -> None:
    """Set background, grid and camera; see :func:`humanoid_rail.viewer.camera.viewpoint`."""
    view["/Background"].set_property("top_color", [0.93, 0.95, 0.97])
    view["/Background"].set_property("bottom_color", [0.78, 0.82, 0.86])
    view["/Axes"].set_property("visible", False)
    # meshcat's camera turns about the origin and cannot be told otherwise, so the world moves instead.
    view["/Grid"].set_transform(mt.translation_matrix([0, 0, FLOOR - middle[2]]))
    x, y, z = camera
    # The camera hangs in a node whose y axis points up.
    view["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])
    view["/Cameras/default/rotated/<object>"].set_property("zoom", ZOOM)


def _draw_targets(view: meshcat.Visualizer, robot: Robot, scene: Scene) -> None:
    for number, step in enumerate(scene.steps):
        for i, hand in enumerate(robot.hands):
            if (target := step[hand.name]) is not None:
                pointing = direction(target, hand.pointing)
                draw_target(view[f"{number}/{hand.name}"], np.array(position(target)), pointing, hand_colour(i))


def _draw_traces(view: meshcat.Visualizer, trajectory: Trajectory, clearance: Array | None) -> None:
    """Draw the traces of the hands, by clearance at the samples (N,), m, or in the colours of the hands without."""
    for i, name in enumerate(trajectory.hand_names):
        plain = np.tile(rgb(hand_colour(i)), (len(trajectory.t), 1))
        draw_trace(view[name], trajectory.hands[:, i], plain if clearance is None else clearance_colours(clearance))
