"""How far a motion leaves a constraint, as frozen data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from humanoid_rail.kinematics.kept_tasks import AxisTask, DistanceTask, LineTask, OrientationTask
from humanoid_rail.kinematics.task import ConfigurationTask, DirectionTask, PointTask, RelativeTask, Task

KEPT_TASKS = (
    PointTask,
    LineTask,
    RelativeTask,
    DistanceTask,
    AxisTask,
    DirectionTask,
    OrientationTask,
    ConfigurationTask,
)
"""What is bounded of these tasks is known. A class derived from one is the user's own."""


@dataclass(frozen=True)
class Deviation:
    """How far a motion leaves a constraint."""

    name: str
    """What is kept, in words."""
    unit: str
    """`m` or `rad`."""
    bound: float
    """It leaves it by no more than this at any time, m or rad: a true upper bound."""
    t: float
    """About when it does so most, s."""
    begin: float = 0.0
    """From when on it is kept, s, ..."""
    end: float = 0.0
    """... and until when."""
    task: Task | None = None
    """The constraint."""

    def data(self) -> dict[str, Any]:
        """Return the same as plain data."""
        plain = {field.name: getattr(self, field.name) for field in fields(self)}
        if self.task is not None:
            kind = type(self.task)
            plain["task"] = {"kind": kind.__name__, **asdict(self.task)}  # type: ignore[call-overload]
        return plain

    def __str__(self) -> str:
        amount = f"{1e3 * self.bound:.3g} mm" if self.unit == "m" else f"{np.rad2deg(self.bound):.3g} deg"
        return f"{self.name} is left by up to {amount}, about t = {self.t:.4g} s"


def deviation_of(data: Mapping[str, Any]) -> Deviation:
    """Return a deviation from plain data."""
    task = data.get("task")
    if task is None:
        return Deviation(**data)
    kinds: dict[str, Any] = {kind.__name__: kind for kind in KEPT_TASKS}
    return Deviation(**{**data, "task": kinds[task["kind"]](**{k: x for k, x in task.items() if k != "kind"})})


def name_of(task: Task) -> str:
    """Return what a constraint keeps, in words."""
    match task:
        case PointTask():
            return f"the place of the hand {task.hand}"
        case LineTask():
            return f"the line of the hand {task.hand}"
        case RelativeTask():
            return f"the place of the hand {task.second} relative to {task.first}"
        case DistanceTask():
            return f"the distance of the hands {task.first} and {task.second}"
        case AxisTask() | DirectionTask():
            return f"the direction of the hand {task.hand}"
        case OrientationTask():
            relative = f" relative to {task.reference}" if task.reference is not None else ""
            return f"the orientation of the hand {task.hand}{relative}"
        case ConfigurationTask():
            return f"the position of {', '.join(task.joints)}"
    return type(task).__name__
