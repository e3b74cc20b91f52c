"""The help of the console command `humanoid-rail`."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import click
import pytest
from conftest import ROOT
from running import Ran

import humanoid_rail.cli
from humanoid_rail.cli import COMMANDS, commands

LIGHT = {"click", "humanoid_rail", "lazy_loader"}
"""All that the help of the command may import beside Python's own library."""
BESIDE = {"console", "plan_folder_options", "plan_options", "report", "robot_options", "streams"}
"""The modules of the command line that are no commands."""


def test_the_help_lists_every_command_and_loads_nothing_for_it(tmp_path: Path) -> None:
    code = """
import sys
before = set(sys.modules)
from humanoid_rail.cli import main
sys.argv = ["humanoid-rail", "--help"]
try:
    main()
finally:
    foreign = {name.partition(".")[0] for name in set(sys.modules) - before} - sys.stdlib_module_names
    print(*sorted(foreign))
"""
    result = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    *text, foreign = result.stdout.splitlines()
    assert {"click", "humanoid_rail"} <= set(foreign.split()) <= LIGHT
    listed = re.findall(r"^  (\w+)  +\S.*\.$", "\n".join(text).partition("Commands:")[2], re.MULTILINE)
    assert listed == ["plan", "play", "compare", "live", "verify", "export", "robot", "urdf"] == list(COMMANDS)


def test_every_module_of_the_command_line_is_a_command_or_known_to_be_none() -> None:
    modules = {module.name for module in iter_modules(humanoid_rail.cli.__path__)}
    assert modules == set(COMMANDS) | BESIDE
    for name in COMMANDS:
        assert isinstance(import_module(f"humanoid_rail.cli.{name}").command, click.Command)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_a_command_says_what_it_does_gives_examples_and_explains_every_option(name: str) -> None:
    command = commands.get_command(click.Context(commands), name)
    context = click.Context(command, info_name=name, max_content_width=120)
    text = command.get_help(context)
    assert len(command.help.splitlines()[0]) > 20
    assert f"  humanoid-rail {name} " in text.partition("Examples:")[2]
    for parameter in command.get_params(context):
        if isinstance(parameter, click.Option):
            assert len(parameter.help) > 10, parameter.name
            assert len(re.findall(rf"^  .*{parameter.opts[0]}\b", text, re.MULTILINE)) >= 1, parameter.name
            assert " ".join(text.split()).count(" ".join(parameter.help.split())) == 1, parameter.name
    assert max(len(line) for line in text.splitlines()) <= 120


@pytest.mark.parametrize("name", COMMANDS)
def test_the_examples_of_the_help_are_commands(name: str) -> None:
    command = commands.get_command(click.Context(commands), name)
    for line in command.examples:
        program, called, *arguments = re.findall(r"'([^']*)'|(\S+)", line)
        assert (program[1], called[1]) == ("humanoid-rail", name)
        command.make_context(name, [quoted or plain for quoted, plain in arguments])  # parses, and runs nothing


def test_without_a_command_there_is_help(capfd: pytest.CaptureFixture[str]) -> None:
    ran = Ran(capfd)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == Ran(capfd, "--help").out
    assert Ran(capfd, "--version").out.startswith("humanoid_rail 0.")


def test_the_console_command_is_that_of_the_module() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    module, _, name = project["scripts"]["humanoid-rail"].partition(":")
    assert getattr(import_module(module), name) is humanoid_rail.cli.main
