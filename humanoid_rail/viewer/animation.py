"""The animation of a motion: robot, obstacles that move, and the lines between the closest bodies."""

from __future__ import annotations

import meshcat
import numpy as np
import pinocchio as pin
from meshcat.animation import Animation

from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.closest_pairs import ClosestPairs
from humanoid_rail.viewer.connection import move_connection
from humanoid_rail.viewer.drawing import moving_together
from humanoid_rail.viewer.frames import FRAMES_PER_SECOND, frame_times


def animate(
    view: meshcat.Visualizer, robot: Robot, scene: Scene, trajectory: Trajectory, pairs: ClosestPairs
) -> Animation:
    """Return the animation of what :mod:`humanoid_rail.viewer.view` draws.

    Args:
        view: The node in which it is drawn.
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
        pairs: The closest pairs at each of its frames.
    """
    animation = Animation(default_framerate=FRAMES_PER_SECOND)
    data = robot.model.createData()
    times = frame_times(trajectory)
    for frame, t in enumerate(times):
        pin.forwardKinematics(robot.model, data, robot.full_configuration(trajectory.configuration(t)))
        with animation.at_frame(view, frame) as at:
            for joint in range(1, robot.model.njoints):
                for tree in ("robot", "capsules"):
                    at[f"{tree}/{robot.model.names[joint]}"].set_transform(data.oMi[joint].homogeneous)
            for kind, closest in pairs._asdict().items():
                if closest:
                    move_connection(at[f"closest/{kind}"], closest[frame].points)
    moving = [(i, np.array(velocity)) for i, velocity in enumerate(moving_together(scene.obstacles)) if any(velocity)]
    end = int(np.argmax(times))
    # Obstacles move evenly, so a few frames are enough: meshcat interpolates in between.
    for frame in sorted({0, max(end - 1, 0), end, len(times) - 1}):
        with animation.at_frame(view, frame) as at:
            for i, velocity in moving:
                at[f"obstacles/{i}"].set_property("position", "vector3", (times[frame] * velocity).tolist())
    return animation
