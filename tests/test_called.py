"""Commands that messages name are there, and none of them compiles anything."""

from __future__ import annotations

import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

from humanoid_rail import HumanoidRailError, Robot, Scene
from humanoid_rail._called import command, pip_install
from humanoid_rail.cli.plan import how_to_see
from humanoid_rail.live import server


def folder_of_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a Python and a console command of its own, neither on PATH; its parent is at hand."""
    folder = tmp_path / "venv" / "bin"
    folder.mkdir(parents=True)
    monkeypatch.setattr(sys, "executable", str(folder / "python"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.defpath)
    return folder


def test_the_command_is_called_as_the_shell_finds_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = folder_of_commands(tmp_path, monkeypatch)
    assert command() == "venv/bin/python -m humanoid_rail"
    (folder / "humanoid-rail").write_text("#!/bin/sh\n", encoding="utf-8")
    (folder / "humanoid-rail").chmod(0o755)
    assert command() == "venv/bin/humanoid-rail"
    assert how_to_see("out/x") == "open out/x/playback.html, or venv/bin/humanoid-rail play out/x"
    monkeypatch.setenv("PATH", f"{folder}:{os.defpath}")
    assert command() == "humanoid-rail"
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    monkeypatch.setenv("PATH", os.defpath)
    assert command() == str(folder / "humanoid-rail")


def test_what_is_named_here_runs() -> None:
    ran = subprocess.run([*shlex.split(command()), "--help"], capture_output=True, text=True, check=True)
    assert "plan" in ran.stdout


def test_an_extra_is_installed_without_compiling(
    robot: Robot, scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder_of_commands(tmp_path, monkeypatch)
    assert pip_install("humanoid_rail[live]") == "venv/bin/python -m pip install 'humanoid_rail[live]'"
    monkeypatch.setattr(server, "find_spec", lambda _: None)
    said = r"viser: venv/bin/python -m pip install 'humanoid_rail\[live\]'"
    with pytest.raises(HumanoidRailError, match=said), server.serving(robot, scene):
        pass
    for page in (*(ROOT / "docs").glob("*.md"), ROOT / "README.md"):
        assert not re.search(r"--editable '?\.\[", page.read_text(encoding="utf-8")), page.name


def test_the_example_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(SystemExit, match=r"error: .* needs MuJoCo, .* -m pip install 'mujoco>=3\.3'"):
        runpy.run_path(str(ROOT / "examples" / "follow_mujoco.py"))
