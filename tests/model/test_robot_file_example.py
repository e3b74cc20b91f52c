"""The robot file that the documentation shows loads, and everything in it counts."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from arms import ball, fixed, joint, long_arm
from conftest import ROOT

from humanoid_rail import load_robot

ARM = long_arm(
    links={f"l{i}": ball(0.02) for i in range(6)},
    more=fixed("mount", "l5", "tcp", "0.1 0 0", ball(0.01))
    + f'<link name="f">{ball(0.005)}</link>'
    + joint("finger", "l5", "f", 0.15, 'lower="0" upper="0.1" velocity="1"'),
)


def test_the_robot_file_of_the_page_loads(tmp_path: Path) -> None:
    [text] = re.findall(r"```yaml\n(# robot\.yaml.*?)```", (ROOT / "docs" / "robots.md").read_text(), re.DOTALL)
    (tmp_path / "robot.yaml").write_text(text)
    (tmp_path / "arm.urdf").write_text(ARM)
    robot = load_robot(tmp_path)
    assert robot.name == "cell arm"
    [hand] = robot.hands
    assert (hand.name, hand.frame, hand.pointing) == ("tool", "tcp", (0.0, 0.0, 1.0))
    assert robot.locked == {"finger": 0.02}
    assert robot.model.jointPlacements[1].translation[2] == pytest.approx(0.4)
    limits = dict(
        zip(robot.joint_names, zip(robot.lower, robot.upper, robot.acceleration_limit, strict=True), strict=True)
    )
    assert limits["j1"] == (-1.5, 1.5, 8.0)
    assert limits["j2"][2] == pytest.approx(2.0 / 0.3)
    start = dict(zip(robot.joint_names, robot.initial, strict=True))
    assert (start["j2"], start["j3"], start["j4"]) == (-0.6, 1.2, 0.0)
    why = {frozenset((pair.link, pair.other)): pair.why for pair in robot.left_out}
    assert why[frozenset(("l1", "l3"))].startswith("a cable guide joins them")
    links = robot.link_names
    near = {frozenset((links[i], links[j])): apart for (i, j), apart in robot.pair_distances.items()}
    assert near[frozenset(("l2", "l4"))] == 0.004
