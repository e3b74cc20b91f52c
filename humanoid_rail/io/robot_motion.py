"""A trajectory as the motion of one robot: checked, and with the passive joints."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.verification import check_robot
from humanoid_rail.trajectory import Trajectory


def check_motion(trajectory: Trajectory, robot: Robot) -> None:
    """Check that a motion is one of a robot, in finite numbers.

    Raises:
        InvalidInput: If it is not.
    """
    check_robot(robot, trajectory)
    arrays = {"t": trajectory.t, "q": trajectory.q}
    if trajectory.timing is not None:
        arrays |= {"velocity": trajectory.timing.velocity, "acceleration": trajectory.timing.acceleration}
    for field, array in arrays.items():
        if not np.isfinite(array).all():
            raise InvalidInput(f"trajectory.{field}", array, "finite numbers")


def all_joints(robot: Robot, columns: list[Array]) -> list[Array]:
    """Return positions and their derivatives (N, n) of the actuated joints as those of all joints (N, nq).

    Args:
        robot: The robot.
        columns: The positions, in m and rad, and any number of their derivatives.
    """
    positions, *derivatives = columns
    return [positions @ robot.coupling.T + robot.offset, *(column @ robot.coupling.T for column in derivatives)]
