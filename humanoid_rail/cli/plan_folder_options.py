"""The argument and the options of commands that read a plan from its folder."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from humanoid_rail.cli.robot_options import NAMES, takes_a_robot

GROUP = {"Instead of what is in FOLDER": ("scene_file", *NAMES)}
"""The options have this heading as a group."""


def reads_a_plan(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the arguments of :func:`humanoid_rail.io.plan_folder.read_plan`."""
    for decorate in (
        takes_a_robot,
        click.option("--scene", "scene_file", metavar="FILE", help="Scene file, YAML or JSON."),
        click.argument("folder"),
    ):
        function = decorate(function)
    return function
