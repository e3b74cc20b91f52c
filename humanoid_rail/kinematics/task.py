"""What the hands have to do next: the steps of a scene as points that have to reach points.

How a hand is turned is where its points are: one behind its own gives the direction it points in, and two, on different
axes, its orientation. So whatever moves points turns hands too, and their errors are all in metres.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array, FrozenArrays, frozen
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.scene.scene import Scene
from humanoid_rail.scene.targets import Pose, Step, direction, is_oriented, position

LEVER = 0.3
"""How far from a hand's own point the others are, m: at 1e-7 m an orientation is precise to 3e-7 rad."""


@dataclass(frozen=True, eq=False)
class Task(FrozenArrays):
    """Points of the robot, and where they have to be."""

    robot: Robot
    """With the hands alone that have targets, h of them."""
    targets: Array
    """x_f (h, 3), m."""
    posed: Robot
    """With further points on the hands that have to be turned, p in all; the same robot if none has. For inverse
    kinematics: its Jacobian has dependent rows, and its manipulability means nothing."""
    points: Array
    """Where these have to be (p, 3), m."""
    owners: tuple[int, ...]
    """Which of the h hands each of them is on (p,)."""

    @property
    def is_oriented(self) -> bool:
        """Whether a hand has to be turned in some way."""
        return self.posed is not self.robot


def tasks_of(robot: Robot, scene: Scene) -> Iterator[Task]:
    """Yield the task of each step of a scene that was checked."""
    robots = {robot.hand_names: robot}
    for step in scene.steps:
        names = tuple(name for name in robot.hand_names if step[name] is not None)
        if names not in robots:
            robots[names] = replace(robot, hands=tuple(hand for hand in robot.hands if hand.name in names))
        yield _task(robots[names], step)


def rows_of(robot: Robot, task: Task) -> list[int]:
    """Return which of the coordinates of all hands (3h) are those of the task's."""
    return [3 * robot.hand_names.index(name) + axis for name in task.robot.hand_names for axis in range(3)]


def _task(robot: Robot, step: Step) -> Task:
    targets = frozen([position(target) for name in robot.hand_names if (target := step[name]) is not None])
    if not any(is_oriented(step[name]) for name in robot.hand_names):
        return Task(robot, targets, robot, targets, tuple(range(len(targets))))
    model, hands, points, owners = pin.Model(robot.model), list(robot.hands), list(targets), list(range(len(targets)))
    for owner, hand in enumerate(robot.hands):
        target = step[hand.name]
        if isinstance(target, Pose):
            for number, (offset, point) in enumerate(_further_points(hand, target)):
                name = f"{hand.frame} point {number}"
                model.addFrame(_shifted(model.frames[model.getFrameId(hand.frame)], name, offset))
                hands.append(Hand(f"{hand.name} point {number}", name, hand.arm))
                points.append(point)
                owners.append(owner)
    return Task(robot, targets, replace(robot, model=model, hands=tuple(hands)), frozen(points), tuple(owners))


def _further_points(hand: Hand, pose: Pose) -> Iterator[tuple[Array, Array]]:
    """Yield offsets in a hand's frame (3,), and where the points there have to be (3,), m."""
    place, pointing = np.array(pose.position), np.array(hand.pointing) / np.linalg.norm(hand.pointing)
    towards = direction(pose, hand.pointing)
    if towards is not None:
        yield -LEVER * pointing, place - LEVER * towards
    if pose.rpy is not None:
        across = np.cross(pointing, np.eye(3)[abs(pointing).argmin()])
        across /= np.linalg.norm(across)
        yield -LEVER * across, place - LEVER * pin.rpy.rpyToMatrix(*pose.rpy) @ across


def _shifted(frame: pin.Frame, name: str, offset: Array) -> pin.Frame:
    placement = frame.placement * pin.SE3(np.eye(3), offset)
    return pin.Frame(name, frame.parentJoint, frame.parentFrame, placement, pin.FrameType.OP_FRAME)
