"""What would help where a plan failed; each is tried out before it is said."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.diagnosis import BlockingPair, Remedy, Vector, length
from humanoid_rail.kinematics.task import DirectionTask, PointTask, Task
from humanoid_rail.model.robot import Robot, called
from humanoid_rail.planning.methods import Auto
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.probe import Probe, hand_of, hands_with_targets, target_of
from humanoid_rail.scene.obstacles import name_of

PLANNED, POSTURE = "planned", "posture"
"""How a remedy was tried out; see :class:`humanoid_rail.diagnosis.Remedy`."""
SMALLER = (0.5, 0.2, 0.05)
"""Safety distances are tried that are so many times that of the method."""
LEAST_DISTANCE = 1e-3
"""No smaller safety distance than this is proposed, m."""
MOST_NAMES = 4
"""Of obstacles that would have to go so many are named."""
USE_AUTO = "plan with the method auto"
"""To other methods this is proposed."""
MORE_CHECKS = 5000
"""Where fewer edge checks than this were allowed, it is tried out with so many."""
ALONE = 2
"""So many obstacles are left out one at a time before all that are in the way are."""


def targets_moved(probe: Probe, tasks: Sequence[Task], moved: Sequence[Task], why: str = "") -> Remedy:
    """Return that targets are moved to where there is a configuration clear of everything; and why so far."""
    places = {hand: target_of(moved, hand) for hand in hands_with_targets(tasks)}
    changed = {hand: place for hand, place in places.items() if place != target_of(tasks, hand)}
    said = [f"the target of {called(hand)} {_by(target_of(tasks, hand), place)}" for hand, place in changed.items()]
    proven = PLANNED if probe.is_planned(moved) else POSTURE
    return Remedy(f"move {' and '.join(said)}{why}", proven, targets=tuple(changed.items()))


def smaller_distance(probe: Probe, tasks: Sequence[Task], near: Sequence[Array]) -> Remedy | None:
    """Return that a smaller safety distance is kept; None if none that was tried is enough, or the method has none."""
    for share in SMALLER if probe.has_distance else ():
        distance = max(share * probe.kept, LEAST_DISTANCE)
        if distance >= probe.kept:
            return None
        if probe.posture(tasks, distance + probe.spare, near=near) is not None and probe.is_planned(tasks, distance):
            said = f"a safety_distance of {distance:g} m instead of {probe.kept:g} m"
            return Remedy(said, PLANNED, option=("safety_distance", distance))
    return None


def without_obstacles(probe: Probe, tasks: Sequence[Task], pairs: Sequence[BlockingPair]) -> Remedy | None:
    """Return that obstacles in the way are gone: one of the first, or all of them; None if that is not enough."""
    blocking = list(dict.fromkeys(pair.obstacle for pair in pairs if pair.obstacle is not None))
    choices = [(number,) for number in blocking[:ALONE]] + ([tuple(blocking)] if len(blocking) > 1 else [])
    for choice in choices:
        rest = tuple(o for i, o in enumerate(probe.problem.obstacles) if i not in choice)
        if probe.posture(tasks, obstacles=rest) is not None and probe.is_planned(tasks, obstacles=rest):
            names = [name_of(probe.problem.obstacles, i) for i in choice]
            more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
            return Remedy(f"take {', '.join(names[:MOST_NAMES])}{more} out of the way", PLANNED, without=choice)
    return None


def limit_opened(probe: Probe, tasks: Sequence[Task], robot: Robot, joint: str, side: str, value: float) -> Remedy:
    """Return that a position limit is opened to a value in m or rad, with which there is a configuration."""
    proven = PLANNED if probe.is_planned(tasks, robot=robot) else POSTURE
    said = f"open the {side} limit of {joint} to {value:.4g} {robot.unit_of(joint)}"
    return Remedy(said, proven, limit=(joint, side, value))


def turned_freely(probe: Probe, tasks: Sequence[Task]) -> Remedy | None:
    """Return that hands need not be turned; None if they need not be as it is, or that is not enough."""
    free = [task for task in tasks if not _turns(task)]
    if not free or len(free) == len(tasks) or probe.posture(free) is None or not probe.is_planned(free):
        return None
    return Remedy("leave open how the hands are turned (approach, rpy)", PLANNED)


def fewer_hands(probe: Probe, tasks: Sequence[Task]) -> Remedy | None:
    """Return that targets are reached one after the other; None if one of them cannot be reached even so."""
    hands = hands_with_targets(tasks)
    if len(hands) < 2 or any(hand_of(task) is None for task in tasks):
        return None
    alone = [[task for task in tasks if hand_of(task) == hand] for hand in hands]
    if not all(probe.posture(own) is not None and probe.is_planned(own) for own in alone):
        return None
    return Remedy("reach the targets one after the other, in steps of their own", PLANNED)


def by_auto(probe: Probe, tasks: Sequence[Task], method: PlanningMethod) -> Remedy | None:
    """Return that `auto` plans it; None if that did."""
    if isinstance(method, Auto) or not probe.is_planned(tasks):
        return None
    return Remedy(USE_AUTO, PLANNED)


def more_checks(probe: Probe, tasks: Sequence[Task], method: PlanningMethod) -> Remedy | None:
    """Return that more edges are checked; None if so many were allowed that it is not tried out with more."""
    if not isinstance(method, Auto) or method.max_edge_checks >= MORE_CHECKS:
        return None
    if not probe.is_planned(tasks, max_edge_checks=MORE_CHECKS):
        return None
    said = f"allow more edge checks: max_edge_checks = {MORE_CHECKS} instead of {method.max_edge_checks}"
    return Remedy(said, PLANNED, option=("max_edge_checks", MORE_CHECKS))


def _turns(task: Task) -> bool:
    return isinstance(task, DirectionTask) or (isinstance(task, PointTask) and any(task.offset))


def _by(old: Vector, new: Vector) -> str:
    """Say where a target goes: along an axis where it is one, and where it is then."""
    shift = np.subtract(new, old)
    distance = float(np.linalg.norm(shift))
    main = int(np.abs(shift).argmax())
    to = f"to ({', '.join(f'{x:.4g}' for x in new)})"
    if np.count_nonzero(np.abs(shift) > 1e-9) == 1:
        return f"{length(distance)} m along {'-' if shift[main] < 0 else '+'}{'xyz'[main]}, {to}"
    return f"by {length(distance)} m, {to}"
