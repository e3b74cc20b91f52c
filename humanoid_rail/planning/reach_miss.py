"""The nearest miss of targets that are out of reach, the joint limits that hold it back, and what would help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.diagnosis import Remedy
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.beyond_limits import robot_beyond
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.probe import Probe, hand_of, hands_with_targets, shifted, target_of
from humanoid_rail.planning.remedies import fewer_hands, limit_opened, targets_moved, turned_freely
from humanoid_rail.search.least_error import LeastError, least_error

HELD = 100.0
"""The errors of hands that reach their targets count this many times as much."""
LEAST_SLOPE = 0.05
"""A limit holds back if the error falls by at least this share of what a joint's motion moves a hand."""
AT_LIMIT = 1e-4
"""A joint is at a limit within this share of its range."""
FURTHER = (1.0, 1.02, 1.05, 1.1, 1.2, 1.4)
"""A hand that is just in reach is stretched, and may touch something: so many times the shift is tried."""
FURTHER_SAID = ", a little more than it misses, to keep clear"
"""This is said of such a shift."""
MOST_LIMITS = 2
"""So many limits are named, those that hold back most."""
STARTS = 6
"""The smallest error is looked for from so many starts."""
WIDER = 2.0
"""A limit that holds back is opened by this many times its range at most."""
HALVINGS = 7
"""How far it has to be opened is narrowed down by half so often."""


class ReachMiss(NamedTuple):
    """Where a robot gets nearest."""

    q: Array
    """Configuration (n,) within the joint limits, m and rad."""
    limits: tuple[str, ...]
    """The joint limits that hold it back."""
    remedies: list[Remedy | None]


def reach_miss(probe: Probe, tasks: Sequence[Task]) -> ReachMiss:
    """Return where the robot gets nearest to targets that are out of its reach, and what would help."""
    hands = hands_with_targets(tasks)
    far = [h for h in hands if probe.posture([t for t in tasks if hand_of(t) == h], -np.inf) is None]
    # Where each target is in reach alone, that of the hand is moved that has to go less far.
    choices = [far] if far else [[hand] for hand in hands] or [[]]
    near = sorted((probe.solve(q, tasks, -np.inf, obstacles=()) for q in probe.starts), key=lambda one: one.error)
    starts = [posture.q for posture in near[:STARTS]]
    moving, least = min(((some, _least(probe, tasks, some, starts)) for some in choices), key=lambda one: one[1].error)
    limits = _limits(probe.robot, least)
    remedies = [
        _moved(probe, tasks, moving, least.q),
        *(_opened(probe, tasks, joint, side, least.q) for joint, side, _ in limits),
        turned_freely(probe, tasks),
        fewer_hands(probe, tasks),
    ]
    return ReachMiss(least.q, tuple(said for _, _, said in limits), remedies)


def _least(probe: Probe, tasks: Sequence[Task], moving: Sequence[str], starts: Sequence[Array]) -> LeastError:
    """Return the smallest error of tasks, where those of other hands than the moving ones are done if possible."""
    weight = np.concatenate([np.full(t.rows, 1.0 if not moving or hand_of(t) in moving else HELD) for t in tasks])
    bare = NativeKinematics(probe.robot)
    return min((least_error(bare, tasks, q, weight) for q in starts), key=lambda one: one.error)


def _limits(robot: Robot, least: LeastError) -> list[tuple[int, str, str]]:
    """Return the limits beyond which the error would fall further: joint, side, in words; the strongest first."""
    width = robot.upper - robot.lower
    found: list[tuple[float, int, str, str]] = []
    for joint in np.flatnonzero((width > 0) & (robot.velocity_limit > 0)):
        slope, name = float(least.slope[joint]), robot.joint_names[joint]
        sides = (("lower", robot.lower[joint], slope > 0), ("upper", robot.upper[joint], slope < 0))
        for side, limit, falls in sides:
            is_there = abs(least.q[joint] - limit) <= AT_LIMIT * width[joint]
            if is_there and falls and abs(slope) > LEAST_SLOPE * least.error:
                said = f"{name} is at its {side} limit of {limit:.4g} {robot.unit_of(name)}"
                found.append((abs(slope), int(joint), side, said))
    return [(joint, side, said) for _, joint, side, said in sorted(found, reverse=True)[:MOST_LIMITS]]


def _moved(probe: Probe, tasks: Sequence[Task], moving: Sequence[str], q: Array) -> Remedy | None:
    """Return how far targets have to be moved."""
    places = NativeKinematics(probe.robot).measure(q).hands
    for further in FURTHER:
        moved = tuple(tasks)
        for hand in moving:
            shift = places[probe.robot.hand(hand)] - np.array(target_of(tasks, hand))
            # Whole millimetres, towards the robot.
            shift = np.sign(shift) * np.ceil(1e3 * further * np.abs(shift) - 1e-6) / 1e3
            moved = shifted(moved, hand, shift)
        if moving and probe.posture(moved, near=[q]) is not None:
            return targets_moved(probe, tasks, moved, FURTHER_SAID if further > 1.0 else "")
    return None


def _opened(probe: Probe, tasks: Sequence[Task], joint: int, side: str, q: Array) -> Remedy | None:
    """Return how far a position limit has to be opened, if that alone is enough."""
    # Neighbours that this limit keeps apart are checked against each other.
    robot = robot_beyond(probe.robot, joint)
    limit, width = float(getattr(robot, side)[joint]), float(robot.upper[joint] - robot.lower[joint])
    outwards = -1.0 if side == "lower" else 1.0

    def opened(by: float) -> Robot:
        limits = np.array(getattr(robot, side))
        limits[joint] = limit + outwards * by
        return replace(robot, lower=frozen(limits)) if side == "lower" else replace(robot, upper=frozen(limits))

    low, high = 0.0, WIDER * width
    there = probe.posture(tasks, robot=opened(high), near=[q])
    if there is None:
        return None
    for _ in range(HALVINGS):
        high = min(high, max(low, outwards * (float(there[joint]) - limit)))
        middle = (low + high) / 2
        found = probe.solve(there, tasks, robot=opened(middle))
        low, high, there = (low, middle, found.q) if found.reached else (middle, high, there)
    value = limit + outwards * np.ceil(1e3 * high) / 1e3
    return limit_opened(probe, tasks, opened(abs(value - limit)), robot.joint_names[joint], side, float(value))
