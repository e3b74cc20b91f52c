"""What holds at all times along a move: straight paths of hands, and the grasp of two hands on one object."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from humanoid_rail._arrays import Array, triple
from humanoid_rail.kinematics.kept_tasks import AxisTask, LineTask, OrientationTask
from humanoid_rail.kinematics.task import RelativeTask, Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.holding import Holding, hand_placement
from humanoid_rail.planning.moves import Move
from humanoid_rail.scene.targets import Pose, is_oriented, orientation, position


def move_constraints(robot: Robot, move: Move, holding: Holding, q: Array) -> tuple[Task, ...]:
    """Return what holds along a move that begins at a configuration (n,).

    Args:
        robot: The robot, with all its hands.
        move: The move.
        holding: What is held along it.
        q: Where it begins, m and rad.
    """
    straight = (task for name in move.straight for task in _straight(robot, move, holding, name, q))
    closed = (task for held in holding.held.values() if len(held.hands) > 1 for task in _closed(robot, held.hands, q))
    return (*straight, *closed)


def _straight(robot: Robot, move: Move, holding: Holding, name: str, q: Array) -> Iterator[Task]:
    """Yield what keeps a hand or a held object on a line, turned as its target asks; along a line as it is."""
    held = holding.held.get(name)
    hand, offset = (name, np.zeros(3)) if held is None else (held.hands[0], held.placement.translation)
    target, there = move.targets[name], hand_placement(robot, hand, q)
    assert target is not None
    begin = there.act(offset)
    yield LineTask(hand, triple(begin), triple(np.array(position(target)) - begin), triple(offset))
    if name in move.turned or (isinstance(target, Pose) and orientation(target) is not None):
        yield _as_it_is(hand, there.rotation)
    elif is_oriented(target):
        pointing = robot.hands[robot.hand(hand)].pointing
        assert pointing is not None  # a target that a hand cannot point at was refused
        along = there.rotation @ (np.array(pointing) / np.linalg.norm(pointing))
        yield AxisTask(hand, pointing, triple(along))


def _closed(robot: Robot, hands: tuple[str, ...], q: Array) -> Iterator[Task]:
    """Yield what keeps hands as they are to the first of them."""
    first = hand_placement(robot, hands[0], q)
    for hand in hands[1:]:
        relative = first.inverse() * hand_placement(robot, hand, q)
        yield RelativeTask(hands[0], hand, triple(relative.translation), in_first=True)
        yield _as_it_is(hand, relative.rotation, hands[0])


def _as_it_is(hand: str, rotation: Array, reference: str | None = None) -> OrientationTask:
    first, second, third = (triple(row) for row in rotation)
    return OrientationTask(hand, (first, second, third), reference)
