"""The console command, run as a user runs it: in this process, or in one of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from humanoid_rail.cli import commands
from humanoid_rail.cli.console import run

WITHOUT_ENGINE = """
import sys
sys.modules["humanoid_rail._engine"] = None  # importing it fails
from humanoid_rail.cli import main
main()
"""
"""The console command where the native engine is not there."""


class Ran:
    """What came of a command that ran in this process."""

    def __init__(self, capfd: pytest.CaptureFixture[str], *arguments: object) -> None:
        with pytest.raises(SystemExit) as caught:
            run(commands, [str(argument) for argument in arguments])
        self.code = caught.value.code
        self.out, self.err = capfd.readouterr()


def assert_bad_input(ran: Ran, said: str) -> None:
    assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1), ran.err
    assert ran.err.startswith("error: ")
    assert said in ran.err


def without_display() -> dict[str, str]:
    """Return the environment of this process, but where no browser can be opened."""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return {**environment, "PYTHONUNBUFFERED": "1"}


def started(*arguments: object, cwd: Path) -> subprocess.Popen[str]:
    """Start the command in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "humanoid_rail", *map(str, arguments)],
        cwd=cwd,
        env=without_display(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ran_without_engine(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command in a process that has no native engine."""
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_ENGINE, *map(str, arguments)],
        cwd=cwd,
        env=without_display(),
        capture_output=True,
        text=True,
        check=False,
    )
