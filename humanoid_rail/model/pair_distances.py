"""How far apart the pairs of a robot's links are kept."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot


def own_distances(robot: Robot) -> Array:
    """Return the distance that each self-collision pair keeps where it is less than the one asked for (P,), m.

    It is infinite where nothing is said of a pair, in the order of `Robot.self_collision_pairs`.
    """
    own = robot.pair_distances
    return np.array([own.get((i, j), own.get((j, i), np.inf)) for i, j in robot.self_collision_pairs])
