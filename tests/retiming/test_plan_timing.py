"""How `humanoid-rail plan` times what it plans."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest
from conftest import ROOT
from test_commands import Ran, assert_bad_input

from humanoid_rail import load_robot, read_trajectory
from humanoid_rail.io.plan_folder import read_plan

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"


def test_plans_by_auto_are_for_drives(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd, "plan", SCENE, "--out", tmp_path / "out", "--no-view")
    assert ran.code == 0
    assert "peak acceleration" in ran.out
    motion = read_trajectory(tmp_path / "out")
    assert motion.timing is not None
    assert not motion.timing.velocity[[0, -1]].any()
    assert motion.certified
    assert motion.reason == f"at the targets at t = {motion.duration:.4g} s"
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["peaks"][0]["jerk_limit"] is None


def test_the_timing_of_the_plan_can_be_kept(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Ran(capfd, "plan", SCENE, "--out", tmp_path / "fastest", "--no-view")
    ran = Ran(capfd, "plan", SCENE, "--timing", "paper", "--out", tmp_path / "paper", "--no-view")
    assert "it starts at full speed" in ran.out
    paper, fastest = read_trajectory(tmp_path / "paper"), read_trajectory(tmp_path / "fastest")
    assert paper.timing is None
    assert paper.duration < fastest.duration
    np.testing.assert_array_equal(paper.q[[0, -1]], fastest.q[[0, -1]])


def test_cases_keep_the_papers_timing_unless_told_otherwise(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--case", "3", "--timing", "fastest", "--jerk-limit", "50", "--dt", "0.02", "--no-view"]
    assert Ran(capfd, "plan", *options, "--out", tmp_path / "out").code == 0
    motion = read_trajectory(tmp_path / "out")
    assert motion.timing is not None
    assert max(peak.jerk for peak in motion.timing.peaks) <= 50.0
    assert motion.settings["dt"] == 0.02
    assert motion.duration < 6.3


def test_a_plan_goes_all_the_way_to_mujoco(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert Ran(capfd, "plan", SCENE, "--out", tmp_path / "out", "--no-view").code == 0
    assert Ran(capfd, "verify", tmp_path / "out").code == 0
    assert Ran(capfd, "export", tmp_path / "out", "--format", "mujoco", "-o", tmp_path / "mujoco").code == 0
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "mujoco" / "scene.xml")).nu == 12


def test_among_obstacles_that_move_a_plan_keeps_its_timing(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    scene = json.loads(SCENE.read_text())
    scene["obstacles"][0]["velocity"] = [0.0, 0.0, -0.01]
    (tmp_path / "moving.json").write_text(json.dumps(scene))
    Ran(capfd, "plan", tmp_path / "moving.json", "--out", tmp_path / "out", "--no-view")
    assert read_trajectory(tmp_path / "out").timing is None


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--timing", "slow"], "timing is 'slow'; valid: one of fastest, paper"),
        (["--timing", "paper", "--jerk-limit", "10"], "jerk_limit is 10.0; valid: none but with --timing fastest"),
        (["--method", "qp", "--dwell", "1"], "dwell is 1.0; valid: none but with --timing fastest"),
        (["--jerk-limit", "-1"], "jerk_limit is -1.0"),
        (["--dwell", "nan"], "dwell is nan"),
        (["--speed", "1.5"], "speed is 1.5"),
        (["--speed", "0"], "speed is 0.0"),
        (["--timing", "paper", "--speed", "0.5"], "speed is 0.5; valid: none but with --timing fastest"),
        (["--set", "beta"], "NAME=VALUE"),
        (["--set", "gamma=1"], "gamma is"),
    ],
)
def test_bad_options_of_the_timing(options: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert_bad_input(Ran(capfd, "plan", SCENE, "--no-view", *options), said)


def test_the_longest_motion_is_that_of_the_motion(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--max-time", "1.5", "--speed", "0.5", "--out", tmp_path / "out", "--no-view"]
    assert Ran(capfd, "plan", SCENE, *options).code == 1
    motion = read_trajectory(tmp_path / "out")
    assert motion.status == "time_limit"
    assert motion.duration > 1.5


def test_half_the_speed_takes_twice_as_long(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    durations = []
    for speed in ("1", "0.5"):
        assert Ran(capfd, "plan", SCENE, "--speed", speed, "--out", tmp_path / speed, "--no-view").code == 0
        motion = read_trajectory(tmp_path / speed)
        assert motion.limits_ok
        durations.append(motion.duration)
    assert durations[1] == pytest.approx(2 * durations[0], abs=0.04)


def test_what_does_not_get_there_keeps_its_timing(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    far = {"name": "far", "targets": {"left": [-9.0, 0.0, 3.0], "right": None}}
    (tmp_path / "far.json").write_text(json.dumps(far))
    assert Ran(capfd, "plan", tmp_path / "far.json", "--out", tmp_path / "out", "--no-view").code == 1
    assert read_trajectory(tmp_path / "out").timing is None
    ran = Ran(capfd, "export", tmp_path / "out", "--format", "csv", "-o", tmp_path / "far.csv")
    assert "Mind: target_out_of_reach, the target of the left hand is 5.71 m out of reach" in ran.out
    assert "plan with --timing fastest" in ran.out


def test_the_robot_can_have_other_lengths(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--case", "3", "--set", "link_radius=0.02", "--set", "beta=1.0", "--out", tmp_path / "out", "--no-view"]
    Ran(capfd, "plan", *options)
    plan = read_plan(tmp_path / "out")
    assert plan.robot.urdf == load_robot(link_radius=0.02, beta=1.0).urdf
