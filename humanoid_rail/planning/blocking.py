"""The pairs of bodies that come too near to each other at a configuration."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.diagnosis import BlockingPair
from humanoid_rail.kinematics.state import KinematicsModel, Measurement
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.scene.obstacles import name_of

STEPS = 100
"""A straight edge is looked at in so many places."""
ROUNDING = 1e-6
"""What clearances lack less of than this counts as kept, m."""


def blocking_pairs(
    kinematics: KinematicsModel, q: Array, beyond: Array, distance: float, t: float = 0.0
) -> tuple[BlockingPair, ...]:
    """Return the pairs that lack most of a distance at a configuration: of each obstacle the worst link.

    Args:
        kinematics: The robot among the obstacles.
        q: The configuration (n,) at which clearances are given, m and rad.
        beyond: The configuration (n,) at which the pairs come too near.
        distance: What pairs have to keep, m.
        t: When it is, for obstacles that move, s.
    """
    here = kinematics.measure(q, t=t)
    return _blocking(kinematics, here, kinematics.measure(beyond, t=t), distance)


def blocking_on_edge(kinematics: KinematicsModel, q: Array, goal: Array, distance: float) -> tuple[BlockingPair, ...]:
    """Return the pairs that come too near on the straight edge from a configuration (n,) to another.

    The first ones come first. For each obstacle, and each link that others meet, there is one.
    """
    pairs: dict[str, BlockingPair] = {}
    here = kinematics.measure(q)
    for share in np.linspace(0.0, 1.0, STEPS + 1):
        for pair in _blocking(kinematics, here, kinematics.measure(q + share * (goal - q)), distance):
            pairs.setdefault(pair.other, pair)
    return tuple(pairs.values())


def _blocking(
    kinematics: KinematicsModel, here: Measurement, there: Measurement, distance: float
) -> tuple[BlockingPair, ...]:
    robot, obstacles = kinematics.robot, kinematics.obstacles
    found: list[tuple[float, BlockingPair]] = []
    for number in range(len(obstacles)):
        link = int(there.clearance[:, number].argmin())
        clearance = float(there.clearance[link, number])
        if clearance < distance - ROUNDING:
            name = name_of(obstacles, number)
            near = float(here.clearance[link, number])
            found.append((clearance, BlockingPair(robot.link_names[link], name, number, near, clearance)))
    kept = np.minimum(own_distances(robot), distance)
    for k, (one, other) in enumerate(robot.self_collision_pairs):
        clearance = float(there.self_clearance[k])
        if clearance < kept[k] - ROUNDING:
            names = robot.link_names[one], robot.link_names[other]
            found.append((clearance, BlockingPair(*names, None, float(here.self_clearance[k]), clearance)))
    return tuple(pair for _, pair in sorted(found, key=lambda one: one[0]))
