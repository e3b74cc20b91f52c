"""The command that shows a robot."""

from __future__ import annotations

from pathlib import Path

import pytest
from running import Ran, assert_bad_input

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
