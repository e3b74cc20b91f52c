"""What is said of the end of a segment: which alternatives it took, and how far it is from the middle of tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from humanoid_rail.kinematics.kept_tasks import AxisTask
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.task import PointTask, orientation_lever
from humanoid_rail.kinematics.within_task import WithinTask
from humanoid_rail.planning.moves import Move
from humanoid_rail.planning.options import Planned
from humanoid_rail.problem import Problem
from humanoid_rail.result import Status
from humanoid_rail.scene.poses import AnyOf, alternatives
from humanoid_rail.scene.targets import Step


def said_of_end(move: Move, problem: Problem, planned: Planned, taken: Mapping[int, int]) -> Iterator[str]:
    """Yield what is said of the end of a segment.

    Args:
        move: The move of the scene.
        problem: Its problem, of the alternatives that were taken.
        planned: Its motion.
        taken: The number of the combination of alternatives that was taken, by step.
    """
    if not move.arrives or planned.motion.status is not Status.REACHED:
        return
    if move.stated is not None:
        yield from _taken(move.stated, taken[move.step])
    state = None
    for task in problem.tasks:
        if isinstance(task, WithinTask):
            state = Kinematics(problem.robot).state(planned.motion.q[-1]) if state is None else state
            off = float(np.linalg.norm(task.task.error(state)))
            yield f"{task.hand} is {_measured(problem, task, off)} off the middle of its tolerance"


def _taken(stated: Step, number: int) -> Iterator[str]:
    """Yield which alternative each hand takes in a combination of them."""
    hands = list(stated.items())
    sizes = [len(alternatives(target)) for _, target in hands]
    chosen = np.unravel_index(number, sizes)
    for (hand, target), size, which in zip(hands, sizes, chosen, strict=True):
        if isinstance(target, AnyOf):
            yield f"{hand} takes alternative {int(which) + 1} of {size}"


def _measured(problem: Problem, task: WithinTask, off: float) -> str:
    if isinstance(task.task, PointTask):
        return f"{off:.3g} m"
    half = off / (2.0 * (task.task.lever or orientation_lever(problem.robot, task.hand)))
    angle = 2.0 * (np.arctan(half) if isinstance(task.task, AxisTask) else np.arcsin(min(1.0, half)))
    return f"{float(angle):.3g} rad"
