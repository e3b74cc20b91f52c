"""Reasons name the options that they come from, with their values; tables do not say more than is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import AHEAD, ROOT
from running import Ran

from humanoid_rail import Auto, GradientProjection, Robot, SafeVelocity, Scene, Sphere, load_scene, plan, retime
from humanoid_rail.cli.report import report_plan

ROUND = Scene(name="round", targets=5 * (AHEAD, {"left": (-1.6, 0.9, 3.4), "right": (-1.6, 2.5, 3.4)}))


def reason(robot: Robot, scene: Scene, method: object) -> tuple[str, str]:
    trajectory = plan(robot, scene, method)
    return trajectory.status, trajectory.reason


def test_limits_of_time_are_named_with_their_value(robot: Robot) -> None:
    once = Scene(name="once", targets=AHEAD)
    for method in (Auto(max_time=0.3), SafeVelocity(max_time=0.3), GradientProjection(max_time=0.3)):
        assert reason(robot, once, method)[0] == "time_limit"
        assert "max_time = 0.3 s" in reason(robot, once, method)[1]
    # The second segment has less time than that left, and the reason gives the option's value all the same.
    first = plan(robot, once).duration
    status, why = reason(robot, ROUND, Auto(max_time=first + 0.05))
    assert status == "time_limit"
    assert f"max_time = {first + 0.05:g} s" in why
    assert why.startswith("step 2 of 10")


def test_a_cut_off_names_its_option_and_the_step(robot: Robot) -> None:
    status, why = reason(robot, ROUND, Auto(max_planning_time=1e-9))
    assert status == "planning_timeout"
    assert "max_planning_time = 1e-09 s" in why
    assert why.startswith("step 1 of 10")


def test_tolerance_budget_and_safety_distance_are_named(robot: Robot) -> None:
    once = Scene(name="once", targets=AHEAD)
    assert "tolerance = 0.02 m" in reason(robot, once, SafeVelocity(tolerance=0.02))[1]
    x, y, z = AHEAD["left"]
    near = Scene(name="near", targets=AHEAD, obstacles=(Sphere(center=(x, y, z - 0.2), radius=0.1),))
    status, why = reason(robot, near, Auto(safety_distance=0.08))
    assert status == "target_in_collision"
    assert "safety_distance = 0.08 m" in why
    deep = load_scene(ROOT / "scenes/dev/deep-500004.json")
    status, why = reason(robot, deep, Auto(max_edge_checks=20))
    assert status == "stuck"
    assert "max_edge_checks = 20" in why


def test_a_retimed_motion_that_takes_too_long_names_the_option(robot: Robot) -> None:
    once = Scene(name="once", targets=AHEAD)
    retimed = retime(plan(robot, once), robot, once, max_time=0.1)
    assert "max_time = 0.1 s" in retimed.reason


@pytest.mark.parametrize(("longest", "is_whole"), [(60.0, True), (0.3, False)])
def test_tables_of_motions_that_end_early_say_so(
    robot: Robot, capsys: pytest.CaptureFixture[str], longest: float, is_whole: bool
) -> None:
    report_plan("a plan", plan(robot, Scene(name="once", targets=AHEAD), Auto(max_time=longest)))
    said = " ".join(capsys.readouterr().out.split())
    assert ("│ yes, as far as the motion goes: no " in said) != is_whole
    assert ("│ kept, as far as the motion goes: position" in said) != is_whole


def test_the_table_of_a_plan_that_failed_is_read_in_a_terminal_of_80_columns(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    scene = ROOT / "scenes" / "unsolvable" / "target_in_collision-7.yaml"
    lines = Ran(capfd, "plan", scene, "--out", tmp_path, "--no-page", "--no-view").out.splitlines()
    rows = [line[1:-1].partition("│") for line in lines if line.startswith("│")]
    labels = {label.strip(): text.strip() for label, _, text in rows}
    assert max(len(label) for label in labels) <= 15
    assert len(lines) <= 36
    assert labels["no body"] == ", ".join(robot.links_without_body[:4]) + " and 8 more"
    assert labels["left out"] == "carriage and lower_torso and 8 more pairs, near joints"
    (written,) = [line for line in lines if line.startswith("Written to")]
    assert written.count(str(tmp_path)) == 1
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["certificate"]["links_without_body"] == list(robot.links_without_body)
    assert len(summary["certificate"]["unchecked_pairs"]) == 9


def test_joints_that_a_velocity_limit_of_0_holds_are_named(robot: Robot) -> None:
    once = Scene(name="once", targets=AHEAD)
    still = replace(robot, velocity_limit=np.zeros(robot.n))
    held = "velocity limit of 0 and stay where they are: " + ", ".join(robot.joint_names)
    for method in (Auto(), SafeVelocity()):
        assert held in reason(still, once, method)[1]
    some = np.where(np.arange(robot.n) == 0, 0.0, robot.velocity_limit)
    far = Scene(name="far", targets={"left": (-1.6, 8.0, 3.4), "right": None})
    assert reason(replace(robot, velocity_limit=some), far, Auto())[1].endswith("where they are: rail")
    assert "velocity limit" not in reason(robot, far, Auto(max_time=0.1))[1]
