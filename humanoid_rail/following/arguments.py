"""The arguments of a follower, checked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, checked_array
from humanoid_rail.errors import InvalidInput, check_kind, checked_number
from humanoid_rail.kinematics.state import State
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.scene.obstacles import HalfSpace, Obstacle, name_of
from humanoid_rail.scene.scene import Scene

SHORTEST_CYCLE, LONGEST_CYCLE = 1e-4, 0.1
"""A cycle takes from this to that long, s."""


def no_state(q: Array, t: float) -> State:
    """Stand for the state that functions of the user's are given, which a follower does not call."""
    raise AssertionError("a follower calls nothing back")


def checked_cycle(dt: float) -> float:
    """Return how long a cycle takes, s.

    Raises:
        InvalidInput: If that is too short or too long.
    """
    return checked_number("dt", dt, least=SHORTEST_CYCLE, most=LONGEST_CYCLE)


def check_without_functions(gains: Gains, safety: Safety) -> None:
    """Check that options call no functions of the user's.

    Raises:
        InvalidInput: If they do, or are no options.
    """
    check_kind("gains", gains, Gains)
    check_kind("safety", safety, Safety)
    if gains.objectives:
        raise InvalidInput("gains.objectives", gains.objectives, "none: the follower's thread never waits for Python")
    if safety.equalities:
        raise InvalidInput("safety.equalities", safety.equalities, "none: the follower's thread never waits for Python")


def checked_acceleration(robot: Robot, given: ArrayLike | None) -> Array:
    """Return limits of the acceleration (n,), and check that all joints have those that a stop needs.

    Raises:
        InvalidInput: If one is missing or not valid.
    """
    if given is None:
        limit = robot.acceleration_limit
    else:
        every = np.full(robot.n, given) if np.ndim(given) == 0 else given
        limit = checked_array("acceleration_limit", every, (robot.n,))
    for name, values in (("velocity_limit", robot.velocity_limit), ("acceleration_limit", limit)):
        for joint, value in zip(robot.joint_names, values, strict=True):
            if not (np.isfinite(value) and value > 0.0):
                valid = "finite and greater than 0, or there is no stop to prove: give it in the robot's file or URDF"
                raise InvalidInput(f"{name} ({joint})", float(value), valid)
    return np.array(limit, float)


def checked_speeds(scene: Scene, given: float | Sequence[float] | None) -> Array:
    """Return the speed (o,) that no point of each obstacle exceeds, m/s.

    Raises:
        InvalidInput: If one is not valid, or less than that at which an obstacle moves in the scene.
    """
    moves = np.array([np.linalg.norm(obstacle.velocity) for obstacle in scene.obstacles], float)
    if given is None:
        return moves
    count = len(scene.obstacles)
    speeds = checked_array("obstacle_speed", np.full(count, given) if np.ndim(given) == 0 else given, (count,))
    for i, (speed, own) in enumerate(zip(speeds, moves, strict=True)):
        if not speed >= own * (1.0 - 1e-9):
            valid = f"at least {own:.6g} m/s, at which {name_of(scene.obstacles, i)} moves in the scene"
            raise InvalidInput("obstacle_speed", float(speed), valid)
    return speeds


def checked_obstacle(obstacles: Sequence[Obstacle], given: int | str) -> int:
    """Return the number of an obstacle that can be moved, given by its number or its name.

    Raises:
        InvalidInput: If there is none, there are several of that name, or it is a half-space.
    """
    named = [i for i, obstacle in enumerate(obstacles) if isinstance(given, str) and obstacle.name == given]
    is_number = isinstance(given, int) and not isinstance(given, bool) and 0 <= given < len(obstacles)
    if not is_number and len(named) != 1:
        valid = f"a number from 0 to {len(obstacles) - 1}, or a name that one obstacle has" if obstacles else "none"
        raise InvalidInput("obstacle", given, valid)
    number = named[0] if named else int(given)
    if isinstance(obstacles[number], HalfSpace):
        raise InvalidInput("obstacle", given, f"an obstacle with a centre; {name_of(obstacles, number)} stays")
    return number
