"""What is to be seen of a motion, and from where."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.shapes import placed_shapes
from humanoid_rail.scene.targets import position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.line_of_sight import hidden_share
from humanoid_rail.viewer.sizes import bounds, corners, robot_points, scale

CAMERA = np.array([-1.45, -1.2, 0.5])
"""Where the camera is from the middle of what is to be seen, in units of its radius; mirrored where a wall is there."""
AROUND = np.array(
    [
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
        for azimuth in np.radians([-40.0, 40.0, -70.0, 70.0, -105.0, 105.0, -140.0, 140.0])
        for elevation in np.radians([30.0, 15.0])
    ]
)
"""Where the camera may be around a robot of meshes that faces x: that is taken which sees most, else the first."""
ZOOM = 1.9
"""The camera magnifies by this factor."""
HALF_HEIGHT = np.tan(np.radians(75.0 / 2)) / ZOOM
"""From the middle of the picture to its top, at distance 1: meshcat's camera sees 75 degrees without zoom."""
WIDE = 1.5
"""Pictures are taken to be wider than high by this factor."""
SHARE = 0.75
"""The share of the picture that is filled where that is computed."""
LOWERED = 0.07
"""It is lower than the middle by this share of the picture there, below the caption."""
NEARBY = 1.5
"""Obstacles count for the picture within this distance of robot and targets, m; it is scaled with the robot."""
SMALLEST = 1.0
"""At least a ball of this radius is to be seen, m; it is scaled with the robot."""


def viewpoint(robot: Robot, scene: Scene, trajectory: Trajectory) -> tuple[Array, Array]:
    """Return the middle (3,) of what is to be seen, and where the camera is from there (3,), m.

    To be seen are the robot during the whole motion, the targets and those parts of the obstacles that are near them.
    """
    kinematics, nearby = Kinematics(robot), NEARBY * scale(robot)
    times = np.linspace(0.0, trajectory.duration, 12)
    robots = np.vstack([kinematics.stick_figure(trajectory.configuration(t)) for t in times])
    targets = [position(target) for step in scene.steps for target in step.values() if target is not None]
    points = np.vstack([robots, trajectory.hands.reshape(-1, 3), targets])
    low, high = points.min(axis=0), points.max(axis=0)
    boxes = [bounds(piece) for obstacle in scene.obstacles for piece in placed_shapes(obstacle)]
    near = np.clip(np.vstack([points, *boxes]), low - nearby, high + nearby)
    low, high = near.min(axis=0), near.max(axis=0)
    middle, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, SMALLEST * scale(robot))
    walls = [(np.array(o.normal), o.offset) for o in scene.obstacles if isinstance(o, HalfSpace)]
    if robot.meshes:  # these are more than their stick figure
        bodies = [robot_points(robot, (), trajectory.configuration(t)) for t in times[::3]]
        seen = np.vstack([*bodies, *targets, *(corners(np.clip(box, low, high)) for box in boxes if len(box))])
        middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
        ahead = 1.0 if np.mean(targets, axis=0)[0] > np.vstack(bodies)[:, 0].mean() else -1.0
        cameras = [fitted(direction * [ahead, 1.0, 1.0], seen - middle) for direction in AROUND]
        end = trajectory.configuration(trajectory.duration)
        obstacles = np.vstack([np.zeros((0, 2, 3)), *(box[None] for box in boxes if len(box))])
        cameras = sorted(cameras, key=lambda camera: hidden_share(robot, end, obstacles, middle + camera))
    else:
        cameras = [radius * CAMERA * [x, y, 1.0] for x in (1, -1) for y in (1, -1)]
    clear = [camera for camera in cameras if all(n @ (middle + camera) > d for n, d in walls)]
    camera = (clear or cameras)[0]
    return (middle + lowering(camera) if robot.meshes else middle), camera


def fitted(direction: Array, points: Array) -> Array:
    """Return where the camera is (3,), in a direction (3,), that sees all points (k, 3) around the origin, m."""
    back, right, up = _axes(direction)
    beside = np.maximum(abs(points @ up), abs(points @ right) / WIDE) / (SHARE * HALF_HEIGHT)
    return back * float(np.max(points @ back + beside))


def lowering(camera: Array) -> Array:
    """Return how far to aim above (3,) what a camera (3,) looks at, to have it below the caption, m."""
    lowered: Array = 2.0 * LOWERED * HALF_HEIGHT * np.linalg.norm(camera) * _axes(camera)[2]
    return lowered


def _axes(direction: Array) -> tuple[Array, Array, Array]:
    """Return the axes (3,) of a camera in a direction (3,) from what it looks at: back, right and up."""
    back = direction / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return back, right, np.cross(back, right)
