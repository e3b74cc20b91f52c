"""What is to be seen of a motion, and from where."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace
from humanoid_rail.scene.scene import Scene, start_of_scene
from humanoid_rail.scene.targets import alternatives, position
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.line_of_sight import hidden_hands
from humanoid_rail.viewer.occlusion import blockers, hidden
from humanoid_rail.viewer.sizes import robot_points, scale

CAMERA = np.array([-1.45, -1.2, 0.5])
"""The direction from what is to be seen to the camera, where nothing speaks for another one."""
ZOOM = 1.9
"""The camera magnifies by this factor."""
HALF_HEIGHT = np.tan(np.radians(75.0 / 2)) / ZOOM
"""From the middle of the picture to its top, at distance 1: meshcat's camera sees 75 degrees without zoom."""
WIDE = 1.5
"""Pictures are taken to be wider than high by this factor."""
SHARE = 0.8
"""The share of the picture that is filled."""
MOMENTS = 8
"""The robot is looked at at so many moments of the motion."""
MOST_POINTS = 250
"""So many points of the robot are looked for at most, at all moments together."""
AZIMUTHS = np.radians(np.arange(0.0, 360.0, 30.0))
"""The camera turns about the vertical by these angles from where `CAMERA` is, rad."""
ELEVATIONS = np.radians([12.0, 22.0, 40.0])
"""The angles from the horizon to the camera, rad."""
AWAY = 0.006
"""The share of hidden points that is worth a camera from which everything looks twice as large."""
HANDS = 0.1
"""The share of hidden points that is worth a camera from which a robot of meshes does not hide its hands."""
TURN, STEEP = 0.002, 0.004
"""The share of hidden points that is worth a camera which is turned by one step less, or is at the middle elevation."""


class View(NamedTuple):
    """What is to be seen of a motion, and from where."""

    middle: Array
    """The middle (3,) of it, m."""
    camera: Array
    """Where the camera is from there (3,), m, in a picture that is wider than high by `WIDE`, or as was asked for."""
    points: Array
    """Points (P, 3) around it, which are all to be in the picture, m."""


def viewpoint(robot: Robot, scene: Scene, trajectory: Trajectory) -> tuple[Array, Array]:
    """Return the middle (3,) of what is to be seen, and where the camera is from there (3,), m."""
    view = best_view(robot, scene, trajectory)
    return view.middle, view.camera


def best_view(robot: Robot, scene: Scene, *trajectories: Trajectory, wide: float = WIDE) -> View:
    """Return from where obstacles hide the least of a robot during its motion, with the whole motion in the picture.

    Cameras in some directions are compared, by rays to points of the robot at some moments of the motion and to the
    targets. Among those that see about as much it is one that is near, and not far from the direction of `CAMERA`. No
    camera is behind a half-space.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectories: The motion, or several of the same robot; without any the robot is looked at where it starts.
        wide: Pictures are taken to be wider than high by this factor.
    """
    stated = [one for step in scene.steps for target in step.values() for one in alternatives(target)]
    targets = [np.array(position(target)) for target in stated if target is not None]
    seen, points, times, kinematics = [*targets], [*targets], [0.0] * len(targets), Kinematics(robot)
    moments = [moment for trajectory in trajectories for moment in _moments(trajectory)]
    for t, q in moments or [(0.0, start_of_scene(robot, scene))]:
        around = robot_points(robot, (), q)
        seen.append(around)
        looked = np.vstack([around.reshape(-1, 8, 3).mean(axis=1), kinematics.stick_figure(q)])
        points.append(looked)
        times += [t] * len(looked)
    box = np.vstack(seen)
    middle = (box.min(axis=0) + box.max(axis=0)) / 2
    size = scale(robot)
    box = np.vstack([box, middle + size / 2 * np.vstack([np.eye(3), -np.eye(3)])])
    looked_at, when = np.vstack(points), np.array(times)
    stride = -(-len(looked_at) // MOST_POINTS)
    looked_at, when = looked_at[::stride], when[::stride]
    directions = _directions(robot, targets, middle)
    cameras = {tuple(fitted(direction, box - middle, wide)): cost for direction, cost in directions}
    walls = [(np.array(o.normal), o.offset) for o in scene.obstacles if isinstance(o, HalfSpace)]
    clear = [camera for camera in cameras if all(n @ (middle + camera) > d for n, d in walls)] or [*cameras]
    if robot.meshes:
        shown = trajectories[0] if trajectories else None
        end = start_of_scene(robot, scene) if shown is None else shown.configuration(shown.duration)
        for camera, share in zip(cameras, hidden_hands(robot, end, middle + np.array([*cameras])), strict=True):
            cameras[camera] += HANDS * float(share)
    nearest, bodies = min(np.linalg.norm(camera) for camera in clear), blockers(scene.obstacles)

    def cost(camera: tuple[float, ...]) -> float:
        share = float(hidden(bodies, middle + camera, looked_at, when).mean())
        return share + AWAY * float(np.log2(np.linalg.norm(camera) / nearest)) + cameras[camera]

    return View(middle, np.array(min(clear, key=cost)), box)


def fitted(direction: Array, points: Array, wide: float = WIDE) -> Array:
    """Return where the camera is (3,), in a direction (3,), that sees all points (k, 3) around the origin, m."""
    back = direction / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    beside = np.maximum(abs(points @ up), abs(points @ right) / wide) / (SHARE * HALF_HEIGHT)
    return back * float(np.max(points @ back + beside))


def _moments(trajectory: Trajectory) -> list[tuple[float, Array]]:
    """Return times in s and configurations (n,) at which the robot is looked at, that of the nearest miss too."""
    moments = [(float(t), trajectory.configuration(t)) for t in np.linspace(0.0, trajectory.duration, MOMENTS)]
    if trajectory.diagnosis is not None:
        moments.append((trajectory.duration, np.array(trajectory.diagnosis.q)))
    return moments


def _directions(robot: Robot, targets: list[Array], middle: Array) -> Iterator[tuple[Array, float]]:
    """Yield the directions (3,) to the cameras that are compared, and what a camera costs that is not the best one."""
    first = np.arctan2(CAMERA[1], CAMERA[0])
    is_ahead = bool(targets) and float(np.mean(targets, axis=0)[0]) > middle[0]
    if is_ahead == bool(robot.meshes):
        # Thin robots are seen from behind, with what they reach for; others hide that, and are seen from in front.
        first = np.pi - first
    for i, elevation in enumerate(ELEVATIONS):
        for k, angle in enumerate(AZIMUTHS + first):
            level = np.cos(elevation)
            cost = TURN * min(k, len(AZIMUTHS) - k) + STEEP * (i != 1)
            yield np.array([level * np.cos(angle), level * np.sin(angle), np.sin(elevation)]), cost
