"""What is to be planned, in one frozen object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, FrozenArrays, checked_array, frozen
from humanoid_rail.errors import InvalidInput, check_kind
from humanoid_rail.kinematics.deviation import KEPT_TASKS, name_of
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import check_tasks, stack_error
from humanoid_rail.kinematics.within_task import WithinTask, pinned
from humanoid_rail.model.position_limits import ROUNDING, within_position_limits
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.scene import Scene

HOLDS = 1e-6
"""A constraint holds at a start where the norm of its error is at most this, m."""


@dataclass(frozen=True, eq=False)
class Problem(FrozenArrays):
    """A robot in a scene, the tasks that are to be done, and where the motion starts.

    The targets of the scene do not count here: :func:`humanoid_rail.plan` makes tasks of them.

    Raises:
        InvalidInput: If a part is of the wrong kind, the start is not n finite numbers within the joint limits, or a
            constraint does not hold there.
    """

    robot: Robot
    """The robot. Its hands are those whose manipulability counts."""
    scene: Scene
    """The scene, with the obstacles where they are when the motion starts."""
    tasks: Sequence[Task]
    """What is to be reached, all at once. Kept as a tuple."""
    start: ArrayLike
    """Configuration (n,) where the motion starts, m and rad. Kept as a read-only array; what is slightly beyond a
    position limit is put onto it, and a warning says so where it is more than rounding."""

    constraints: Sequence[Task] = ()
    """What holds at all times along the motion, from the start on: tasks of this package. Kept as a tuple."""

    alternatives: Sequence[Sequence[Task]] = ()
    """Several choices of what is to be reached, of which one has to be: each is what `tasks` may be. If there are some,
    `auto` takes the one with the shortest path, and other methods the nearest."""

    def __post_init__(self) -> None:
        check_kind("robot", self.robot, Robot)
        check_kind("scene", self.scene, Scene)
        check_tasks(self.tasks, self.robot)
        object.__setattr__(self, "tasks", tuple(self.tasks))
        for i, tasks in enumerate(self.alternatives):
            check_tasks(tasks, self.robot, f"alternatives[{i}]")
        object.__setattr__(self, "alternatives", tuple(map(tuple, self.alternatives)))
        robot = self.robot
        valid = f"{robot.n} finite numbers, for {', '.join(robot.joint_names)}"
        start = checked_array("start", self.start, (robot.n,), valid)
        object.__setattr__(self, "start", frozen(within_position_limits(robot, start, "start", said_from=ROUNDING)))
        self._check_constraints()

    def _check_constraints(self) -> None:
        """Check that constraints are some whose deviation can be bounded, and that they hold at the start."""
        check_tasks(self.constraints, self.robot, "constraints", least=0)
        object.__setattr__(self, "constraints", tuple(self.constraints))
        state = Kinematics(self.robot).state(self.q) if self.constraints else None
        for i, task in enumerate(self.constraints):
            if type(task) not in KEPT_TASKS:
                valid = (
                    f"one of {', '.join(kind.__name__ for kind in KEPT_TASKS)}: of others no deviation can be proven"
                )
                raise InvalidInput(f"constraints[{i}]", task, valid)
            assert state is not None
            left = float(np.linalg.norm(task.error(state)))
            if left > HOLDS:
                valid = f"one that holds at the start to {HOLDS:g} m: {name_of(task)} is {left:.3g} m off there"
                raise InvalidInput(f"constraints[{i}]", task, valid)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled: all but what the native engine has made of it."""
        return {name: value for name, value in vars(self).items() if name != "native"}

    @cached_property
    def native(self) -> NativeKinematics:
        """The robot among the obstacles, in the native engine."""
        return NativeKinematics(self.robot, self.obstacles)

    @property
    def choices(self) -> tuple[tuple[Task, ...], ...]:
        """What may be reached: the alternatives, or the tasks where there are none."""
        return tuple(map(tuple, self.alternatives)) or (tuple(self.tasks),)

    def taking(self, choice: int) -> Problem:
        """Return the problem of reaching one of the choices, by its number from 0."""
        if not self.alternatives:
            return self
        found = replace(self, tasks=self.alternatives[choice], alternatives=())
        if "native" in vars(self):
            vars(found)["native"] = self.native
        return found

    def pinned(self, q: Array) -> Problem:
        """Return the problem of reaching what a configuration (n,) reaches within tolerances, exactly as there."""
        if not any(isinstance(task, WithinTask) for task in self.tasks):
            return self
        found = replace(self, tasks=pinned(self.tasks, Kinematics(self.robot).state(q)))
        if "native" in vars(self):
            vars(found)["native"] = self.native
        return found

    @property
    def nearest(self) -> int:
        """The number of the choice, from 0, whose error is smallest at the start."""
        if len(self.choices) == 1:
            return 0
        state = Kinematics(self.robot).state(self.q)
        return int(np.argmin([np.linalg.norm(stack_error(state, tasks)) for tasks in self.choices]))

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles of the scene."""
        return self.scene.obstacles

    @property
    def q(self) -> Array:
        """The start as an array (n,)."""
        assert isinstance(self.start, np.ndarray)
        return self.start
