"""How far from its tasks a motion ends, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail.diagnosis import length
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import PointTask, Task
from humanoid_rail.model.robot import called


def what_remains(state: State, tasks: Sequence[Task], left: float) -> str:
    """Return how far each hand is from its target, or |e| where the tasks are not about the points of hands alone.

    Args:
        state: Where the motion ends.
        tasks: What was to be reached.
        left: |e| there, m.
    """
    if not all(type(task) is PointTask and not any(task.offset) for task in tasks):
        return f"|e| is {left:.4g} m"
    hands = [task.hand for task in tasks if isinstance(task, PointTask)]
    errors = [float(np.linalg.norm(task.error(state))) for task in tasks]
    one, *others = [f"{length(error)} m" for error in errors]
    more = [f"{called(hand)} {error}" for hand, error in zip(hands[1:], others, strict=True)]
    return f"{' and '.join([f'{called(hands[0])} is {one}', *more])} from {'their targets' if more else 'its target'}"
