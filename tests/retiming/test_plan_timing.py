"""How `humanoid-rail plan` times what it plans."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest
from conftest import ROOT
from running import Ran, assert_bad_input

from humanoid_rail import Retiming, load_robot, read_trajectory, verify
from humanoid_rail.io.plan_folder import read_plan

SCENE = ROOT / "scenes" / "dev" / "sparse-80000.json"


def test_a_retimed_plan_is_for_drives(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd, "plan", SCENE, "--retime", "--out", tmp_path / "out", "--no-view")
    assert ran.code == 0
    assert "peak acceleration" in ran.out
    motion = read_trajectory(tmp_path / "out")
    assert motion.timing is not None
    assert not motion.timing.velocity[[0, -1]].any()
    assert motion.certified
    assert motion.reason == f"at the targets at t = {motion.duration:.4g} s"
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["peaks"][0]["jerk_limit"] is None


@pytest.mark.parametrize("method", ["auto", "qp", "gradient-projection"])
def test_a_plan_has_the_timing_of_its_method_unless_told_otherwise(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], method: str
) -> None:
    quick = ["--no-optimise"] if method == "auto" else []
    ran = Ran(capfd, "plan", SCENE, "--method", method, *quick, "--out", tmp_path / "own", "--no-view")
    assert "the method's own; retime it before a drive runs it" in ran.out
    Ran(capfd, "plan", SCENE, "--method", method, *quick, "--retime", "--out", tmp_path / "fastest", "--no-view")
    own, fastest = read_trajectory(tmp_path / "own"), read_trajectory(tmp_path / "fastest")
    assert own.timing is None
    assert own.provenance.retiming is None
    assert fastest.timing is not None
    assert fastest.provenance.retiming == Retiming(dt=0.01, speed=1.0, dwell=0.0)
    if method == "auto":  # its own timing is the fastest without limits of acceleration
        assert own.duration < fastest.duration
    np.testing.assert_array_equal(own.q[[0, -1]], fastest.q[[0, -1]])


def test_a_plan_by_auto_is_of_least_time(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd, "plan", SCENE, "--out", tmp_path / "out", "--no-view")
    assert ran.code == 0
    assert "of least time" in ran.out
    assert "times the lower bound" in ran.out
    motion = read_trajectory(tmp_path / "out")
    assert motion.timing is not None
    assert motion.provenance.optimisation is not None
    assert motion.provenance.optimisation.optimised == 1
    assert motion.provenance.optimisation.steps > 1
    assert motion.provenance.retiming is None
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert 0.9 * motion.duration < summary["least_duration"] < motion.duration
    assert summary["least_duration"] == pytest.approx(motion.least_duration)
    cut = Ran(capfd, "plan", SCENE, "--max-optimisation-steps", "0", "--out", tmp_path / "path", "--no-view")
    assert "as fast along its path" in cut.out
    assert read_trajectory(tmp_path / "path").duration > motion.duration


def test_cases_can_be_retimed_too(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--case", "3", "--dt", "0.02", "--no-view"]
    assert Ran(capfd, "plan", *options, "--out", tmp_path / "own").code == 0
    assert read_trajectory(tmp_path / "own").timing is None
    options += ["--retime", "--jerk-limit", "50"]
    assert Ran(capfd, "plan", *options, "--out", tmp_path / "out").code == 0
    motion = read_trajectory(tmp_path / "out")
    assert motion.timing is not None
    assert max(peak.jerk for peak in motion.timing.peaks) <= 50.0
    assert motion.method.dt == 0.02
    np.testing.assert_allclose(np.diff(motion.t), 0.02, rtol=1e-9)
    assert motion.duration < 6.3


def test_a_plan_goes_all_the_way_to_mujoco(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert Ran(capfd, "plan", SCENE, "--retime", "--out", tmp_path / "out", "--no-view").code == 0
    assert Ran(capfd, "verify", tmp_path / "out").code == 0
    assert Ran(capfd, "export", tmp_path / "out", "--format", "mujoco", "-o", tmp_path / "mujoco").code == 0
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "mujoco" / "scene.xml")).nu == 12


def test_among_obstacles_that_move_too_a_motion_is_certified_afresh(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    scene = json.loads(SCENE.read_text())
    scene["obstacles"][0]["velocity"] = [0.0, 0.0, -0.01]
    (tmp_path / "moving.json").write_text(json.dumps(scene))
    for name, options in (("own", []), ("fastest", ["--retime"])):
        Ran(capfd, "plan", tmp_path / "moving.json", *options, "--out", tmp_path / name, "--no-view")
        motion = read_trajectory(tmp_path / name)
        assert (motion.timing is None) == (name == "own")
        plan = read_plan(tmp_path / name)
        assert motion.certificate == verify(plan.robot, plan.scene, motion)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--jerk-limit", "10"], "--jerk-limit needs --retime"),
        (["--method", "qp", "--dwell", "1"], "--dwell needs --retime"),
        (["--case", "3", "--speed", "0.5"], "--speed needs --retime"),
        (["--retime", "--jerk-limit", "-1"], "jerk_limit is -1.0"),
        (["--retime", "--dwell", "nan"], "dwell is nan"),
        (["--retime", "--speed", "1.5"], "speed is 1.5"),
        (["--retime", "--speed", "0"], "speed is 0.0"),
        (["--set", "beta"], "NAME=VALUE"),
        (["--set", "gamma=1"], "argument is 'gamma'"),
    ],
)
def test_bad_options_of_the_timing(options: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    scene = [] if "--case" in options else [SCENE]
    assert_bad_input(Ran(capfd, "plan", *scene, "--no-view", *options), said)


def test_the_longest_motion_is_that_of_the_motion(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--retime", "--max-time", "1.5", "--speed", "0.5", "--out", tmp_path / "out", "--no-view"]
    assert Ran(capfd, "plan", SCENE, *options).code == 1
    motion = read_trajectory(tmp_path / "out")
    assert motion.status == "time_limit"
    assert motion.duration > 1.5


def test_half_the_speed_takes_twice_as_long(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    durations = []
    for speed in ("1", "0.5"):
        assert Ran(capfd, "plan", SCENE, "--retime", "--speed", speed, "--out", tmp_path / speed, "--no-view").code == 0
        motion = read_trajectory(tmp_path / speed)
        assert motion.limits_ok
        durations.append(motion.duration)
    assert durations[1] == pytest.approx(2 * durations[0], abs=0.04)


def test_what_does_not_get_there_is_timed_as_far_as_it_got(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    far = {"name": "far", "targets": {"left": [-9.0, 0.0, 3.0], "right": None}}
    (tmp_path / "far.json").write_text(json.dumps(far))
    warnings = []
    for name, options in (("own", []), ("fastest", ["--retime"])):
        ran = Ran(capfd, "plan", tmp_path / "far.json", *options, "--out", tmp_path / name, "--no-view")
        assert ran.code == 1
        motion = read_trajectory(tmp_path / name)
        assert motion.status == "target_out_of_reach"
        assert motion.arrivals == ()
        assert (motion.timing is None) == (name == "own")
        ran = Ran(capfd, "export", tmp_path / name, "--format", "csv", "-o", tmp_path / f"{name}.csv")
        assert "Warning: target_out_of_reach, the target of the left hand is 5.71 m out of reach" in ran.out
        warnings.append("plan with --retime for a drive" in ran.out)
    assert warnings == [True, False]


def test_the_robot_can_have_other_lengths(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--case", "3", "--set", "link_radius=0.02", "--set", "beta=1.0", "--out", tmp_path / "out", "--no-view"]
    Ran(capfd, "plan", *options)
    plan = read_plan(tmp_path / "out")
    assert plan.robot.urdf == load_robot(link_radius=0.02, beta=1.0).urdf
