"""What is to be planned, in one frozen object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, FrozenArrays, frozen
from humanoid_rail.errors import InvalidInput, check_kind
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.native_tasks import check_tasks
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.configuration import check_within_limits
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Problem(FrozenArrays):
    """A robot in a scene, the tasks that are to be done, and where the motion starts.

    The targets of the scene do not count here: :func:`humanoid_rail.plan` makes tasks of them.

    Raises:
        InvalidInput: If a part is of the wrong kind, or the start is not n finite numbers within the joint limits.
    """

    robot: Robot
    """The robot. Its hands are those whose manipulability counts."""
    scene: Scene
    """The scene, with the obstacles where they are when the motion starts."""
    tasks: Sequence[Task]
    """What is to be reached, all at once. Kept as a tuple."""
    start: ArrayLike
    """Configuration (n,) where the motion starts, m and rad. Kept as a read-only array."""

    def __post_init__(self) -> None:
        check_kind("robot", self.robot, Robot)
        check_kind("scene", self.scene, Scene)
        check_tasks(self.tasks)
        object.__setattr__(self, "tasks", tuple(self.tasks))
        robot = self.robot
        try:
            start = frozen(self.start)
        except (TypeError, ValueError):
            start = frozen(np.empty(0))
        if start.shape != (robot.n,) or not np.isfinite(start).all():
            raise InvalidInput("start", self.start, f"{robot.n} finite numbers, for {', '.join(robot.joint_names)}")
        check_within_limits(robot, start, "start")
        object.__setattr__(self, "start", start)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled: all but what the native engine has made of it."""
        return {name: value for name, value in vars(self).items() if name != "native"}

    @cached_property
    def native(self) -> NativeKinematics:
        """The robot among the obstacles, in the native engine."""
        return NativeKinematics(self.robot, self.obstacles)

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles of the scene."""
        return self.scene.obstacles

    @property
    def q(self) -> Array:
        """The start as an array (n,)."""
        assert isinstance(self.start, np.ndarray)
        return self.start
