"""Turns what a step keeps into constraints, as things are at the beginning of its segment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import SHORTEST, Array, frozen, triple
from humanoid_rail.kinematics.hand_motion import unit
from humanoid_rail.kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import PointTask, RelativeTask, Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.keep import Keep, Relative, Upright

NO_OFFSET: Array = frozen(np.zeros(3))
"""A hand's own point is here in its frame, m."""


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


def line_to(state: State, hand: str, place: Array, offset: Array = NO_OFFSET) -> Task:
    """Return what holds while a point of a hand moves straight to a place: a line.

    Args:
        state: The robot where the motion starts.
        hand: Name of the hand.
        place: In the base frame (3,), m. Where the point is there already, it stays.
        offset: Where the point is in the hand's frame (3,), m.
    """
    number = state.robot.hand(hand)
    here = state.hands[number] + state.rotations[number] @ offset
    along = np.asarray(place, float) - here
    if np.linalg.norm(along) < SHORTEST:
        return PointTask(hand, triple(here), triple(offset))
    return LineTask(hand, triple(here), triple(along), triple(offset))


def _tasks(state: State, keep: Keep) -> tuple[Task, ...]:
    """Return the constraints of one thing that is kept."""
    robot = state.robot
    match keep:
        case Keep(upright=Upright() as upright):
            turned, direction = state.rotations[robot.hand(upright.hand)], unit(upright.direction)
            axis = turned.T @ direction if upright.axis is None else unit(upright.axis)
            return (AxisTask(upright.hand, triple(axis), triple(direction)),)
        case Keep(orientation=str(hand)):
            return (orientation_kept(state, hand),)
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


def orientation_kept(state: State, hand: str, reference: str | None = None) -> OrientationTask:
    """Return what keeps a hand turned as it is, in the base frame or in that of another hand."""
    turned = state.rotations[state.robot.hand(hand)]
    if reference is not None:
        turned = state.rotations[state.robot.hand(reference)].T @ turned
    first, second, third = map(triple, turned)
    return OrientationTask(hand, (first, second, third), reference)


def place_kept(state: State, first: str, second: str) -> RelativeTask:
    """Return what keeps a hand where it is in the frame of another one, the first."""
    apart = state.hands[state.robot.hand(second)] - state.hands[state.robot.hand(first)]
    there = state.rotations[state.robot.hand(first)].T @ apart
    return RelativeTask(first, second, triple(there), in_first=True)


def _relative(state: State, relative: Relative) -> tuple[Task, ...]:
    first, second = relative.hands
    if relative.what == "difference":
        apart = state.hands[state.robot.hand(second)] - state.hands[state.robot.hand(first)]
        return (RelativeTask(first, second, triple(apart)),)
    place = place_kept(state, first, second)
    return (place,) if relative.what == "place" else (place, orientation_kept(state, second, first))
