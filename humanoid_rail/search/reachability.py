"""How far targets are out of reach, which is told before a path is looked for."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import short
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.task import DirectionTask, PointTask, RelativeTask, Task, orientation_lever
from humanoid_rail.kinematics.within_task import WithinTask, nominal
from humanoid_rail.model.robot import Robot, called
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.search.goal_sampler import seeds
from humanoid_rail.search.least_error import least_error

REACH_SEEDS = 48
"""The reach of the hands is judged by inverse kinematics from this many starts."""
TURN_SEEDS = 1000
"""How hands can be turned is judged from this many starts, because few of them lead there."""
TURNED = 1e-5
"""A hand is turned as it has to be where its points are no farther than this from their places, m."""
MILLIMETRES = 30.0
"""Targets that are farther out of reach than this may have been given in millimetres, m."""


class TimedOut(Exception):
    """The time for planning was over before the reach was known."""


def out_of_reach(
    robot: Robot,
    tasks: Sequence[Task],
    start: Array,
    random: np.random.Generator,
    tolerance: float,
    deadline: float = np.inf,
) -> str | None:
    """Return by how much targets are out of reach, and for which hand; None if they are not.

    Args:
        robot: The robot, whose joint limits count; obstacles and other links do not.
        tasks: What is to be reached.
        start: Where to look first (n,).
        random: For where else to look.
        tolerance: How far |e| may stay from 0, m.
        deadline: When to stop looking, on the clock of `time.perf_counter`, s.

    Raises:
        TimedOut: If the deadline comes first.
    """
    judge = _Reach(robot, start, random, deadline)
    reached, turned = _followed(tasks), turning(tasks)
    together = judge.excess(reached, tolerance, REACH_SEEDS)
    if together is not None:
        return _too_far(judge, reached, together, tolerance)
    # No tolerance is about how hands are turned.
    together = judge.excess(tasks, TURNED, TURN_SEEDS) if turned else None
    return None if together is None else _not_turned(judge, tasks, together)


def followed(tasks: Sequence[Task]) -> tuple[Task, ...]:
    """Return the tasks that a velocity is to follow: all but those that turn hands, whose rows are dependent.

    Those with a tolerance lead to its middle.
    """
    return nominal(_followed(tasks))


def _followed(tasks: Sequence[Task]) -> tuple[Task, ...]:
    return tuple(task for task, kept in zip(tasks, _are_followed(tasks), strict=True) if kept)


def followed_gains(gains: Gains, tasks: Sequence[Task]) -> Gains:
    """Return the gains of the rows of the tasks that a velocity is to follow.

    Raises:
        InvalidInput: If there is not one number for all rows, or one for each.
    """
    rows = [kept for task, kept in zip(tasks, _are_followed(tasks), strict=True) for _ in range(task.rows)]
    return replace(gains, gain=gains.diagonal(len(rows))[rows])


def turning(tasks: Sequence[Task]) -> tuple[Task, ...]:
    """Return the tasks that are left to inverse kinematics because they turn hands."""
    return tuple(task for task, kept in zip(tasks, _are_followed(tasks), strict=True) if not kept)


def _are_followed(tasks: Sequence[Task]) -> list[bool]:
    kept = [not _turns(task) for task in tasks]
    return kept if any(kept) else [True] * len(kept)


def _turns(task: Task) -> bool:
    if isinstance(task, WithinTask):
        return type(task.task) is not PointTask or _turns(task.task)
    return type(task) is DirectionTask or (type(task) is PointTask and any(task.offset))


class _Reach:
    """Judges how near a robot can come to doing tasks, obstacles and other links left alone."""

    def __init__(self, robot: Robot, start: Array, random: np.random.Generator, deadline: float) -> None:
        self.robot, self._start, self._random, self._deadline = robot, start, random, deadline
        self._solver, self._kinematics = InverseKinematics(robot, ()), NativeKinematics(robot)

    def excess(self, tasks: Sequence[Task], tolerance: float, attempts: int) -> float | None:
        """Return the least error of some tasks in m if it is more than a tolerance, else None."""
        error = self._least_error(tasks, islice(seeds(self.robot, self._start, self._random), attempts), tolerance)
        return error if error > tolerance else None

    def _least_error(self, tasks: Sequence[Task], places: Iterable[Array], tolerance: float) -> float:
        """Return the least error in m that is found from some places (n,)."""
        best, least = self._start, np.inf
        for place in places:
            found = self._solver.solve(place, tasks, -np.inf)
            if found.error < least:
                best, least = found.q, found.error
            if least <= tolerance:
                return float(least)
            if time.perf_counter() > self._deadline:
                raise TimedOut
        return min(float(least), least_error(self._kinematics, tasks, best).error)


def _too_far(judge: _Reach, tasks: Sequence[Task], together: float, tolerance: float) -> str:
    """Say which targets are out of reach, or that they are not in reach at once."""
    errors = [(_named(task), judge.excess([task], tolerance, REACH_SEEDS)) for task in tasks]
    far = [
        (f"{what} is {f'{error:.3g}' if error < 100 else f'{error:.0f}'} {unit} out of reach", error)
        for (what, unit), error in errors
        if error
    ]
    if far:
        hint = ", given in millimetres?" if max(error for _, error in far) > MILLIMETRES else ""
        alone = "" if len(tasks) == 1 else "by itself, " if len(far) == 1 else "each by itself, "
        return alone + ", and ".join(said for said, _ in far) + hint
    hands = [task.hand for task in tasks if isinstance(task, PointTask)]
    if len(set(hands)) < max(2, len(tasks)):
        return f"each task can be done, but not all at once: |e| stays {together:.3g} m"
    both = "both" if len(hands) == 2 else "all"
    return f"each target is in reach of its hand, but not {both} at once"


def _named(task: Task) -> tuple[str, str]:
    """Return what errors call a task, and the unit of its error."""
    if isinstance(task, PointTask | WithinTask):
        return f"the target of {called(task.hand)}", "m"
    return f"what {short(task)} asks for", "m" if isinstance(task, DirectionTask | RelativeTask) else "(m or rad)"


def _not_turned(judge: _Reach, tasks: Sequence[Task], together: float) -> str:
    """Say which hands cannot be turned as they have to be, or that they cannot be at once."""
    of_hands = [task for task in tasks if isinstance(task, PointTask | DirectionTask | WithinTask)]
    turned = {hand: [t for t in of_hands if t.hand == hand] for hand in judge.robot.hand_names}
    turned = {hand: some for hand, some in turned.items() if any(map(_turns, some))}
    alone = {hand: judge.excess(some, TURNED, TURN_SEEDS) for hand, some in turned.items()}
    far = [
        f"{called(hand)} is {_degrees(judge.robot, error, turned[hand])} deg from how it has to be turned"
        for hand, error in alone.items()
        if error
    ]
    if far:
        return f"the targets are in reach, but there {', and '.join(far)}, or more"
    left = f"{_degrees(judge.robot, together, of_hands)} deg are left, or more"
    if len(turned) == 1:
        return f"{called(next(iter(turned)))} can be turned as it has to be, but not with the other tasks done: {left}"
    return f"each hand can be turned as it has to be, but not {'both' if len(turned) == 2 else 'all'} at once: {left}"


def _degrees(robot: Robot, error: float, tasks: Sequence[PointTask | DirectionTask | WithinTask]) -> str:
    """Return by how much a hand is turned wrongly, or more, if tasks have that error in m.

    Turned by an angle, a hand at its target has each of its further points off by 2 lever sin(angle / 2), or less.
    """
    levers = [_lever(robot, task) for task in tasks]
    return f"{np.rad2deg(2.0 * np.arcsin(min(1.0, error / (2.0 * float(np.linalg.norm(levers)))))):.2g}"


def _lever(robot: Robot, task: PointTask | DirectionTask | WithinTask) -> float:
    """Return what turns an angle of a hand into the error of a task, m."""
    if isinstance(task, WithinTask):
        return orientation_lever(robot, task.hand) if _turns(task) else 0.0
    return task.lever_of(robot) if isinstance(task, DirectionTask) else float(np.linalg.norm(task.offset))
