"""What holds at all times along a move: straight paths of hands, and the grasp of two hands on one object."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from humanoid_rail._arrays import Array, triple
from humanoid_rail.holding.holding import Holding
from humanoid_rail.kinematics.hand_motion import unit
from humanoid_rail.kinematics.kept_tasks import AxisTask
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.keeping import NO_OFFSET, line_to, orientation_kept, place_kept
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
    together = [held.hands for held in holding.held.values() if len(held.hands) > 1]
    if not move.straight and not together:
        return ()
    state = Kinematics(robot).state(q)
    straight = (task for name in move.straight for task in _straight(state, move, holding, name))
    return (*straight, *(task for hands in together for task in _closed(state, hands)))


def _straight(state: State, move: Move, holding: Holding, name: str) -> Iterator[Task]:
    """Yield what keeps a hand or a held object on a line, turned as its target asks; along a line as it is."""
    held, target, robot = holding.held.get(name), move.targets[name], state.robot
    hand, offset = (name, NO_OFFSET) if held is None else (held.hands[0], held.placement.translation)
    assert target is not None
    yield line_to(state, hand, np.array(position(target)), offset)
    if name in move.turned or (isinstance(target, Pose) and orientation(target) is not None):
        yield orientation_kept(state, hand)
    elif is_oriented(target):
        pointing = robot.hands[robot.hand(hand)].pointing
        assert pointing is not None  # a target that a hand cannot point at was refused
        yield AxisTask(hand, pointing, triple(state.rotations[robot.hand(hand)] @ unit(pointing)))


def _closed(state: State, hands: tuple[str, ...]) -> Iterator[Task]:
    """Yield what keeps hands as they are to the first of them."""
    first, *others = hands
    for hand in others:
        yield place_kept(state, first, hand)
        yield orientation_kept(state, hand, first)
