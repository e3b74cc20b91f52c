"""The command that shows a robot."""

from __future__ import annotations

from pathlib import Path

import pytest
from running import Ran, assert_bad_input, started

from humanoid_rail import build_urdf


def test_a_robot_is_described_and_shown(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "own.urdf").write_text(build_urdf(), encoding="utf-8")
    page = tmp_path / "page.html"
    hands = ["--hands", "left=left_hand", "--hands", "right=right_hand"]
    ran = Ran(capfd, "robot", tmp_path / "own.urdf", *hands, "--out", page, "--no-view")
    assert ran.code == 0, ran.err
    assert "left_hand" in ran.out
    assert "waist_yaw" in ran.out
    assert f"The page is {page}." in ran.out
    assert 'id="slider-11"' in page.read_text(encoding="utf-8")


def test_the_paper_s_robot_without_a_page(capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd, "robot", "--no-view")
    assert (ran.code, ran.err) == (0, "")
    assert "humanoid_rail" in ran.out
    assert "The page is" not in ran.out


def test_what_is_wrong_is_said(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert_bad_input(Ran(capfd, "robot", "--srdf", "a.srdf"), "srdf")
    assert_bad_input(Ran(capfd, "robot", "x.urdf", "--hands", "left"), "NAME=FRAME")
    assert_bad_input(Ran(capfd, "robot", tmp_path / "none.urdf"), "none.urdf")
    assert_bad_input(Ran(capfd, "robot", "--no-view", "--out", tmp_path), "out")


def test_warnings_are_lines_of_stderr_and_a_page_is_offered(tmp_path: Path) -> None:
    (tmp_path / "own.urdf").write_text(build_urdf(), encoding="utf-8")
    hands = ["--hands", "left=left_hand", "--hands", "right=right_hand"]
    out, errors = (process := started("robot", "own.urdf", *hands, cwd=tmp_path)).communicate()
    assert process.returncode == 0, errors
    lines = errors.splitlines()
    assert lines
    assert all(line.startswith("Warning: ") and ".py" not in line for line in lines)
    assert len(set(lines)) == len(lines)
    assert "--out FILE writes the page" in out


def test_another_robot_needs_a_scene(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text("urdf: own.urdf\nhands: {left: left_hand}\n", encoding="utf-8")
    (tmp_path / "own.urdf").write_text(build_urdf(), encoding="utf-8")
    # Python writes the warning to stderr where nobody catches it, and then it is not one line.
    with pytest.warns(UserWarning, match="no collision body"):
        ran = Ran(capfd, "plan", "--robot", tmp_path)
    assert_bad_input(ran, "scene is missing; valid: a SCENE for this robot")
