"""Plan folders carry the robot, whatever it is."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import AHEAD, ROOT, plan

from humanoid_rail import (
    Box,
    Robot,
    Scene,
    export,
    load_robot,
    load_robot_of_scene,
    load_scene,
    read_plan,
    verify,
    write_plan,
)

sys.path.append(str(ROOT / "tests" / "model"))
from saved_robots import assert_same, load, write_robot

BOX = Box(center=(0.0, 0.0, 2.0), size=(0.2, 0.2, 0.2))


def test_a_plan_of_a_robot_with_meshes_is_the_same_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load(write_robot(tmp_path / "in"))
    scene = Scene(name="meshy", targets={"tool": [0.9, 0.7, 0.4]}, initial={"j1": 0.1}, obstacles=(BOX,))
    motion = plan(robot, scene, "qp")
    before = verify(robot, scene, motion)
    export(motion, robot, scene, "ros-json", tmp_path / "before.json")
    write_plan(motion, robot, scene, tmp_path / "out")
    shutil.rmtree(tmp_path / "in")
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    found = read_plan(tmp_path / "elsewhere")
    assert_same(robot, found.robot)
    assert verify(found.robot, found.scene, found.trajectory) == before
    export(found.trajectory, found.robot, found.scene, "ros-json", tmp_path / "after.json")
    assert (tmp_path / "after.json").read_bytes() == (tmp_path / "before.json").read_bytes()
    # Its scene names the robot, so that it can be planned again.
    again = load_scene(tmp_path / "elsewhere" / "scene.json")
    np.testing.assert_array_equal(plan(load_robot_of_scene(again), again, "qp").q, motion.q)


def test_the_papers_robot_is_its_urdf_alone_and_replaces_another(tmp_path: Path, robot: Robot) -> None:
    other = load(write_robot(tmp_path / "in"))
    scene = Scene(name="meshy", targets={"tool": [0.9, 0.7, 0.4]}, obstacles=(BOX,))
    write_plan(plan(other, scene, "gradient-projection", dt=0.1), other, scene, tmp_path / "out")
    papers = Scene(name="papers", targets=AHEAD)
    write_plan(plan(robot, papers, "gradient-projection", dt=0.1), robot, papers, tmp_path / "out")
    assert not (tmp_path / "out" / "robot.yaml").exists()
    assert not (tmp_path / "out" / "meshes").exists()
    assert_same(read_plan(tmp_path / "out").robot, robot)
    write_plan(plan(other, scene, "gradient-projection", dt=0.1), other, scene, tmp_path / "out")
    assert not (tmp_path / "out" / "robot.urdf").exists()
    assert_same(read_plan(tmp_path / "out").robot, other)


def test_one_hand_of_the_papers_robot_is_carried(tmp_path: Path, robot: Robot) -> None:
    left = robot.with_hands(["left"])
    scene = Scene(name="left", targets={"left": AHEAD["left"]})
    write_plan(plan(left, scene, "gradient-projection", dt=0.1), left, scene, tmp_path)
    assert_same(read_plan(tmp_path).robot, left)


def test_another_robot_can_be_given(tmp_path: Path, robot: Robot) -> None:
    thick = load_robot(link_radius=0.08)
    papers = Scene(name="papers", targets=AHEAD)
    write_plan(plan(robot, papers, "gradient-projection", dt=0.1), robot, papers, tmp_path / "out")
    thick.save(tmp_path / "thick")
    assert_same(read_plan(tmp_path / "out", robot_file=str(tmp_path / "thick")).robot, thick)
