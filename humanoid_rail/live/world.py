"""What is in the browser: the robot, its targets and the obstacles, as frozen data."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, Sphere
from humanoid_rail.scene.scene import Scene, check_scene, field_of_step, start_of_scene
from humanoid_rail.scene.standing import with_objects_standing
from humanoid_rail.scene.targets import AnyOf, Pose, Straight, Target, direction, orientation, pointing_direction


@dataclass(frozen=True, eq=False)
class World:
    """A robot in a scene, and where it stands."""

    robot: Robot
    scene: Scene
    q: Array
    """Where the robot stands (n,), m and rad."""

    @staticmethod
    def of(robot: Robot, scene: Scene) -> World:
        """Return a scene with the robot at its start. What moves in it begins at rest, and objects are obstacles.

        Raises:
            InvalidInput: If the scene is not one for this robot.
        """
        check_scene(robot, scene)
        scene = with_objects_standing(scene)
        for number, step in enumerate(scene.steps):
            for hand, target in step.items():
                if isinstance(target, AnyOf):
                    valid = "one target for each hand: live has no alternatives"
                    raise InvalidInput(f"{field_of_step(scene, number)}.{hand}", target, valid)
        still = tuple(o.model_copy(update={"velocity": (0.0, 0.0, 0.0)}) for o in scene.obstacles)
        start = np.clip(start_of_scene(robot, scene), robot.lower, robot.upper)
        return World(robot, scene.model_copy(update={"obstacles": still, "initial": None}), start)

    def with_target(self, step: int, hand: str, target: Target) -> World:
        """Return the world with another target."""
        steps = list(self.scene.steps)
        steps[step] = steps[step].with_targets({**steps[step], hand: target})
        targets = tuple(steps) if isinstance(self.scene.targets, tuple) else steps[0]
        return replace(self, scene=self.scene.model_copy(update={"targets": targets}))

    def with_obstacle(self, number: int, obstacle: Obstacle) -> World:
        """Return the world with an obstacle elsewhere."""
        obstacles = list(self.scene.obstacles)
        obstacles[number] = obstacle
        return replace(self, scene=self.scene.model_copy(update={"obstacles": tuple(obstacles)}))

    def with_robot(self, robot: Robot) -> World:
        """Return the world with the same robot of other sizes; it stands where the other did, within its limits."""
        return replace(self, robot=robot, q=np.clip(self.q, robot.lower, robot.upper))

    def at(self, q: Array) -> World:
        """Return the world with the robot at a configuration (n,), m and rad."""
        return replace(self, q=q)


def placed(obstacle: Obstacle, position: Array, rotation: Array) -> Obstacle:
    """Return an obstacle with its centre at a position (3,), m, turned by a matrix (3, 3)."""
    if isinstance(obstacle, HalfSpace):
        return obstacle
    new: dict[str, object] = {"center": tuple(map(float, position))}
    if not isinstance(obstacle, Sphere):
        new["rpy"] = tuple(map(float, pin.rpy.matrixToRpy(rotation)))
    return obstacle.model_copy(update=new)


def turned_target(target: Target, position: Array, rotation: Array) -> Target:
    """Return a target at a position (3,), m, turned by a matrix (3, 3) if it says how a hand is turned."""
    point = (float(position[0]), float(position[1]), float(position[2]))
    if not isinstance(target, Pose):
        return point
    if orientation(target) is not None:
        x, y, z, w = pin.Quaternion(rotation).normalized().coeffs().tolist()
        return target.model_copy(update={"position": point, "rpy": None, "quaternion": (w, x, y, z)})
    if pointing_direction(target) is not None:
        towards = tuple(map(float, rotation[:, 0]))
        straight = target.approach if isinstance(target.approach, Straight) else None
        approach = straight.model_copy(update={"direction": towards}) if straight else towards
        return target.model_copy(update={"position": point, "approach": approach})
    return target.model_copy(update={"position": point})


def target_rotation(target: Target) -> Array:
    """Return how a target is turned (3, 3): for a direction the x axis points along it."""
    if isinstance(target, Pose) and (turn := orientation(target)) is not None:
        return turn
    towards = None if target is None else direction(target, None)
    if towards is None:
        return np.eye(3)
    along: Array = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), towards).matrix()
    return along


def nearer(a: pin.SE3, b: pin.SE3, radius: float, farthest: float) -> pin.SE3:
    """Return a placement on the way from one to another at which no point within a radius, m, got farther than this.

    Args:
        a: Where it is.
        b: Where it goes to.
        radius: How far points of it are from its origin, m.
        farthest: How far they may get, m.
    """
    turn = pin.log3(a.rotation.T @ b.rotation)
    whole = float(np.linalg.norm(b.translation - a.translation) + radius * np.linalg.norm(turn))
    share = 1.0 if whole <= farthest else farthest / whole
    there = a.translation + share * (b.translation - a.translation)
    return pin.SE3(a.rotation @ pin.exp3(share * turn), there)
