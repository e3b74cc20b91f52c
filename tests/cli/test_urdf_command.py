"""The command that writes the URDF of the paper's robot."""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT
from running import Ran, assert_bad_input

from humanoid_rail import build_urdf


def test_urdf_prints_what_the_planner_has(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert Ran(capfd, "urdf").out == build_urdf()
    thick = Ran(capfd, "urdf", "beta=1.0", "--link-radius", "0.08").out
    assert thick == build_urdf(beta=1.0, link_radius=0.08) == Ran(capfd, "urdf", "link_radius=0.08", "beta=1").out
    ran = Ran(capfd, "urdf", "--srdf", "-o", tmp_path / "new" / "robot.srdf")
    assert (ran.code, ran.out) == (0, "")
    expected = (ROOT / "robots" / "humanoid_rail.srdf").read_text(encoding="utf-8")
    assert (tmp_path / "new" / "robot.srdf").read_text(encoding="utf-8") == expected


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["wings=2"], "argument is 'wings'; valid: one of the xacro arguments beta, "),
        (["beta"], "argument is 'beta'; valid: NAME=VALUE"),
        (["beta=pi"], "argument is 'beta=pi'"),
        (["beta=1", "beta=2"], "beta is '2'; valid: given once"),
        (["link_radius=0.1", "--link-radius", "0.1"], "link_radius is '0.1'; valid: given once"),
        (["--link-radius", "-1"], "link_radius is -1.0"),
        (["--srdf", "beta=1"], "srdf is 'beta=1'"),
        (["-o", "file/below"], "out is 'file/below'"),
    ],
)
def test_bad_arguments_of_the_robot_are_one_line(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    assert_bad_input(Ran(capfd, "urdf", *arguments), said)
    assert (tmp_path / "file").read_text() == "mine"
