"""The animation of a motion: robot, obstacles that move, and the lines between the closest bodies."""

from __future__ import annotations

from typing import Any

import meshcat
import numpy as np
import pinocchio as pin
from meshcat.animation import Animation, AnimationClip, AnimationTrack

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import is_moving
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
    if tracks := _moving(scene, times):
        animation.clips[view["obstacles"].path] = AnimationClip(tracks, FRAMES_PER_SECOND)
    return animation


class _Track(AnimationTrack):  # type: ignore[misc]  # meshcat has no types
    """A track of a part of an object, which meshcat's own cannot name: `PART.PROPERTY`."""

    def lower(self) -> dict[str, Any]:
        return {**super().lower(), "name": self.name}


def _moving(scene: Scene, times: Array) -> dict[str, _Track]:
    """Return the tracks of obstacles that move, which are drawn in groups of the same velocity.

    They move evenly, so a few frames are enough: meshcat interpolates in between.
    """
    end = int(np.argmax(times))
    frames = sorted({0, max(end - 1, 0), end, len(times) - 1})
    tracks = {}
    for name, together in moving_together(scene.obstacles).items():
        if is_moving(together[0]):
            positions = np.outer(times[frames], together[0].velocity).tolist()
            tracks[name] = _Track(f"{name}.position", "vector3", frames, positions)
    return tracks
