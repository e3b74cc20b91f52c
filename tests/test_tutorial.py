"""The numbers of the tutorial."""

from __future__ import annotations

import re
from itertools import islice

import numpy as np
import pytest
from conftest import ROOT

from humanoid_rail import Scene, load_robot
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.search.goal_sampler import seeds

ROW = re.compile(r"^\| ([\d.]+) m \| ([\d.]+) m to ([\d.]+) m \|$", re.MULTILINE)
ROWS = [tuple(map(float, row)) for row in ROW.findall((ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8"))]
BEYOND = 0.4
"""So much farther no posture is found, m: the table is not far from what the robot can do."""


@pytest.mark.parametrize(("distance", "lowest", "highest"), ROWS)
def test_both_hands_reach_as_far_as_the_table_says(distance: float, lowest: float, highest: float) -> None:
    robot = load_robot(link_radius=0.05)
    solver = InverseKinematics(robot, ())

    def is_reached(z: float) -> bool:
        scene = Scene(name="reach", targets={"left": (-distance, 3.5, z), "right": (-distance, 4.5, z)})
        tasks = tasks_of(robot, scene.steps[0])
        starts = islice(seeds(robot, robot.initial, np.random.default_rng(0)), 200)
        return any(solver.solve(q, tasks, 0.0).reached for q in starts)

    assert [is_reached(z) for z in (lowest, highest)] == [True, True]
    assert [is_reached(z) for z in (lowest - BEYOND, highest + BEYOND)] == [False, False]


def test_the_table_is_found() -> None:
    assert len(ROWS) == 3
