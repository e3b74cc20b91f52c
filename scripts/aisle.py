"""A scene of more than a thousand boxes: an aisle between two racks with goods, in which the paper's robot picks."""

from __future__ import annotations

import numpy as np

from humanoid_rail import Box, Scene
from humanoid_rail.scene.targets import Step

RACKS = (-1.9, 1.9)
"""Where the racks are along x, m; the rail is between them."""
ENDS = (-1.0, 7.0)
"""Where the racks begin and end along y, m."""
BOARDS = (0.9, 1.7, 2.5, 3.3, 4.1, 4.9)
"""Heights of the boards, m."""
PICKS = ((-1.75, 0.5, 2.9), (-1.75, 2.5, 2.9), (1.75, 5.5, 2.9), (1.75, 3.5, 3.7), (-1.75, 4.5, 3.7), (-1.75, 6.5, 2.9))
"""Targets of the left and the right hand in turn, each in a bay without goods, m."""


def aisle() -> Scene:
    """Return the scene."""
    rng, (begin, end) = np.random.default_rng(7), ENDS
    bays = np.arange(begin, end)
    obstacles = []
    for x in RACKS:
        obstacles += [Box(center=(x, (begin + end) / 2, z), size=(0.6, end - begin, 0.03)) for z in BOARDS]
        obstacles += [Box(center=(x, y, 2.9), size=(0.6, 0.03, 4.0)) for y in (*bays, end)]
        for z in BOARDS[:-1]:
            for bay in bays:
                if any(abs(px - x) < 0.5 and bay < y < bay + 1 and z < pz < z + 0.8 for px, y, pz in PICKS):
                    continue
                for row in (-0.15, 0.15):
                    for y in np.linspace(bay + 0.07, bay + 0.93, 8):
                        size = rng.uniform([0.16, 0.06, 0.12], [0.26, 0.11, 0.42]).round(3)
                        obstacles.append(Box(center=(x + row, y, z + 0.02 + size[2] / 2), size=tuple(size)))
    steps = [Step(left=left, right=right) for left, right in zip(PICKS[::2], PICKS[1::2], strict=True)]
    return Scene(name="aisle", targets=tuple(steps), obstacles=tuple(obstacles))
