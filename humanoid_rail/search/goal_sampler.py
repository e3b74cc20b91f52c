"""Goal configurations: where their search begins."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.model.robot import Robot

TOGETHER = 8
"""So many configurations are drawn at once."""
WIDEST = 10.0
"""Joints without position limits are sampled within this distance of the start, m and rad."""


def seeds(robot: Robot, start: Array, random: np.random.Generator) -> Iterator[Array]:
    """Yield the start (n,), and then without end random configurations on the straight lines from it to anywhere.

    Joints whose speed limit is 0 stay where they are.
    """
    moves = robot.velocity_limit > 0
    lower = np.where(moves, np.maximum(robot.lower, start - WIDEST), start)
    upper = np.where(moves, np.minimum(robot.upper, start + WIDEST), start)
    yield start
    while True:
        yield from start + random.random((TOGETHER, 1)) * (random.uniform(lower, upper, (TOGETHER, robot.n)) - start)
