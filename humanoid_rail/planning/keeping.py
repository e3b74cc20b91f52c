"""Turns what a step keeps into constraints, as things are at the beginning of its segment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import SHORTEST, Array, triple
from humanoid_rail.kinematics.hand_motion import unit
from humanoid_rail.kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import PointTask, RelativeTask, Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.keep import Keep, Relative, Upright


def constraints_of(robot: Robot, keep: Sequence[Keep], start: Array) -> tuple[Task, ...]:
    """Return what holds along a motion from a start.

    Args:
        robot: The robot, with the hands that are named.
        keep: What is kept.
        start: Where the motion starts (n,), m and rad.
    """
    if not keep:
        return ()
    state = Kinematics(robot).state(start)
    return tuple(task for one in keep for task in _tasks(state, one))


def straight_to(robot: Robot, hand: str, place: Array, start: Array) -> tuple[Task, ...]:
    """Return what holds while a hand moves straight to a place (3,), turned as it is: a line, and its orientation.

    Args:
        robot: The robot.
        hand: Name of the hand.
        place: In the base frame, m. Where the hand is there already, it stays.
        start: Where the motion starts (n,), m and rad.
    """
    state = Kinematics(robot).state(start)
    here = state.hands[robot.hand(hand)]
    along = np.asarray(place, float) - here
    is_there = np.linalg.norm(along) < SHORTEST
    line = PointTask(hand, triple(here)) if is_there else LineTask(hand, triple(here), triple(along))
    return line, _orientation(state, hand)


def _tasks(state: State, keep: Keep) -> tuple[Task, ...]:
    """Return the constraints of one thing that is kept."""
    robot = state.robot
    match keep:
        case Keep(upright=Upright() as upright):
            turned, direction = state.rotations[robot.hand(upright.hand)], unit(upright.direction)
            axis = turned.T @ direction if upright.axis is None else unit(upright.axis)
            return (AxisTask(upright.hand, triple(axis), triple(direction)),)
        case Keep(orientation=str(hand)):
            return (_orientation(state, hand),)
        case Keep(point=str(hand)):
            return (PointTask(hand, triple(state.hands[robot.hand(hand)])),)
        case Keep(distance=(first, second)):
            apart = state.hands[robot.hand(second)] - state.hands[robot.hand(first)]
            return (DistanceTask(first, second, float(np.linalg.norm(apart))),)
        case Keep(relative=Relative() as relative):
            return _relative(state, relative)
    assert keep.line is not None
    here = state.hands[robot.hand(keep.line.hand)]
    return (LineTask(keep.line.hand, triple(here), triple(unit(keep.line.direction))),)


def _orientation(state: State, hand: str, reference: str | None = None) -> OrientationTask:
    turned = state.rotations[state.robot.hand(hand)]
    if reference is not None:
        turned = state.rotations[state.robot.hand(reference)].T @ turned
    first, second, third = map(triple, turned)
    return OrientationTask(hand, (first, second, third), reference)


def _relative(state: State, relative: Relative) -> tuple[Task, ...]:
    first, second = relative.hands
    apart = state.hands[state.robot.hand(second)] - state.hands[state.robot.hand(first)]
    if relative.what == "difference":
        return (RelativeTask(first, second, triple(apart)),)
    there = state.rotations[state.robot.hand(first)].T @ apart
    place = RelativeTask(first, second, triple(there), in_first=True)
    return (place,) if relative.what == "place" else (place, _orientation(state, second, first))
